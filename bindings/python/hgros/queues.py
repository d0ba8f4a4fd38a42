"""How many messages of a subscription wait for Python."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class KeepLast:
    """The newest `depth` messages wait; older ones are dropped and counted."""

    depth: int = 16

    def __post_init__(self) -> None:
        if self.depth < 1:
            raise ValueError(f"KeepLast needs room for at least one message, not {self.depth}.")


@dataclass(frozen=True)
class KeepAll:
    """Lossless: nothing is dropped. While there is no room, publishing raises QueueFull at the publisher.

    There is room for `depth` messages and about `limit_bytes` bytes (None: any number), and for up to 64 messages or
    1 MiB more, which Python takes next. Such a subscription has a thread of the library of its own.
    """

    depth: int
    limit_bytes: int | None = None

    def __post_init__(self) -> None:
        if self.depth < 1 or (self.limit_bytes is not None and self.limit_bytes < 1):
            raise ValueError("KeepAll needs room for at least one message and one byte.")


Queue = KeepLast | KeepAll
