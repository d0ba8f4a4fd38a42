"""The lines between the hosts, the ways to send over them, and the amount of measurement on each."""

import dataclasses

from hosts import HERE, THERE
from modes import Mode, cyclone
from one_run import Side
from plan import KB, MB, PAUSE_US, SIZES, Lane


@dataclasses.dataclass(frozen=True)
class Line:
    name: str  # as tc writes a rate
    bits_per_s: float
    suffix: str  # of the line's metrics

    def us(self, size):
        """Time of that many bytes on the line alone."""
        return size * 8 / self.bits_per_s * 1e6


LINES = (Line("1gbit", 1e9, ""), Line("100mbit", 1e8, "_100mbit"))


def ways(line):
    """What is compared on one line. `peer` names it in the metrics, and the mode's name is the line."""
    def way(peer, program, argument, **more):
        return Mode(peer, line.name, program, argument, True, **more)

    return (way("raw_tcp", "raw_socket", "tcp", quick=True),
            way("ours", "ours", "tcp", quick=True),
            way("ours_plain", "ours", "tcp_plain"),
            way("ros1", "ros1", "tcpros", quick=True, daemon="rosmaster"),
            way("fastdds", "fastdds", "udp_tuned", quick=True),
            way("fastdds_default", "fastdds", "udp"),
            way("cyclonedds", "cyclone", "udp", quick=True))


def sides(prefix):
    """(sender, receiver). `prefix`: words before a command on the other host."""
    def side(own, other, words):
        return Side(own, other, words, (("ROS_IP", own), *cyclone("false", own, other)))

    return side(HERE, THERE, ()), side(THERE, HERE, prefix)


def between(low, value, high):
    return max(low, min(high, int(value)))


@dataclasses.dataclass(frozen=True)
class Plan:
    """The amount of measurement: about `ms` on each line for messages of one size, within these limits."""

    quick: bool
    rounds: int
    budget_s: float  # no run of a program begins later than this
    sizes: tuple
    timed_ms: float
    least: int
    most: int

    def lane(self, line, size):
        each_ms = (line.us(size) + PAUSE_US) / 1e3
        return Lane(size, between(self.least, self.timed_ms / each_ms, self.most), 0, PAUSE_US,
                    warm_up=between(1, self.timed_ms / 3 / each_ms, 10), transit_us=int(line.us(size)))

    def lanes(self, mode):
        line = next(line for line in LINES if line.name == mode.name)
        return tuple(self.lane(line, size) for size in self.sizes)


FULL = Plan(quick=False, rounds=9, budget_s=11 * 60, sizes=SIZES, timed_ms=1500, least=5, most=30)
QUICK = Plan(quick=True, rounds=2, budget_s=33, sizes=(KB, 64 * KB, 4 * MB), timed_ms=300, least=2, most=20)
