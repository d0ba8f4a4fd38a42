#!/usr/bin/env python3
"""Measures ours, existing middleware and raw floors in rounds, each mode once a round, and prints metric,value,unit.

    run_peers.py --programs DIR --runs FILE.csv [--quick] [--only PEER[_MODE],...]

Started by bench/peers/run. What is left out or fails is said in one sentence on standard error.
"""

import argparse
import os
import pathlib
import signal
import sys
import time

import daemons
import plan as plans
from modes import MODES, PACKAGES
from one_run import measure, usual_limit_s
from report import Results


def say(text):
    print(text, file=sys.stderr, flush=True)


def chosen(only, quick):
    words = set(only.split(",")) if only else None
    unknown = (words or set()) - {word for mode in MODES for word in (mode.peer, mode.key)}
    if unknown:
        raise SystemExit(f"There is no peer or mode {', '.join(sorted(unknown))}; there are: "
                         f"{', '.join(mode.key for mode in MODES)}.")
    return [mode for mode in MODES
            if (mode.peer in words or mode.key in words if words else mode.quick or not quick)]


def available(modes, programs, running):
    """Those modes that can be measured here; says once for each peer or daemon why the others cannot."""
    kept, said = [], set()
    for mode in modes:
        why = ""
        if not os.access(pathlib.Path(programs, f"peer_{mode.program}"), os.X_OK):
            why = f"{mode.peer} is left out: it needs {PACKAGES.get(mode.peer, 'a complete build')}."
        elif refusal := running.need(mode.daemon):
            why = f"{mode.peer} is left out where it needs {mode.daemon}: {refusal}"
        if not why:
            kept.append(mode)
        elif why not in said:
            said.add(why)
            say(why)
    return kept


AFTER_BUDGET_S = 5  # A run that began in time may take so long beyond it.


def run_rounds(modes, plan, programs, running, results):
    """Every second round goes backwards, so that what drifts over a round falls on all alike."""
    start, number, faults, lanes = time.monotonic(), 0, {}, {mode: list(plan.lanes(mode)) for mode in modes}
    for turn in range(plan.rounds):
        results.begin_round()
        for mode in modes if turn % 2 == 0 else reversed(modes):
            if faults.get(mode, 0) >= 2:
                continue
            left_s = plan.budget_s - (time.monotonic() - start)
            if left_s < 0:
                say(f"The time is up: {turn} whole rounds of {plan.rounds}.")
                return
            number += 1
            limit_s = min(usual_limit_s(lanes[mode]), left_s + AFTER_BUDGET_S)
            found, fault = measure(mode, lanes[mode], programs, running.environment, number, limit_s)
            if fault:
                faults[mode] = faults.get(mode, 0) + 1
                more = ", and is left out from now on" if faults[mode] >= 2 else ""
                say(f"{mode.key} failed in round {turn + 1}{more}: {fault}")
            if found:
                results.add(mode, found)
            for index, one in enumerate(found):
                if one.silent:
                    say(f"{mode.key} carries no message of {plans.size_name(one.lane.size)} here.")
                    lanes[mode][index] = one.lane.skipped()
        results.end_round()
        say(f"Round {turn + 1} of {plan.rounds} ended after {time.monotonic() - start:.0f} s.")


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
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # So that the daemons end then, too.
    with daemons.Daemons() as running:
        modes = available(wanted, given.programs, running)
        results = Results(modes, plan)
        run_rounds(modes, plan, given.programs, running, results)
    results.write_runs(given.runs)
    for name, value, unit in results.metrics():
        print(f"{name},{value:.6g},{unit}")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit(130)
