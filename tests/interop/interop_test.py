"""Runs the peers of the languages against each other (README.md beside this file).

    interop_test.py LIST [LANGUAGE...]     all pairs, or those of these languages, and what is missing
    interop_test.py LIST --pair A B        one pair
    interop_test.py LIST --pair A B --hgros PROGRAM    the same and the command, through shared memory only

LIST is the file that CMake writes: the languages with their commands, and the packages of those that are missing.
"""

import argparse
import concurrent.futures
import contextlib
import itertools
import json
import os
import pathlib
import queue
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

COUNT = 500
ENDLESS = 1_000_000_000
CLOUD_BYTES = 1_500_000
PATIENCE_S = 40  # Most roles wait 30 s, and then say what did not come.


class Fault(Exception):
    """What a side did not do."""


class Language:
    def __init__(self, entry):
        self.name = entry["name"]
        self.command = entry["command"]
        self.environment = dict(variable.split("=", 1) for variable in entry["environment"])
        self.packages = entry["packages"]
        self.talks = True  # Until a process of it says otherwise.


class Side:
    """One side of a pair: a process that plays roles one after the other, or a process for each role if it cannot."""

    def __init__(self, language, environment, hgros):
        self.language = language
        self._hgros = hgros
        self._environment = {**os.environ, **language.environment, **environment}
        self._process = None
        self._lines = queue.Queue()
        self._log = []
        self._log_grown = threading.Condition()
        self._readers = []
        self._talks = False

    def start(self):
        """Starts the process, so that its runtime starts while others do something else. play() does it otherwise."""
        if self.language.talks and self._process is None:
            self._launch("talk")
            self._talks = True

    def play(self, *words):
        """Begins a role. The one that waits for the end of its input ends before that."""
        words = [str(word) for word in words]
        self.start()
        if self._talks and self._lines_ready():
            self._process.stdin.write(" ".join(words) + "\n")
            self._process.stdin.flush()
            return
        self.finish()
        self._launch(*words)

    def expect(self, pattern):
        """The next line of output, which has to match."""
        line = self._next_line()
        match = line is not None and re.fullmatch(pattern, line)
        if not match:
            raise Fault(f"{self.language.name} was to print \"{pattern}\", but " +
                             ("ended" if line is None else f"printed \"{line}\""))
        return match

    def expect_log(self, *words):
        """Waits until one line of the log has all these words; returns it."""
        def found():
            return next((line for line in self._log if all(word in line for word in words)), None)

        with self._log_grown:
            if not self._log_grown.wait_for(found, PATIENCE_S):
                raise Fault(f"the log of {self.language.name} has no line with " + " and ".join(words))
            return found()

    def rest(self):
        """Ends the role that waits for the end of its input."""
        if self._talks:
            self._process.stdin.write("\n")
            self._process.stdin.flush()
        else:
            self._process.stdin.close()

    def kill(self):
        self._process.send_signal(signal.SIGKILL)
        self._reap()

    def finish(self):
        """Ends the process, which has to succeed."""
        if self._process is None:
            return
        with contextlib.suppress(OSError):
            self._process.stdin.close()
        try:
            code = self._process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            raise Fault(f"{self.language.name} does not end") from None
        self._reap()
        if code != 0:
            raise Fault(f"{self.language.name} ended with the code {code}")
        if (line := self._next_line()) is not None:
            raise Fault(f"{self.language.name} printed \"{line}\" at its end")

    def expect_command(self, code, pattern, *arguments):
        """Runs the command `hgros` in the domain of this side, which has to end with the code and print the pattern."""
        ended = subprocess.run([self._hgros, *arguments, "--timeout", "40"], env=self._environment, encoding="utf-8",
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        if ended.returncode != code or not re.search(pattern, ended.stdout, re.DOTALL):
            raise Fault(f"hgros {arguments[0]} ended with the code {ended.returncode} and printed \"{ended.stdout}\"")

    def end_anyhow(self):
        if self._process is not None:
            self.kill()

    def end_of_log(self):
        return "".join(f"    {self.language.name}: {line}\n" for line in self._log[-12:])

    def _lines_ready(self):
        # A peer that talks says so first; one that cannot ends with an error.
        if self._talks != "ready":
            if self._next_line() == "ready":
                self._talks = "ready"
            else:
                self.language.talks = self._talks = False
                self.end_anyhow()
        return self._talks

    def _launch(self, *words):
        self._lines = queue.Queue()
        self._process = subprocess.Popen([*self.language.command, *words], stdin=subprocess.PIPE, encoding="utf-8",
                                         stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=self._environment)
        self._readers = [threading.Thread(target=self._read_lines, args=(self._process.stdout, self._lines)),
                         threading.Thread(target=self._read_log, args=(self._process.stderr,))]
        for reader in self._readers:
            reader.start()

    def _reap(self):
        self._process.wait()
        for reader in self._readers:
            reader.join()
        for stream in (self._process.stdin, self._process.stdout, self._process.stderr):
            with contextlib.suppress(OSError):  # What the process has not read.
                stream.close()
        self._process = None
        self._talks = False

    def _read_lines(self, stream, lines):
        for line in stream:
            lines.put(line.rstrip("\n"))
        lines.put(None)

    def _read_log(self, stream):
        for line in stream:
            with self._log_grown:
                self._log.append(line.rstrip("\n"))
                self._log_grown.notify_all()

    def _next_line(self):
        try:
            return self._lines.get(timeout=PATIENCE_S)
        except queue.Empty:
            raise Fault(f"{self.language.name} prints nothing") from None


# The scenarios, from `sender` to `receiver`. Each one has channels of its own.


def messages(sender, receiver, channel):
    receiver.play("subscribe", channel, COUNT)
    sender.play("publish", channel, COUNT)
    sender.expect("publishing")
    sender.expect(f"published {COUNT}")
    receiver.expect("receiving 1")
    receiver.expect(f"received {COUNT} {COUNT}")


def latched(sender, receiver, channel):
    sender.play("latch", channel, "wörd")
    sender.expect("latched")
    receiver.play("subscribe", channel, 1)
    receiver.expect("receiving wörd")
    receiver.expect("received 1 wörd")


def cloud(sender, receiver, channel):
    receiver.play("bulk-subscribe", channel, CLOUD_BYTES)
    receiver.expect("subscribed")
    sender.play("bulk-publish", channel, CLOUD_BYTES)
    sender.expect(f"published {CLOUD_BYTES}")
    receiver.expect(f"received {CLOUD_BYTES}")


def service(sender, receiver, channel):
    receiver.play("serve", channel)
    receiver.expect("serving")
    sender.play("call", channel, "hello")
    sender.expect("answer re: hello")
    sender.play("call", channel, "fail")
    sender.expect("failed (hgros: )?(handler failed: )?(Fault: )?asked to fail")  # As errors of the language are shown.


def mismatch(sender, receiver, channel):
    sender.play("latch", channel, "text")
    sender.expect("latched")
    receiver.play("misfit", channel)
    receiver.expect("subscribed")
    receiver.expect_log(channel, "foxglove.Log", "foxglove.PoseInFrame", " publishes ")


def killed(sender, receiver, channel):
    receiver.play("subscribe", channel, ENDLESS)
    sender.play("publish", channel, ENDLESS)
    sender.expect("publishing")
    receiver.expect("receiving 1")
    receiver.kill()  # The publisher goes on, and another subscriber gets its messages.
    receiver.play("subscribe", channel, ENDLESS)
    receiver.expect("receiving [0-9]+")
    sender.kill()  # The subscriber goes on, and takes the messages of another publisher.
    sender.play("publish", channel, COUNT)
    sender.expect("publishing")
    sender.expect(f"published {COUNT}")
    receiver.rest()
    last = int(receiver.expect("received [0-9]+ ([0-9]+)")[1])
    if not COUNT - 200 < last <= COUNT:  # What waits at both sides is not taken any more.
        raise Fault(f"of {COUNT} messages of the second publisher {last} was the last one that came")


# The same with the command `hgros`, which is C++, as one of the sides.


def echo(sender, receiver, channel):
    sender.play("latch", channel, "wörd")
    sender.expect("latched")
    receiver.expect_command(0, '"message":"wörd".*"message":"new"', "echo", channel, "--count", "2", "--json")


def pub(sender, receiver, channel):
    receiver.play("subscribe", channel, 1)
    sender.expect_command(0, "", "pub", channel, "{message: wörd}", "--type", "foxglove.Log")
    receiver.expect("receiving wörd")
    receiver.expect("received 1 wörd")


def call(sender, receiver, channel):
    receiver.play("serve", channel)
    receiver.expect("serving")
    sender.expect_command(0, '"message":"re: hello"', "call", channel, "{message: hello}", "--json")
    sender.expect_command(1, "asked to fail", "call", channel, "{message: fail}")


SCENARIOS = {"messages": messages, "latched": latched, "cloud": cloud, "service": service, "mismatch": mismatch,
             "killed": killed}
WITH_COMMAND = {"echo": echo, "pub": pub, "call": call}


class Tcp:
    """Only ZeroMQ reaches the other side: the sessions are not in the registry of the host."""

    name = "tcp"

    def __init__(self, folder):
        # Addresses of this test's own, because a process that starts again needs its port again.
        number = os.getpid() % 65536 * 4 + next(_tcp_pairs)
        host = f"127.{number >> 16 & 127 | 128}.{number >> 8 & 255}.{number & 255}"
        self._folder = folder
        self._ports = []
        for _ in range(2):
            with socket.socket() as probe:
                probe.bind((host, 0))
                self._ports.append(f"tcp://{host}:{probe.getsockname()[1]}")

    def environments(self):
        for own, other in (self._ports, reversed(self._ports)):
            yield {"XDG_RUNTIME_DIR": self._folder, "HGROS_DOMAIN": "none", "HGROS_INTEROP_YAML":
                   f"discovery: {{local: false}}\n"
                   f"network: {{publisher: {{ip: \"{own}\"}}, subscribers: [{{ip: \"{other}\"}}], "
                   # A lossless publisher waits so long for a subscriber that was killed.
                   f"heartbeat_ms: 200, peer_timeout_ms: 2000}}\n"}


class SharedMemory:
    """Only shared memory reaches the other side: the sessions have no endpoints."""

    name = "shared memory"

    def __init__(self, folder):
        self._folder = folder

    def environments(self):
        # Also with its own folder a session finds those of its domain in other folders.
        one = {"XDG_RUNTIME_DIR": self._folder, "HGROS_DOMAIN": self._folder.name, "HGROS_INTEROP_YAML": ""}
        return (one, one)


_tcp_pairs = itertools.count()


def run_transport(languages, transport, scenarios, hgros):
    """The scenarios over one transport, in both directions. Returns the seconds of each scenario."""
    times = {}
    # A language with itself needs one direction only.
    ways = [(0, 1)] if languages[0] is languages[1] else [(0, 1), (1, 0)]
    with contextlib.ExitStack() as stack:
        sides = [Side(*both, hgros) for both in zip(languages, transport.environments())]
        doing = "starting"
        try:
            for side in sides:
                stack.callback(side.end_anyhow)
                side.start()
            for name, scenario in scenarios.items():
                begin = time.monotonic()
                for way, (sender, receiver) in enumerate(ways):
                    doing = f"{name} from {languages[sender].name} to {languages[receiver].name}"
                    scenario(sides[sender], sides[receiver], f"{name}{way}")
                times[name] = time.monotonic() - begin
            doing = "ending"
            for side in sides:
                side.finish()
        except (Fault, OSError) as fault:
            logs = "".join(side.end_of_log() for side in sides)
            pair = " and ".join(language.name for language in languages)
            raise Fault(f"{pair} over {transport.name}, {doing}: {fault}.\n{logs}") from None
    return times


def run_pair(first, second, with_times, hgros):
    """With the command `hgros` through shared memory only. Raises Fault; returns the lines about the pair."""
    begin = time.monotonic()
    folder = pathlib.Path(tempfile.mkdtemp(prefix="interop-"))
    transports = [SharedMemory(folder)] if hgros else [SharedMemory(folder), Tcp(folder)]
    scenarios = {**SCENARIOS, **WITH_COMMAND} if hgros else SCENARIOS
    try:
        with concurrent.futures.ThreadPoolExecutor(2) as threads:
            runs = {transport.name: threads.submit(run_transport, (first, second), transport, scenarios, hgros)
                    for transport in transports}
            times = {name: one.result() for name, one in runs.items()}
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    ways = "one way" if first is second else "both ways"
    lines = [f"{first.name} and {second.name}, {ways}, {' and '.join(times)}: {', '.join(scenarios)} "
             f"({time.monotonic() - begin:.1f} s)"]
    if with_times:
        lines += [f"    {name}: " + ", ".join(f"{what} {seconds:.2f} s" for what, seconds in one.items())
                  for name, one in times.items()]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("list")
    parser.add_argument("languages", nargs="*")
    parser.add_argument("--pair", nargs=2)
    parser.add_argument("--hgros")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--times", action="store_true", help="also the seconds of each scenario")
    arguments = parser.parse_args()
    listed = {entry["name"]: Language(entry)
              for entry in json.loads(pathlib.Path(arguments.list).read_text(encoding="utf-8"))}
    for name in [*arguments.languages, *(arguments.pair or [])]:
        if name not in listed:
            print(f"There is no language \"{name}\". The languages are: {', '.join(listed)}.", file=sys.stderr)
            return 2
    there = [language for language in listed.values() if language.command]
    if arguments.pair:
        pairs = [tuple(listed[name] for name in arguments.pair)]
        if any(not language.command for pair in pairs for language in pair):
            print("skipped: " + ", ".join(f"{one.name} is not here" for one in pairs[0] if not one.command))
            return 77
    else:
        pairs = [pair for pair in itertools.combinations_with_replacement(there, 2)
                 if not arguments.languages or any(language.name in arguments.languages for language in pair)]
    failed = 0
    begin = time.monotonic()
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as threads:
        runs = [threads.submit(run_pair, *pair, arguments.times, arguments.hgros) for pair in pairs]
        for run in runs:
            try:
                print(run.result(), flush=True)
            except Fault as fault:
                failed += 1
                print(f"FAILED: {fault}", flush=True)
    if not arguments.pair:
        print(f"{len(pairs) - failed} of {len(pairs)} pairs passed in {time.monotonic() - begin:.0f} s.")
        for language in listed.values():
            if not language.command:
                print(f"{language.name} is not here: it needs {language.packages} (./dev setup languages).")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
