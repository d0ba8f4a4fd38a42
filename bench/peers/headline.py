"""The main figures of result.csv: the cost of shared memory, and the cost of the same with others.

A ratio is ours over theirs in the same round, median over the rounds. Below 1 ours is faster. If a peer has several
ways to do the same, the fastest way of the round represents it.
"""

import statistics

from modes import MODES
from plan import KB, MB, SIZES, size_name

BARE, PLAIN, BULK, SPIN = "ours_shm", "ours_shm_plain", "ours_shm_bulk", "ours_shm_spin"
ICEORYX = ("iceoryx_listener", "iceoryx_waitset")
FASTDDS = ("fastdds_shm_udp", "fastdds_shm_tuned")
FANOUT = "ours_shm_bulk_fanout8"

# (metric, our mode, the other's ways, only this size)
RATIOS = (
    ("shm_over_floor", BARE, ("raw_shm_futex",), KB),
    ("shm_vs_iceoryx", BARE, ICEORYX, KB),
    ("shm_spin_vs_iceoryx_poll", SPIN, ("iceoryx_poll",), KB),
    ("shm_vs_fastdds", PLAIN, FASTDDS, None),
    ("shm_vs_ros1", PLAIN, ("ros1_tcpros",), None),
    ("shm_bulk_vs_iceoryx", BULK, ICEORYX, None),
    ("shm_bulk_vs_fastdds_loan", BULK, ("fastdds_loan",), None),
    ("shm_bulk_vs_fastdds", BULK, FASTDDS, None),
    ("shm_bulk_vs_ros1", BULK, ("ros1_tcpros",), None),
)


def metrics(results):
    """(name, value, unit) of everything that was measured."""
    return [figure for figure in figures(results) if figure[1] is not None]


def figures(results):
    """Likewise, with None if nothing was measured."""
    modes = {mode.key: mode for mode in MODES if mode in results.modes}

    def named(*keys):
        return [modes[key] for key in keys if key in modes]

    for name, key in (("shm", BARE), ("shm_plain", PLAIN), ("shm_bulk", BULK)):
        for size in SIZES:
            for mode in named(key):
                yield f"{name}_p50_us_{size_name(size)}", results.median(mode, size), "us"
    yield "shm_bulk_size_ratio", results.ratio(named(BULK), named(BULK), 4 * MB, KB), "ratio"
    for name, ours, others, only in RATIOS:
        for size in SIZES if only is None else (only,):
            yield f"{name}_{size_name(size)}", results.ratio(named(ours), named(*others), size), "ratio"
    yield "shm_plain_4MB_over_memcpy", results.ratio(named(PLAIN), named("raw_memcpy"), 4 * MB), "ratio"
    for mode in named(FANOUT):
        yield "shm_fanout8_bulk_4MB_us", results.median(mode, 4 * MB), "us"
    for mode in named(BARE):
        floods = [run.per_s for one in results.rounds for run in one.get(mode, ())
                  if run.lane.size == KB and run.lane.flood_ms]
        yield "shm_msgs_per_s_1KB", statistics.median(floods) if floods else None, "1/s"
