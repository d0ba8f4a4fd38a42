"""What functions of the package are given, checked where it enters. Each raises TypeError with a sentence."""

from __future__ import annotations

import math
import operator
from typing import Any

from google.protobuf.message import Message

from .queues import KeepAll, KeepLast


def check_name(name: Any, of: str) -> None:
    if not isinstance(name, str):
        # A decorator without its brackets gives the function.
        hint = " As a decorator, write it with brackets and the name." if callable(name) else ""
        raise TypeError(f"The name of a {of} is a text, not {name!r}.{hint}")


def check_seconds(seconds: Any, of: str) -> None:
    try:
        if math.isnan(seconds + 0):  # A text is no number, though float() reads it.
            raise ValueError
    except (TypeError, ValueError):
        hint = " As a decorator, write it with brackets and the seconds." if callable(seconds) else ""
        raise TypeError(f"A {of} is a number of seconds, not {seconds!r}.{hint}") from None


def check_size(size: Any) -> int:
    try:
        whole = operator.index(size)
    except TypeError:
        whole = -1
    if whole < 0:
        raise TypeError(f"The size of a loan is a whole number of bytes, not {size!r}.")
    return whole


def check_queue(queue: Any) -> None:
    if not isinstance(queue, (KeepAll, KeepLast)):
        raise TypeError(f"A queue is hgros.KeepLast(...) or hgros.KeepAll(...), not {queue!r}.")


def check_request(request: Any, service: str) -> None:
    if not isinstance(request, Message):
        raise TypeError(f'The request to service "{service}" is a message, not {request!r}.')
