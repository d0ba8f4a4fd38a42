#!/usr/bin/env python3
"""Measures ours, existing middleware and raw TCP between two hosts in rounds, and prints metric,value,unit. In each
round each way is measured once on each line.

    run_network.py --programs DIR --runs FILE.csv [--quick] [--only WAY,...]

Started by bench/network/run. Each way that is left out or fails is reported in one sentence on standard error.
"""

import argparse

import daemons
import figures
import ways
from hosts import HERE, Hosts, NoHosts
from one_run import measure
from report import Results
from rounds import available, run_rounds


def chosen(only, quick):
    modes = [mode for line in ways.LINES for mode in ways.ways(line)]
    words = set(only.split(",")) if only else None
    if unknown := (words or set()) - {mode.peer for mode in modes}:
        raise SystemExit(f"There is no way {', '.join(sorted(unknown))}; there are: "
                         f"{', '.join(dict.fromkeys(mode.peer for mode in modes))}.")
    return [mode for mode in modes if (mode.peer in words if words else mode.quick or not quick)]


def run(given, modes, plan, hosts):
    sides = ways.sides(hosts.prefix)
    with daemons.Daemons(HERE) as running:
        modes = available(modes, given.programs, running)
        results = Results(modes, plan)

        def once(mode, lanes, number, limit_s):
            hosts.set_rate(mode.name)
            return measure(mode, lanes, given.programs, running.environment, number, limit_s, sides)

        run_rounds(modes, plan, once, results)
    return results


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--programs", required=True)
    arguments.add_argument("--runs", required=True)
    arguments.add_argument("--quick", action="store_true")
    arguments.add_argument("--only", default="")
    given = arguments.parse_args()
    plan = ways.QUICK if given.quick else ways.FULL
    modes = chosen(given.only, given.quick)
    daemons.isolate(required=True)
    daemons.leave_in_order()
    try:
        with Hosts() as hosts:
            results = run(given, modes, plan, hosts)
    except NoHosts as why:
        raise SystemExit(f"This benchmark needs two network namespaces: {why}") from None
    results.write_runs(given.runs)
    for name, value, unit in figures.metrics(results):
        print(f"{name},{value:.6g},{unit}")


if __name__ == "__main__":
    main()
