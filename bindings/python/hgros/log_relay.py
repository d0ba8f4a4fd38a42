"""Passes the library's log on to `logging`."""

from __future__ import annotations

import logging
import threading

from . import _hgros

logger = logging.getLogger("hgros")

_LEVELS = (logging.DEBUG, logging.INFO, logging.WARNING, logging.ERROR)
_MOST_LINES = 1024
_AT_ONCE = 64


class LogRelay:
    """Takes lines from the library's threads, which only put them into a queue, and logs them on a thread of Python."""

    def __init__(self) -> None:
        self._ready = _hgros.ReadyList()
        self.inbox = _hgros.Inbox(self._ready, 0)
        self.inbox.keep_last(_MOST_LINES)
        self._ended = False
        self._lost = 0
        self._thread = threading.Thread(target=self._run, name="hgros log", daemon=True)
        self._thread.start()

    def end(self) -> None:
        """Logs what is left and ends the thread."""
        self._ended = True
        self._ready.wake()
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def _run(self) -> None:
        while not self._ended:
            self._ready.wait(-1)
            self._log_all()
        self._log_all()

    def _log_all(self) -> None:
        while lines := self.inbox.take(_AT_ONCE):
            for level, text in lines:
                logger.log(_LEVELS[level], "%s", text)
        lost = self.inbox.dropped
        if lost != self._lost:
            logger.warning("%d lines of the log were lost: they came faster than they were written.", lost - self._lost)
            self._lost = lost
