#!/usr/bin/env python3
"""Draws the figures of result.csv in the given folder, as PNG beside it."""

import collections
import csv
import pathlib
import re
import shutil
import subprocess
import sys

from modes import MODES

KB = {"KB": 1, "MB": 1024}
# (file, unit of the metric, between processes?, label of the y axis)
FIGURES = (
    ("latency_inter_median", "p50_us", True, "one-way latency between processes, median, us"),
    ("latency_inter_mean", "mean_us", True, "one-way latency between processes, mean, us"),
    ("latency_intra_median", "p50_us", False, "latency in one process, median, us"),
    ("latency_intra_mean", "mean_us", False, "latency in one process, mean, us"),
    ("throughput_intra", "paced_mb_per_s", False, "all bytes over the sum of latencies at 10 Hz, MB/s"),
    ("throughput_inter", "msgs_per_s", True, "messages that arrive at full speed between processes, 1/s"),
)


def read(path):
    """{metric name: value} of a result."""
    with open(path, newline="", encoding="utf-8") as file:
        return {row[0]: float(row[1]) for row in csv.reader(file)}


def curves(values, quantity, inter):
    """{"peer mode": [(KB, value), ...]} of one figure, by size."""
    found = collections.defaultdict(list)
    for mode in MODES:
        if mode.inter != inter:
            continue
        pattern = re.compile(rf"{re.escape(mode.key)}_{quantity}_(\d+)(KB|MB)")
        for name, value in values.items():
            if match := pattern.fullmatch(name):
                found[f"{mode.peer} {mode.name.replace('_', ' ')}"].append((int(match[1]) * KB[match[2]], value))
    return {title: sorted(points) for title, points in found.items()}


def draw(folder, name, lines, label):
    data = "\n\n\n".join("\n".join(f"{size} {value}" for size, value in points) for points in lines.values())
    path = folder / f"{name}.dat"
    path.write_text(data + "\n", encoding="utf-8")
    # Ours is thick and red.
    plots = ", ".join(f"'{path}' index {index} using 1:2 with linespoints "
                      f"{'linewidth 3 linecolor rgb 0xdd0000' if title.startswith('ours') else 'linewidth 1'} "
                      f"title '{title}'" for index, title in enumerate(lines))
    script = f"""set terminal pngcairo size 1200,750
set output '{folder / name}.png'
set logscale xy
set grid
set key outside right
set xlabel 'message size, KB'
set ylabel '{label}'
plot {plots}
"""
    subprocess.run(["gnuplot"], input=script, text=True, check=True)
    print(f"Plot: {folder / name}.png")


def main():
    folder = pathlib.Path(sys.argv[1])
    if not shutil.which("gnuplot"):
        print("No plots: gnuplot is not installed.", file=sys.stderr)
        return
    values = read(folder / "result.csv")
    for name, quantity, inter, label in FIGURES:
        if lines := curves(values, quantity, inter):
            draw(folder, name, lines, label)


if __name__ == "__main__":
    main()
