"""Functions of the program that are called with what comes."""

from __future__ import annotations

import abc
import inspect
import math
import time
from typing import Any, Callable, Protocol

from .log_relay import logger
from .readable import readable

_MOST_LOGGED = 10
_LOGS_WITHIN_S = 10


class Ends(Protocol):
    def end(self) -> None: ...


class Handler(abc.ABC):
    """What calls a function; the base of subscriptions, services and timers.

    `run` counts the calls, and `failed` those that raised an exception.
    """

    def __init__(self, raw: Ends, callback: Callable[..., Any], end: Callable[[], None]) -> None:
        self._callback = callback
        self._run = 0
        self.failed = 0
        self._logs_since = -math.inf
        self._logged = 0
        self._raw: Any = raw
        self._end = end

    def _fails(self, what: str) -> None:
        """Counts the exception that is being handled, and logs it; of many like it, ten within ten seconds."""
        self.failed += 1
        now = time.monotonic()
        if now - self._logs_since > _LOGS_WITHIN_S:
            self._logs_since, self._logged = now, 0
        self._logged += 1
        if self._logged <= _MOST_LOGGED:
            logger.exception("%s raised an exception.", what)
        elif self._logged == _MOST_LOGGED + 1:
            logger.error("%s raises exceptions again and again: %d so far. Until %d s after the first, others are only "
                         "counted (`failed`).", what, self.failed, _LOGS_WITHIN_S)

    @property
    def callback(self) -> Callable[..., Any]:
        return self._callback

    @property
    def run(self) -> int:
        return self._run

    @property
    def active(self) -> bool:
        return self._raw is not None

    def end(self) -> None:
        """No call begins any more. Does nothing if it has ended."""
        raw, self._raw = self._raw, None
        if raw is not None:
            self._end()
            raw.end()

    @abc.abstractmethod
    def handle_some(self) -> bool:
        """Calls the function with some of what waits. Returns whether more is left."""


def check_callback(callback: Any, arguments: int, owner: str) -> None:
    """Raises TypeError if it cannot be called with so many arguments, or if it is a coroutine function."""
    owner = readable(owner)
    if not callable(callback):
        raise TypeError(f"The callback of {owner} cannot be called: {callback!r}.")
    if inspect.iscoroutinefunction(callback) or inspect.iscoroutinefunction(getattr(callback, "__call__", None)):
        raise TypeError(f"The callback of {owner} is an `async def`, which nothing awaits. Give a `def` that starts it, "
                        "for example with asyncio.ensure_future(...), or use `async for` over robot.messages(...).")
    try:
        signature = inspect.signature(callback)
    except (TypeError, ValueError):
        return  # Some functions of C do not tell it.
    try:
        signature.bind(*[None] * arguments)
    except TypeError as fault:
        raise TypeError(f"The callback of {owner} is called with {arguments} argument{'s' * (arguments > 1)}, and takes "
                        f"{signature}: {fault}.") from None
