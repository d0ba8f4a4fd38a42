"""What a session counts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Times:
    """A distribution of times in ns."""

    count: int
    mean_ns: float
    median_ns: int
    p99_ns: int
    max_ns: int


@dataclass(frozen=True)
class NodeSnapshot:
    """Counters of one node. For a subscription of Python `queued` is without what waits for a callback."""

    name: str
    channel: str
    received: int
    dropped: int
    run: int
    failed: int
    queued: int
    queue_wait: Times
    run_time: Times


@dataclass(frozen=True)
class ChannelSnapshot:
    """Counters of one channel in this session."""

    name: str
    type_name: str
    published: int
    rate_hz: float
    refused: int
    received: int
    latched: int
    nodes: tuple[NodeSnapshot, ...]


@dataclass(frozen=True)
class ChannelTraffic:
    """Messages of a channel that left or entered this process."""

    channel: str
    encoded: int
    encoded_bytes: int
    copied: int
    loans: int
    heap_loans: int
    publishers: int
    lost: int


@dataclass(frozen=True)
class Peer:
    """A session that is connected, and the transport of its messages."""

    id: str
    process: str
    host: str
    pid: int
    transport: str
    why: str


@dataclass(frozen=True)
class KnownChannel:
    """A channel of any session that is known, and the number of its users."""

    name: str
    type_name: str
    publishers: int
    subscribers: int


@dataclass(frozen=True)
class SessionSnapshot:
    """Everything that a session counts, at one moment; `Session.snapshot()`."""

    id: str
    name: str
    channels: tuple[ChannelSnapshot, ...]
    traffic: tuple[ChannelTraffic, ...]
    peers: tuple[Peer, ...]

    def channel(self, name: str) -> ChannelSnapshot:
        """The channel of that name. Raises KeyError if the session does not use it."""
        for one in self.channels:
            if one.name == name:
                return one
        raise KeyError(name)


def _node(values: dict[str, Any]) -> NodeSnapshot:
    queue_wait, run_time = Times(**values.pop("queue_wait")), Times(**values.pop("run_time"))
    return NodeSnapshot(**values, queue_wait=queue_wait, run_time=run_time)


def _channel(values: dict[str, Any]) -> ChannelSnapshot:
    return ChannelSnapshot(nodes=tuple(_node(one) for one in values.pop("nodes")), **values)


def snapshot_of(values: dict[str, Any]) -> SessionSnapshot:
    """The snapshot that the module returns as dicts."""
    return SessionSnapshot(values["id"], values["name"], tuple(_channel(one) for one in values["channels"]),
                           tuple(ChannelTraffic(**one) for one in values["traffic"]),
                           tuple(Peer(**one) for one in values["peers"]))
