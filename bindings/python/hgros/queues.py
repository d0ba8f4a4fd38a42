"""How many messages of a subscription wait for Python."""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import Any


def _is_size(given: Any) -> bool:
    try:
        return operator.index(given) >= 1  # Also a whole number of numpy.
    except TypeError:
        return False


@dataclass(frozen=True)
class KeepLast:
    """The newest `depth` messages wait; older ones are dropped and counted."""

    depth: int = 16

    def __post_init__(self) -> None:
        if not _is_size(self.depth):
            raise ValueError(f"KeepLast needs room for at least one message, not {self.depth!r}.")


@dataclass(frozen=True)
class KeepAll:
    """Lossless: nothing is dropped. While there is no room, publishing raises QueueFull at the publisher.

    There is room for `depth` messages and about `limit_bytes` bytes (None: any number), and for up to 64 messages or
    1 MiB more, which Python takes next. Such a subscription has a thread of the library of its own.
    """

    depth: int
    limit_bytes: int | None = None

    def __post_init__(self) -> None:
        for limit in (self.depth, 1 if self.limit_bytes is None else self.limit_bytes):
            if not _is_size(limit):
                raise ValueError(f"KeepAll needs room for at least one message and one byte, not {limit!r}.")


Queue = KeepLast | KeepAll
