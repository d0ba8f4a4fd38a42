"""Messages of several channels that belong to the same time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Callable

from google.protobuf.message import Message

from . import _hgros
from .arguments import check_seconds
from .callbacks import check_callback
from .queues import KeepLast, Queue

if TYPE_CHECKING:
    from .component import Context
    from .session import Session


def stamp_ns(message: Any) -> int:
    """The field `timestamp` of a message, in ns."""
    try:
        stamp: int = message.timestamp.ToNanoseconds()
    except AttributeError:
        raise TypeError(f"{type(message).__name__} has no field `timestamp`. Give the synchronizer stamp=..., a function "
                        "that returns the stamp of a message in ns.") from None
    return stamp


class Synchronizer:
    """Calls `callback(one, another, ...)` with messages, one of each channel, whose stamps match (docs/synchronizing.md).

    `robot` is a session, or the context of a component. `channels` names two to nine channels; a dict has their types,
    too. The stamps of a set are at most `tolerance` seconds apart. `depth` messages of a channel wait at most for a match,
    and before that in a queue of each subscription. It may
    only be used where the callbacks of `robot` run.
    """

    def __init__(self, robot: Session | Context, channels: Iterable[str] | Mapping[str, type[Message] | None],
                 callback: Callable[..., object], *, tolerance: float = 0.0, depth: int = 16,
                 stamp: Callable[[Any], int] = stamp_ns, queue: Queue = KeepLast()) -> None:
        check_seconds(tolerance, "tolerance")
        self.channels = tuple(channels)
        check_callback(callback, len(self.channels), "a synchronizer")
        self._matcher = _hgros.StampMatcher(len(self.channels), tolerance, depth)
        self._callback = callback
        self._stamp = stamp
        types = channels if isinstance(channels, Mapping) else {}
        subscribe: Any = robot.subscribe
        self._subscriptions: list[Any] = []
        try:
            for index, channel in enumerate(self.channels):
                self._subscriptions.append(subscribe(channel, types.get(channel), self._receiver(index), queue=queue))
        except BaseException:
            self.end()
            raise

    def _receiver(self, index: int) -> Callable[[Any, _hgros.MessageInfo], None]:
        def receive(message: Any, info: _hgros.MessageInfo) -> None:
            matched = self._matcher.push(index, self._stamp(message), message)
            if matched is not None:
                self._callback(*matched)

        return receive

    def counts(self, channel: str) -> _hgros.MatchCounts:
        """How many messages of a channel were matched and dropped."""
        return self._matcher.counts(self.channels.index(channel))

    def end(self) -> None:
        """Ends the subscriptions. Those of a component end with it."""
        for subscription in self._subscriptions:
            if subscription is not None:
                subscription.end()
