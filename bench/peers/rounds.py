"""Rounds over modes: each mode once a round, as long as time allows. A mode left out or failed is reported."""

import os
import pathlib
import sys
import time

import plan as plans
from modes import PACKAGES
from one_run import usual_limit_s


def say(text):
    print(text, file=sys.stderr, flush=True)


def available(modes, programs, running):
    """The modes that can be measured here. Reports once for each peer or daemon why the others cannot."""
    kept, said = [], set()
    for mode in modes:
        why = ""
        if not os.access(pathlib.Path(programs, f"peer_{mode.program}"), os.X_OK):
            why = f"{mode.peer} is left out: it needs {PACKAGES.get(mode.program, 'a complete build')}."
        elif refusal := running.need(mode.daemon):
            why = f"{mode.peer} is left out where it needs {mode.daemon}: {refusal}"
        if not why:
            kept.append(mode)
        elif why not in said:
            said.add(why)
            say(why)
    return kept


AFTER_BUDGET_S = 5  # Extra time for a run that began within the budget.


def run_rounds(modes, plan, run_one, results):
    """Every second round goes backwards, so that drift over a round affects all modes alike.

    run_one(mode, lanes, number, limit_s) measures once. one_run.measure documents what it returns.
    """
    start, number, faults, lanes = time.monotonic(), 0, {}, {mode: list(plan.lanes(mode)) for mode in modes}
    for turn in range(plan.rounds):
        results.begin_round()
        for mode in modes if turn % 2 == 0 else reversed(modes):
            if faults.get(mode, 0) >= 2:
                continue
            left_s = plan.budget_s - (time.monotonic() - start)
            if left_s < 0:
                say(f"The time is up after {turn} complete rounds of {plan.rounds}.")
                return
            number += 1
            # A mode that hangs must not use up the time of the others.
            limit_s = min(usual_limit_s(lanes[mode]), left_s + AFTER_BUDGET_S, plan.budget_s / 3)
            found, fault = run_one(mode, lanes[mode], number, limit_s)
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
