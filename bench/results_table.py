#!/usr/bin/env python3
"""Writes the numbers of bench/results/*/result.csv as Markdown tables into docs/benchmarks.md, between its two marks.

    results_table.py [--results FOLDER] [--into FILE.md]

First run the benchmarks without --quick on an idle machine. A benchmark without a result gets a line that says so.
"""

import argparse
import csv
import pathlib
import re
import sys
import textwrap

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "bench" / "peers"), str(ROOT / "bench" / "network")]

import ways  # noqa: E402
from modes import MODES  # noqa: E402
from plan import SIZES, size_name  # noqa: E402

BEGIN, END = "<!-- results: written by bench/results_table.py -->", "<!-- results: end -->"
SIZE_NAMES = [size_name(size) for size in SIZES]
PACED = ("100KB", "500KB", "1MB", "5MB", "10MB")  # The paper's sizes, at 10 Hz.
SIZED = re.compile(r"(.+)_(\d+(?:KB|MB))(_[a-z0-9]+)?")


def number(value):
    """Three significant digits, without an exponent."""
    if value == 0:
        return "0"
    text = f"{value:.3g}"
    return f"{float(text):.0f}" if "e" in text else text


def table(head, rows):
    """The rows that have any value, as a table. Nothing if none has one."""
    rows = [(title, cells) for title, cells in rows if any(cells)]
    if not rows:
        return []
    lines = [head, *([f"`{title}`", *cells] for title, cells in rows)]
    text = ["| " + " | ".join(line) + " |" for line in lines]
    return [text[0], "|---" + "|---:" * (len(head) - 1) + "|", *text[1:], ""]


def by_size(values, head, families):
    """A table of metrics that end in a size: (title, metric without size, text after the size)."""
    def cells(name, suffix):
        found = (values.get(f"{name}_{size}{suffix}") for size in SIZE_NAMES)
        return ["" if value is None else number(value) for value in found]

    return table([head, *SIZE_NAMES], [(title, cells(name, suffix)) for title, name, suffix in families])


def ratios(values, beginnings, suffix):
    """Families of ratios, in the order of the result."""
    names = {}
    for metric in values:
        match = SIZED.fullmatch(metric)
        if match and (match[3] or "") == suffix and match[1].startswith(beginnings):
            names[match[1]] = None
    return [(name, name, suffix) for name in names if "_p50_us" not in name]


def peers(values):
    yield from by_size(values, "median, us", [(f"{name}_p50_us", f"{name}_p50_us", "")
                                              for name in ("shm", "shm_plain", "shm_bulk")])
    yield from by_size(values, "ours / theirs",
                       ratios(values, ("shm_vs_", "shm_bulk_vs_", "shm_spin_vs_", "shm_over_"), ""))
    single = ("shm_bulk_size_ratio", "shm_plain_4MB_over_memcpy", "shm_fanout8_bulk_4MB_us", "shm_msgs_per_s_1KB")
    yield from table(["figure", "value"], [(name, [number(values[name])]) for name in single if name in values])
    for what, metric in (("median", "p50_us"), ("mean", "mean_us")):
        for where, inter in (("between processes", True), ("in one process", False)):
            yield from by_size(values, f"{where}, {what}, us",
                               [(mode.key, f"{mode.key}_{metric}", "") for mode in MODES if mode.inter == inter])
    yield from table(["in one process, all bytes over the sum of latencies, MB/s", *PACED],
                     [(mode.key, [number(values[name]) if name in values else ""
                                  for name in (f"{mode.key}_paced_mb_per_s_{size}" for size in PACED)])
                      for mode in MODES if not mode.inter])


def network(values):
    for line in ways.LINES:
        yield from by_size(values, f"{line.name}/s, median, us",
                           [(mode.peer, f"network_{mode.peer}_p50_us", line.suffix) for mode in ways.ways(line)]
                           + [("the line alone", "line_time_us", line.suffix)])
        yield from by_size(values, f"{line.name}/s, ours / theirs",
                           ratios(values, ("network_vs_", "latency_"), line.suffix))


def viewer(values):
    yield from table(["everything kept", *(f"{second} s" for second in (10, 60, 120))],
                     [(f"{prefix}{name}", [number(values[metric]) if metric in values else ""
                                           for metric in (f"{prefix}{name}_at_{second}s" for second in (10, 60, 120))])
                      for name in ("cpu_percent", "fps", "cpu_ms_per_frame", "rss_mb") for prefix in ("", "rviz_")])
    frames = [name for name in values if name.endswith(("_1M", "_10M", "_50M"))]
    families = dict.fromkeys(name.rpartition("_")[0] for name in frames)
    yield from table(["a frame", "1M", "10M", "50M"],
                     [(name, [number(values[f"{name}_{size}"]) if f"{name}_{size}" in values else ""
                              for size in ("1M", "10M", "50M")]) for name in families])
    others = [name for name in values if "_at_" not in name or name.startswith(("moving", "rviz_moving"))]
    yield from table(["figure", "hgros-viewer", "RViz"],
                     [(name, [number(values[name]), number(values[f"rviz_{name}"]) if f"rviz_{name}" in values else ""])
                      for name in others if name not in frames and not name.startswith("rviz_")])


def section(results, name, write):
    folder = results / name
    yield f"### {name}"
    yield ""
    try:
        with open(folder / "result.csv", newline="", encoding="utf-8") as file:
            values = {row[0]: float(row[1]) for row in csv.reader(file)}
        machine = (folder / "machine.txt").read_text(encoding="utf-8").strip()
    except FileNotFoundError:
        yield f"No result yet. `./dev bench {name}` creates it."
        yield ""
        return
    yield from textwrap.wrap(f"{machine}.", 120, break_on_hyphens=False)
    yield ""
    yield from write(values)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--results", type=pathlib.Path, default=ROOT / "bench" / "results")
    arguments.add_argument("--into", type=pathlib.Path, default=ROOT / "docs" / "benchmarks.md")
    given = arguments.parse_args()
    text = given.into.read_text(encoding="utf-8")
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise SystemExit(f"{given.into} needs both marks: {BEGIN} and {END}.")
    lines = [*section(given.results, "peers", peers), *section(given.results, "network", network),
             *section(given.results, "viewer", viewer)]
    given.into.write_text(before + begin + "\n\n" + "\n".join(lines) + end + after, encoding="utf-8")


if __name__ == "__main__":
    main()
