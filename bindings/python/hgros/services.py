"""Calling services and offering them."""

from __future__ import annotations

import threading
from typing import Any, Callable, Generator, Generic, TypeVar

from google.protobuf.message import Message

from . import _hgros
from .callbacks import Handler
from .errors import Error
from .message_types import decoder
from .readable import told
from .stream import until_woken

R = TypeVar("R")


class CallError(Error):
    """A call that got no reply. `kind` is "no server", "timed out", "handler failed", "server gone", "type mismatch",
    "full", "cancelled", "would deadlock", "not writable" or "closed"."""

    def __init__(self, kind: str, reason: str) -> None:
        super().__init__(reason or kind)
        self.kind = kind


class Call(Generic[R]):
    """A reply that may still come: `call.result()`, or `await call` in asyncio. Dropping it ignores the reply.

    Ctrl-C in `result`, and cancelling a task that awaits it, cancel the call.
    """

    def __init__(self, begin: Callable[[_hgros.Inbox], _hgros.CallTicket], name: str, reply_type: type[Message] | None,
                 deadlocks: bool) -> None:
        self._name = name
        self._reply_type = reply_type
        self._deadlocks = deadlocks
        self._ready = _hgros.ReadyList()
        self._inbox = _hgros.Inbox(self._ready, 0)
        self._reply: Any = None
        self._failure: tuple[str, str] | None = None  # No exception: it would keep this call, and its request.
        self._ended = False
        self._lock = threading.Lock()
        self._ticket = begin(self._inbox)

    def done(self) -> bool:
        return self._end()

    def cancel(self) -> None:
        """Ends the call with CallError "cancelled", unless it has ended."""
        self._ticket.cancel()

    def result(self) -> R:
        """Waits for the reply and returns it. Raises CallError if there is none."""
        if self._deadlocks and not self._end():
            self.cancel()
            raise CallError("would deadlock", f'The service "{self._name}" of this session is handled by the thread that '
                            "waits for it. Call it from another thread.")
        try:
            while not self._end():
                self._ready.wait(-1.0)
        except BaseException:
            self.cancel()
            raise
        return self._value()

    def __await__(self) -> Generator[Any, None, R]:
        return self._awaited().__await__()

    async def _awaited(self) -> R:
        try:
            while not self._end():
                await until_woken(self._ready)
        except BaseException:
            self.cancel()
            raise
        return self._value()

    def _end(self) -> bool:
        self._ticket.refuse_in_child()
        with self._lock:
            if not self._ended and (taken := self._inbox.take(1)):
                wire, schema, kind, reason = taken[0]
                if kind:
                    self._failure = kind, reason
                else:
                    try:
                        self._reply = decoder(schema, self._reply_type, self._name)(wire)
                    except Exception as fault:
                        self._failure = "not writable", f"The reply cannot be read: {fault}"
                self._ended = True
                self._ready.end()  # Others may wait, too.
            return self._ended

    def _value(self) -> R:
        if self._failure is not None:
            raise CallError(*self._failure)
        value: R = self._reply
        return value


class Service(Handler):
    """Offers a service; made by `Session.serve`. `failed` counts handlers that raised an exception.

    At its end, requests that wait fail.
    """

    def __init__(self, raw: _hgros.Service, inbox: _hgros.Inbox, name: str, request_type: type[Message],
                 reply_type: type[Message], handler: Callable[[Any], Message], end: Callable[[], None]) -> None:
        super().__init__(raw, handler, end)
        self.name = name
        self._inbox = inbox
        self._request_type = request_type
        self._reply_type = reply_type

    def handle_some(self) -> bool:
        for wire, schema, answer in self._inbox.take(1):
            self._run += 1
            try:
                request = decoder(schema, self._request_type, self.name)(wire)
                reply = self.callback(request)
                if type(reply) is not self._reply_type:
                    raise TypeError(f'The handler of service "{self.name}" must return '
                                    f"{self._reply_type.DESCRIPTOR.full_name}, not {type(reply).__name__}.")
                answer.reply(reply.SerializeToString())
            except BaseException as fault:
                if isinstance(fault, Exception):
                    self._fails(f'The handler of service "{self.name}"')
                else:
                    self.failed += 1
                answer.fail(told(fault))
                if not isinstance(fault, Exception):
                    raise
        return False
