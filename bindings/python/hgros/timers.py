"""Timers and rates on the session's clock."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Callable

from . import _hgros
from .arguments import check_seconds
from .callbacks import Ends, Handler
from .errors import Error


@dataclass(frozen=True)
class Tick:
    """One turn: the planned moment and the clock's time in ns, and the number of turns before it that were skipped."""

    planned_ns: int
    now_ns: int
    missed: int


def period_ns(period: float) -> int:
    """A period in seconds as nanoseconds."""
    check_seconds(period, "period")
    if not 1e-9 <= period < 1e9:
        raise ValueError(f"A period must be above 0 s and below 1e9 s, not {period}.")
    return round(period * 1e9)


def _next(inbox: _hgros.Inbox) -> Tick | None:
    for planned, now, missed in inbox.take(1):
        return Tick(planned, now, missed)
    return None


class NamelessTimers:
    """Timers whose users give them no name. A session keeps what it has for a name, so the next timer takes that of one
    that has ended.
    """

    def __init__(self) -> None:
        self._made = itertools.count(1)
        self._free: list[str] = []

    def open(self, session: _hgros.Session, period: int, inbox: _hgros.Inbox) -> NamelessTimer:
        """`period` in ns."""
        try:
            name = self._free.pop()
        except IndexError:
            name = f"python{next(self._made)}"
        return NamelessTimer(_hgros.create_timer(session, name, period, inbox), name, self._free)


class NamelessTimer:
    """Gives its name back at its end, which is called once."""

    def __init__(self, raw: _hgros.Timer, name: str, free: list[str]) -> None:
        self._raw = raw
        self.name = name
        self._free = free

    def end(self) -> None:
        self._raw.end()
        self._free.append(self.name)


class Timer(Handler):
    """Calls a function periodically; made by `Session.timer`. `failed` counts calls that raised an exception."""

    def __init__(self, raw: Ends, inbox: _hgros.Inbox, name: str, callback: Callable[[Tick], object],
                 end: Callable[[], None]) -> None:
        super().__init__(raw, callback, end)
        self.name = name
        self._inbox = inbox

    def handle_some(self) -> bool:
        if (tick := _next(self._inbox)) is not None:
            self._run += 1
            try:
                self.callback(tick)
            except Exception:
                self._fails(f'The callback of timer "{self.name}"')
        return False


class Rate:
    """Runs a loop at a fixed rate of the session's clock: `for tick in robot.rate(0.1)`, or `rate.sleep()`.

    It does not drift. A turn that was missed is skipped and counted. The loop ends when the session is closed.
    """

    def __init__(self, raw: Ends, inbox: _hgros.Inbox, ready: _hgros.ReadyList) -> None:
        self._raw: Ends | None = raw
        self._inbox = inbox
        self._ready = ready

    def sleep(self) -> Tick:
        """Sleeps until the next turn; returns at once if that has passed. Raises Error if the session is closed."""
        if (tick := self._turn()) is None:
            raise Error("The rate has ended: its session is closed.")
        return tick

    def _turn(self) -> Tick | None:
        while self._raw is not None:
            if (tick := _next(self._inbox)) is not None:
                return tick
            self._ready.wait(-1.0)
        return None

    def __iter__(self) -> Rate:
        return self

    def __next__(self) -> Tick:
        if (tick := self._turn()) is None:
            raise StopIteration
        return tick

    def close(self) -> None:
        """Ends the rate and a loop that uses it."""
        raw, self._raw = self._raw, None
        try:
            if raw is not None:
                raw.end()
        finally:
            self._ready.end()

    def __del__(self) -> None:
        if getattr(self, "_raw", None) is not None:
            self.close()
