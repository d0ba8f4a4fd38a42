#!/usr/bin/env python3
"""Draws CPU, memory and frames of the growing run as PNG, from the tables in the given folder."""

import pathlib
import shutil
import subprocess
import sys

FIGURES = (("cpu", 2, "CPU, percent of a core", ""), ("memory", 3, "memory, MB", "set logscale y"),
           ("frames", 4, "frames a second", ""))
LINES = (("ours_growth.csv", "hgros-viewer", "linewidth 3 linecolor rgb 0xdd0000"), ("rviz_growth.csv", "RViz", "linewidth 2"))


def main():
    folder = pathlib.Path(sys.argv[1])
    if not shutil.which("gnuplot"):
        print("No plots: gnuplot is not installed.", file=sys.stderr)
        return
    for name, column, label, extra in FIGURES:
        curves = ", ".join(f"'{folder / file}' skip 1 using 1:{column} with lines {style} title '{title}'"
                           for file, title, style in LINES if (folder / file).exists())
        script = f"""set terminal pngcairo size 1000,600
set output '{folder}/growth_{name}.png'
set datafile separator ','
set grid
set key left top
{extra}
set xlabel 'seconds of a run at 10 Hz, 20000 points a scan, all kept'
set ylabel '{label}'
plot {curves}
"""
        subprocess.run(["gnuplot"], input=script, text=True, check=True)
        print(f"Plot: {folder}/growth_{name}.png", file=sys.stderr)


if __name__ == "__main__":
    main()
