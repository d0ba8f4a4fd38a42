"""One run of one mode: starts its programs, reads their results, ends them."""

import dataclasses
import os
import pathlib
import statistics
import subprocess
import tempfile
import time

import daemons
import plan as plans


@dataclasses.dataclass(frozen=True)
class Side:
    """Where one side of a measurement runs."""

    own: str = "127.0.0.1"
    other: str = "127.0.0.1"
    prefix: tuple = ()  # words before each command
    environment: tuple = ()


@dataclasses.dataclass
class Found:
    """The result of one run on one lane."""

    lane: plans.Lane
    latencies_us: list = dataclasses.field(default_factory=list)
    lost: int = 0
    silent: bool = False  # no message of this size arrived at all
    per_s: float = 0.0  # messages that arrived at full speed
    flood_lost_percent: float = 0.0

    @property
    def p50_us(self):
        return statistics.median(self.latencies_us) if self.latencies_us else None

    @property
    def paced_mb_per_s(self):
        """As the paper computes it: all bytes over the sum of the latencies."""
        total_us = sum(self.latencies_us)
        return self.lane.size * len(self.latencies_us) / total_us if total_us else None


def parse(text, lanes):
    """The lines of measure.cpp as one Found per lane, in order. Raises ValueError with a sentence for other text."""
    found = [Found(lane) for lane in lanes]
    damaged = 0
    for line in text.splitlines():
        kind, _, rest = line.partition(",")
        try:
            if kind == "latency":
                index, sent, values = rest.split(",")
                one = found[int(index)]
                one.latencies_us = [int(value) / 1e3 for value in values.split()]
                one.lost = int(sent) - len(one.latencies_us)
            elif kind == "flood":
                index, sent, received, seconds = rest.split(",")
                one = found[int(index)]
                one.per_s = int(received) / float(seconds) if float(seconds) > 0 else 0.0
                one.flood_lost_percent = 100 * (1 - int(received) / int(sent)) if int(sent) else 0.0
            elif kind == "silent":
                found[int(rest)].silent = True
            elif kind == "damaged":
                damaged += int(rest)
            else:
                raise ValueError(kind)
        except IndexError:
            raise ValueError(f'"{line}" names a lane that was not requested') from None
        except ValueError:
            raise ValueError(f'"{line}" is not a line of a result') from None
    if damaged:
        raise ValueError(f"{damaged} messages arrived damaged")
    return found


def failure(output):
    """The last output line of a program that failed."""
    words = [line for line in output.splitlines() if line.strip()]
    return words[-1] if words else "no error message"


def usual_limit_s(lanes):
    """Longer than a run of these lanes takes if nothing hangs."""
    return 20 + 3 * sum((lane.timed + lane.warm_up + 2) * (lane.pause_us + lane.transit_us) / 1e6 + lane.flood_ms / 1e3
                        for lane in lanes)


def commands(mode, common, sides):
    """(name of its output, words, environment) of every program of a run. The sender comes last."""
    program, (sending, receiving) = common[0], sides

    def command(name, role, side, *more):
        addresses = ["--own", side.own, "--other", side.other] if side.own != side.other else []
        words = [*side.prefix, program, role, mode.argument, *common[1:], *addresses, *more]
        return name, words, dict(side.environment)

    if not mode.inter:
        yield command("both", "both", sending)
        return
    several = ["--receivers", str(mode.receivers)] if mode.receivers > 1 else []
    for index in range(mode.receivers):
        yield command(f"sub{index}", "sub", receiving, *several, *(["--receiver", str(index)] if several else []))
    yield command("pub", "pub", sending, *several)


def measure(mode, lanes, programs, environment, number, limit_s, sides=(Side(), Side())):
    """(results, error). The error is empty if all went well, and a sentence otherwise.

    `sides`: of the sender and of the receiver."""
    program = pathlib.Path(programs, f"peer_{mode.program}").resolve()
    with tempfile.TemporaryDirectory(prefix="hgros_peer_") as folder:
        common = [program, "--name", f"hgb{os.getpid()}x{number}", "--folder", folder,
                  "--port", str(daemons.free_ports(len(lanes))),
                  "--lanes", ",".join(lane.argument() for lane in lanes)]
        if mode.inter:
            common += ["--control", f"{folder}/control"]
        processes, outputs = [], []
        try:
            for name, words, more in commands(mode, common, sides):
                outputs.append(pathlib.Path(folder, f"{name}.out"))
                with outputs[-1].open("wb") as out, outputs[-1].with_suffix(".err").open("wb") as err:
                    processes.append(subprocess.Popen(
                        words, cwd=folder, stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                        env={**os.environ, **environment, **dict(mode.environment), **more}))
            fault = wait(processes, limit_s)
        finally:
            daemons.end(*processes)
        if fault:
            said = "\n".join(output.with_suffix(".err").read_text(errors="replace") for output in outputs)
            fault = f"{fault}: {failure(said)}"
        try:
            return parse(outputs[-1].read_text(), lanes), fault
        except ValueError as error:
            return [], fault or str(error)


def wait(processes, limit_s):
    """Waits for the last program, which sends, and returns why it failed, if it did. Ends early if a receiver fails."""
    *receivers, sender = processes
    limit = time.monotonic() + limit_s
    while sender.poll() is None:
        if time.monotonic() > limit:
            return f"the run did not end within {limit_s:.0f} s"
        if any(receiver.poll() not in (None, 0) for receiver in receivers):
            return "the receiver failed"
        time.sleep(0.005)
    if sender.returncode != 0:
        return "the sender failed"
    patience = time.monotonic() + 3
    try:
        for receiver in receivers:
            receiver.wait(max(0, patience - time.monotonic()))
    except subprocess.TimeoutExpired:
        pass  # All messages are counted; the program is only slow to exit.
    return ""
