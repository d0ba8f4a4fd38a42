#!/usr/bin/env python3
"""Draws the latencies of result.csv in the given folder, as one PNG file beside it for each line."""

import pathlib
import re
import shutil
import sys

from plots import KB, draw, read
from ways import LINES, ways


def curves(values, line):
    """{"way": [(KB, us), ...]} of one line, by size."""
    found = {}
    for mode in ways(line):
        pattern = re.compile(rf"network_{mode.peer}_p50_us_(\d+)(KB|MB){line.suffix}")
        points = sorted((int(match[1]) * KB[match[2]], value) for name, value in values.items()
                        if (match := pattern.fullmatch(name)))
        if points:
            found[mode.peer.replace("_", " ")] = points
    return found


def main():
    folder = pathlib.Path(sys.argv[1])
    if not shutil.which("gnuplot"):
        print("No plots: gnuplot is not installed.", file=sys.stderr)
        return
    values = read(folder / "result.csv")
    for line in LINES:
        if lines := curves(values, line):
            draw(folder, f"latency_{line.name}", lines, f"one-way latency at {line.name}/s, median, us")


if __name__ == "__main__":
    main()
