"""The amount of measurement: sizes, counts and rounds of a full and of a quick run."""

import dataclasses

KB = 1024
MB = 1024 * KB


@dataclasses.dataclass(frozen=True)
class Lane:
    """Messages of one size: `timed` of them one by one, then as many as go through in `flood_ms`."""

    size: int
    timed: int
    flood_ms: int
    pause_us: int
    warm_up: int = 10
    transit_us: int = 0  # time on the line alone
    paced: bool = False  # measured like the paper's throughput: total bytes over the sum of the latencies

    def argument(self):
        return f"{self.size}:{self.timed}:{self.flood_ms}:{self.pause_us}:{self.warm_up}:{self.transit_us}"

    def skipped(self):
        """The same lane without a measurement."""
        return dataclasses.replace(self, timed=0, flood_ms=0)


@dataclasses.dataclass(frozen=True)
class Plan:
    quick: bool
    rounds: int
    budget_s: float  # no run of a program begins later than this
    inter: tuple
    intra: tuple
    fanout: tuple = ()

    def lanes(self, mode):
        if mode.receivers > 1:
            return self.fanout
        return self.inter if mode.inter else self.intra


def size_name(size):
    return f"{size // MB}MB" if size % MB == 0 else f"{size // KB}KB"


PAUSE_US = 2_000
TEN_HERTZ_US = 100_000
SIZES = tuple(KB * 4**i for i in range(7))
PACED_SIZES = (100 * KB, 500 * KB, MB, 5 * MB, 10 * MB)


def latency(size, count, flood_ms=0):
    return Lane(size, count, flood_ms, PAUSE_US)


def paced(size, count, pause_us):
    return Lane(size, count, 0, pause_us, warm_up=1, paced=True)


FULL = Plan(
    quick=False, rounds=9, budget_s=24 * 60,
    inter=tuple(latency(size, 100, 300 if size in (KB, 64 * KB, MB) else 0) for size in SIZES),
    intra=tuple(latency(size, 100) for size in SIZES) + tuple(paced(size, 5, TEN_HERTZ_US) for size in PACED_SIZES),
    fanout=(latency(4 * MB, 50),))
QUICK = Plan(
    quick=True, rounds=3, budget_s=33,
    inter=(latency(KB, 30, 50), latency(64 * KB, 30), latency(4 * MB, 15)),
    intra=(latency(KB, 30), latency(4 * MB, 15), paced(MB, 3, 20_000)),
    fanout=(latency(4 * MB, 15),))
