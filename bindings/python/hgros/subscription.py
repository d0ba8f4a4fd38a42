"""Subscriptions: from an inbox to a callback."""

from __future__ import annotations

from typing import Any, Callable

from google.protobuf.message import DecodeError, Message

from . import _hgros
from .callbacks import Handler
from .errors import Error
from .log_relay import logger
from .message_types import Decode, decoder

_AT_ONCE = 32


class Reader:
    """Takes messages out of an inbox and decodes them, each publisher's by its own schema."""

    def __init__(self, inbox: _hgros.Inbox, channel: str, wanted: type[Message] | None) -> None:
        self.channel = channel
        self.not_decoded = 0
        self._inbox = inbox
        self._wanted = wanted
        self._decode: Decode | None = None
        self._refused: set[tuple[str, int]] = set()
        self.more = False  # Whether others wait behind the last one.

    def next(self) -> tuple[Any, _hgros.MessageInfo] | None:
        """The next message that can be read; None if no more wait."""
        while (taken := self._inbox.next()) is not None:
            wire, schema, info, self.more = taken
            if schema is not None:
                self._use(schema, info)
            if self._decode is not None:
                try:
                    return self._decode(wire), info
                except DecodeError as fault:
                    logger.warning('A message on channel "%s" cannot be read: %s', self.channel, fault)
            self.not_decoded += 1
            self._inbox.skip()
        self.more = False
        return None

    def finish(self, failed: bool) -> None:
        """The message was handled. Otherwise that is so when the next one is taken."""
        self._inbox.finish(failed)

    def _use(self, schema: _hgros.Schema, info: _hgros.MessageInfo) -> None:
        self._decode = None  # Never that of another publisher.
        try:
            self._decode = decoder(schema, self._wanted, self.channel)
        except Exception as fault:
            kind = (schema.type_name, schema.fingerprint)
            if kind not in self._refused:
                self._refused.add(kind)
                if isinstance(fault, Error):
                    logger.error("%s They come from session %016x.", fault, info.publisher)
                else:
                    logger.exception('Messages on channel "%s" of type %s cannot be read.', self.channel, schema.type_name)


class Subscription(Handler):
    """Calls a callback with the messages of a channel; made by `Session.subscribe`.

    `failed` counts callbacks that raised an exception, which is logged with its traceback. `not_decoded` counts messages
    that were not of the type, or no messages.
    """

    _raw: _hgros.Subscription | None

    def __init__(self, raw: _hgros.Subscription, reader: Reader, callback: Callable[[Any, _hgros.MessageInfo], object],
                 end: Callable[[], None]) -> None:
        super().__init__(raw, callback, end)
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

    def end(self) -> None:
        """Ends the subscription. Does nothing if it has ended."""
        if (raw := self._raw) is not None and not raw.of_parent:
            self._last = (self._last[0], raw.received, raw.dropped)
        super().end()

    def handle_some(self) -> bool:
        reader, callback = self._reader, self.callback
        for _ in range(_AT_ONCE):
            if self._raw is None or (found := reader.next()) is None:
                return False
            self.run += 1
            failed = True
            try:
                callback(*found)
                failed = False
            except Exception:
                self._fails(f'A callback of channel "{self.channel}"')
            except BaseException:
                self.failed += 1
                raise
            finally:
                _hgros.leave_callback()
                reader.finish(failed)
            if not reader.more:
                return False
        return True

    def __repr__(self) -> str:
        return f"Subscription({self.channel!r}, {'active' if self.active else 'ended'})"
