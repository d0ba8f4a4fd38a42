#!/usr/bin/env python3
"""Measures ours, existing middleware and raw floors in rounds, each mode once a round, and prints metric,value,unit.

    run_peers.py --programs DIR --runs FILE.csv [--quick] [--only PEER[_MODE],...]

Started by bench/peers/run. Each mode that is left out or fails is reported in one sentence on standard error.
"""

import argparse

import daemons
import headline
import plan as plans
from modes import MODES
from one_run import measure
from report import Results
from rounds import available, run_rounds


def chosen(only, quick):
    words = set(only.split(",")) if only else None
    unknown = (words or set()) - {word for mode in MODES for word in (mode.peer, mode.key)}
    if unknown:
        raise SystemExit(f"There is no peer or mode {', '.join(sorted(unknown))}; there are: "
                         f"{', '.join(mode.key for mode in MODES)}.")
    return [mode for mode in MODES
            if (mode.peer in words or mode.key in words if words else mode.quick or not quick)]


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--programs", required=True)
    arguments.add_argument("--runs", required=True)
    arguments.add_argument("--quick", action="store_true")
    arguments.add_argument("--only", default="")
    given = arguments.parse_args()
    plan = plans.QUICK if given.quick else plans.FULL
    wanted = chosen(given.only, given.quick)
    daemons.isolate()
    daemons.leave_in_order()
    with daemons.Daemons() as running:
        modes = available(wanted, given.programs, running)
        results = Results(modes, plan)
        run_rounds(modes, plan, lambda mode, lanes, number, limit_s: measure(
            mode, lanes, given.programs, running.environment, number, limit_s), results)
    results.write_runs(given.runs)
    for name, value, unit in (*results.metrics(), *headline.metrics(results)):
        print(f"{name},{value:.6g},{unit}")


if __name__ == "__main__":
    main()
