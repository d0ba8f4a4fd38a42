"""Subscriptions: from an inbox to a callback."""

from __future__ import annotations

import sys
from typing import Any, Callable

from google.protobuf.message import DecodeError, Message

from . import _hgros
from .callbacks import Handler
from .errors import Error
from .log_relay import logger
from .message_types import Decode, decoder, made_by

AnyCallback = Callable[[Any, _hgros.MessageInfo], object]
KnownType = tuple[Decode, type[Message] | None, list[Any]]  # See Inbox.run_known().
Known = tuple[_hgros.Inbox, KnownType, AnyCallback, Any]  # What ReadyList.run() needs for callbacks.
_AT_ONCE = 32
_MOST_TOLD = 100
_NONE, _MORE, _OTHER = range(3)  # What Inbox.run_known() returns.


class Reader:
    """Takes messages out of an inbox and decodes them, each publisher's by its own schema."""

    def __init__(self, session: _hgros.Session, inbox: _hgros.Inbox, channel: str, wanted: type[Message] | None) -> None:
        self.channel = channel
        self.not_decoded = 0
        self._session = session
        self._inbox = inbox
        self._wanted = wanted
        self._type: KnownType | None = None
        self._refused: set[tuple[str, int]] = set()
        self._unreadable: set[int] = set()  # Publishers.
        self.more = False  # Whether others wait behind the last one.

    def next(self) -> tuple[Any, _hgros.MessageInfo] | None:
        """The next message that can be read; None if no more wait."""
        while (taken := self._inbox.next()) is not None:
            wire, schema, info, self.more = taken
            if schema is not None:
                self._use(schema, info)
            if self._type is not None:
                try:
                    return self._type[0](wire), info
                except Exception:
                    self._log_unreadable(info.publisher)
            self.not_decoded += 1
            self._inbox.skip()
        self.more = False
        return None

    def run_known(self, callback: AnyCallback) -> int:
        """Calls it with messages of the schema of the last one; returns what is left. Raises what the callback raises."""
        return _OTHER if self._type is None else self._inbox.run_known(self._type, callback, _AT_ONCE)

    def for_callback(self, callback: AnyCallback, handler: Any) -> Known | None:
        """What ReadyList.run() needs to call it with messages of the schema of the last one; None if that is not read."""
        return None if self._type is None else (self._inbox, self._type, callback, handler)

    def take_fault(self) -> bool:
        """Whether what is being handled was raised in place of a message, which is then left out, not by a callback."""
        publisher = self._inbox.take_undecoded()
        if publisher is None:
            return False
        self.not_decoded += 1
        if not isinstance(sys.exc_info()[1], Exception):
            raise
        self._log_unreadable(publisher)
        return True

    @property
    def ran(self) -> int:
        """How many callbacks run_known() has begun."""
        return self._inbox.ran

    def _log_unreadable(self, publisher: int) -> None:
        """Once for each publisher, so that a stream of them writes one line."""
        if publisher in self._unreadable or len(self._unreadable) == _MOST_TOLD:
            return
        self._unreadable.add(publisher)
        fault = sys.exc_info()[1]
        logger.warning('A message on channel "%s" from %s cannot be read: %s. Further ones are only counted.',
                       self.channel, self._name_of(publisher), str(fault).rstrip("."),
                       exc_info=not isinstance(fault, DecodeError))

    def _name_of(self, publisher: int) -> str:
        try:
            return self._session.name_of(publisher)
        except Error:  # The session is being closed.
            return f"{publisher:016x}"

    def finish(self, failed: bool) -> None:
        """The message was handled. Otherwise that is so when the next one is taken."""
        self._inbox.finish(failed)

    def _use(self, schema: _hgros.Schema, info: _hgros.MessageInfo) -> None:
        self._type = None  # Never that of another publisher.
        try:
            decode = decoder(schema, self._wanted, self.channel)
            self._type = (decode, made_by(decode), [])
        except Exception as fault:
            kind = (schema.type_name, schema.fingerprint)
            if kind not in self._refused:
                self._refused.add(kind)
                if isinstance(fault, Error):
                    logger.error("%s %s publishes them.", fault, self._name_of(info.publisher))
                else:
                    logger.exception('Messages on channel "%s" of type %s cannot be read.', self.channel, schema.type_name)


class Subscription(Handler):
    """Calls a callback with the messages of a channel; made by `Session.subscribe`.

    `failed` counts callbacks that raised an exception, which is logged with its traceback. `not_decoded` counts messages
    that were not of the type, or no messages.
    """

    _raw: _hgros.Subscription | None

    def __init__(self, raw: _hgros.Subscription, reader: Reader, callback: AnyCallback, end: Callable[[], None],
                 on_known: Callable[[Known | None], None] | None = None) -> None:
        super().__init__(raw, callback, end)
        self._on_known = on_known
        self._last = (raw.name, 0, 0)
        self._reader = reader

    @property
    def channel(self) -> str:
        return self._reader.channel

    @property
    def name(self) -> str:
        """The name of the node, in `hgros list` and in the configuration."""
        return self._last[0]

    @property
    def received(self) -> int:
        """Messages that came, also those that were dropped later."""
        return self._raw.received if self._raw is not None else self._last[1]

    @property
    def dropped(self) -> int:
        """Messages that a KeepLast queue dropped because newer ones came."""
        return self._raw.dropped if self._raw is not None else self._last[2]

    @property
    def not_decoded(self) -> int:
        return self._reader.not_decoded

    @property
    def run(self) -> int:
        return self._run + self._reader.ran

    def end(self) -> None:
        """Ends the subscription. Does nothing if it has ended."""
        if (raw := self._raw) is not None and not raw.of_parent:
            self._last = (self._last[0], raw.received, raw.dropped)
        super().end()

    def handle_some(self) -> bool:
        reader = self._reader
        for _ in range(_AT_ONCE):
            if self._raw is None:
                return False
            try:
                if (left := reader.run_known(self.callback)) != _OTHER:
                    return left == _MORE
                found = reader.next()
                if self._on_known is not None:
                    self._on_known(reader.for_callback(self.callback, self))
                if found is None:
                    return False
                self._call(found)
            except BaseException:
                self.take_fault()
        return True

    def take_fault(self) -> None:
        """Called while an exception of the callback or of a message is handled."""
        if self._reader.take_fault():
            return
        # No variable keeps the exception: it would keep itself, and the callback's message.
        if not isinstance(sys.exc_info()[1], Exception):
            self.failed += 1
            raise
        self._fails(f'A callback of channel "{self.channel}"')

    def _call(self, found: tuple[Any, _hgros.MessageInfo]) -> None:
        self._run += 1
        failed = True
        try:
            self.callback(*found)
            failed = False
        finally:
            _hgros.leave_callback()
            self._reader.finish(failed)

    def __repr__(self) -> str:
        return f"Subscription({self.channel!r}, {'active' if self.active else 'ended'})"
