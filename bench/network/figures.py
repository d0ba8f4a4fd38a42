"""The results of all rounds on the lines between two hosts: metrics as (name, value, unit)."""

import statistics

from plan import MB, size_name
from report import percentile
from ways import LINES

# The peers of network_vs_PEER and their ways. The fastest way of a round represents the peer.
PEERS = {"ros1": ("ros1",), "fastdds": ("fastdds", "fastdds_default"), "cyclonedds": ("cyclonedds",)}


def metrics(results):
    yield "rounds", results.whole, "count"
    for line in LINES:
        modes = {mode.peer: mode for mode in results.modes if mode.name == line.name}
        for size in results.plan.sizes:
            end = size_name(size) + line.suffix
            yield f"line_time_us_{end}", line.us(size), "us"
            for peer, mode in modes.items():
                yield from of_way(results, mode, size, f"network_{peer}", end)
            yield from figures(results, modes, size, end)
        if line is LINES[0] and "ours" in modes and (median_us := results.median(modes["ours"], 4 * MB)):
            yield "latency_4MB_ms", median_us / 1e3, "ms"


def runs_of(results, mode, size):
    return [run for one in results.rounds for run in one.get(mode, ()) if run.lane.size == size]


def mean(results, mode, size):
    values = [value for run in runs_of(results, mode, size) for value in run.latencies_us]
    return statistics.fmean(values) if values else None


def of_way(results, mode, size, name, end):
    """Median, mean and tail over all messages of all rounds."""
    runs = runs_of(results, mode, size)
    values = [value for run in runs for value in run.latencies_us]
    if values:
        yield f"{name}_p50_us_{end}", statistics.median(values), "us"
        yield f"{name}_mean_us_{end}", statistics.fmean(values), "us"
        yield f"{name}_p99_us_{end}", percentile(values, 0.99), "us"
    if lost := sum(run.lost for run in runs):
        yield f"{name}_lost_{end}", lost, "messages"


def figures(results, modes, size, end):
    """Ours over theirs, the median of the rounds."""
    for name, peers in {"latency_ratio": ("raw_tcp",),
                        **{f"network_vs_{peer}": peers for peer, peers in PEERS.items()}}.items():
        ours, others = ([modes[way] for way in one if way in modes] for one in (("ours",), peers))
        if (ratio := results.ratio(ours, others, size)) is not None:
            yield f"{name}_{end}", ratio, "ratio"
    means = [mean(results, modes[peer], size) for peer in ("ours", "raw_tcp") if peer in modes]
    if len(means) == 2 and all(means):
        yield f"latency_mean_ratio_{end}", means[0] / means[1], "ratio"
