"""Messages of a channel as an iterator, with `for` and with `async for`."""

from __future__ import annotations

import time
import weakref
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from . import _hgros
from .subscription import Reader

if TYPE_CHECKING:
    import asyncio

M = TypeVar("M")


async def until_woken(ready: _hgros.ReadyList) -> None:
    """Waits in the running event loop until there is something to take."""
    import asyncio

    loop = asyncio.get_running_loop()
    woken: asyncio.Future[None] = loop.create_future()
    descriptor = ready.fileno()
    # A loop has one reader for a descriptor, and several tasks may wait.
    waiting = _waiting.setdefault(loop, {}).setdefault(descriptor, [])
    waiting.append(woken)
    if len(waiting) == 1:
        loop.add_reader(descriptor, _wake, waiting)
    try:
        await woken
    finally:
        waiting.remove(woken)
        if not waiting:
            loop.remove_reader(descriptor)
            del _waiting[loop][descriptor]


# By descriptor.
_waiting: weakref.WeakKeyDictionary[asyncio.AbstractEventLoop, dict[int, list[asyncio.Future[None]]]] = (
    weakref.WeakKeyDictionary())


def _wake(waiting: list[asyncio.Future[None]]) -> None:
    for woken in waiting:
        if not woken.done():  # It may have ended meanwhile.
            woken.set_result(None)


class Messages(Generic[M]):
    """The messages of a channel, one after the other; made by `Session.messages`.

    The iteration ends when no message comes for `timeout` seconds, and when the session is closed. It can be continued.
    `info` belongs to the last message. The subscription ends with close(), with a `with` block, or with the object.
    """

    def __init__(self, raw: _hgros.Subscription, ready: _hgros.ReadyList, reader: Reader, timeout: float | None) -> None:
        self.info: _hgros.MessageInfo | None = None
        self.timeout = timeout
        self._raw: _hgros.Subscription | None = raw
        self._ready = ready
        self._reader = reader
        self._dropped = 0

    @property
    def channel(self) -> str:
        return self._reader.channel

    @property
    def dropped(self) -> int:
        """Messages that a KeepLast queue dropped because newer ones came."""
        return self._raw.dropped if self._raw is not None else self._dropped

    @property
    def not_decoded(self) -> int:
        return self._reader.not_decoded

    def __iter__(self) -> Messages[M]:
        return self

    def __next__(self) -> M:
        if (found := self._take()) is not None:
            return found
        deadline = None if self.timeout is None else time.monotonic() + self.timeout
        while self._raw is not None:
            left = -1.0 if deadline is None else max(0.0, deadline - time.monotonic())
            self._ready.wait(left)
            if (found := self._take()) is not None:
                return found
            if deadline is not None and time.monotonic() >= deadline:
                break
        raise StopIteration

    def __aiter__(self) -> Messages[M]:
        return self

    async def __anext__(self) -> M:
        import asyncio

        if (found := self._take()) is not None:
            return found
        loop = asyncio.get_running_loop()
        deadline = None if self.timeout is None else loop.time() + self.timeout
        while self._raw is not None:
            try:
                left = None if deadline is None else max(0.0, deadline - loop.time())
                await asyncio.wait_for(until_woken(self._ready), left)
            except asyncio.TimeoutError:
                break
            self._ready.take()
            if (found := self._take()) is not None:
                return found
        raise StopAsyncIteration

    def _take(self) -> M | None:
        if self._raw is None:
            return None
        found = self._reader.next()
        _hgros.leave_callback()
        if found is None:
            return None
        message: M
        message, self.info = found
        return message

    def close(self) -> None:
        """Ends the subscription, and iterations on other threads. Does nothing if it has ended."""
        raw, self._raw = self._raw, None
        try:
            if raw is not None and not raw.of_parent:
                self._reader.finish(False)
                self._dropped = raw.dropped
                raw.end()
        finally:
            self._ready.end()

    def __enter__(self) -> Messages[M]:
        return self

    def __exit__(self, *error: Any) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_raw", None) is not None:
            self.close()
