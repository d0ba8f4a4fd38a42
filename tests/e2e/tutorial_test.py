#!/usr/bin/env python3
"""Follows docs/tutorial.md as a new user does: writes its files into an empty folder, types its commands, and compares what
they print. Users have only the installed package, so it is installed first.

    HGROS_BUILD=<build folder> HGROS_PAGE=<tutorial.md> HGROS_EXAMPLE=<folder> CXX=<compiler> tutorial_test.py

The page has these blocks, and no others:
    ```cpp, cmake, yaml, python    a file, named in the first line
    ```console                     commands behind "$ ", each with the lines that it prints

In printed lines, a digit alone stands for itself, any other number for any number. A line that is only a number is compared. A
"-" stands for a number, too. A line "..." stands for any lines. The block after `<!-- second terminal -->` runs beside the next one. PID is the process of drive.
"""

import fcntl
import json
import os
import pathlib
import pty
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import termios
import time
import unittest

BUILD = os.environ["HGROS_BUILD"]
PAGE = pathlib.Path(os.environ["HGROS_PAGE"])
EXAMPLE = pathlib.Path(os.environ["HGROS_EXAMPLE"])
DEADLINE_S = 20

BLOCK = re.compile(r"(?P<mark><!-- second terminal -->\n)?^```(?P<kind>\w*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"\d+(?:[.:T-]\d+)*Z?")
# They change nothing, so they can be repeated until they print what is expected.
READING = re.compile(r"(?:HGROS_DOMAIN=\w+ )?hgros (?:components|echo|list|logs|ps|tf|top) ?")
OWN_NAMESPACES = "HGROS_TUTORIAL_NAMESPACES"


def blocks_of(page):
    """(line, kind, text, whether it is for a second terminal) of each block."""
    return [(page.count("\n", 0, found.start("text")) + 1, found["kind"], found["text"], bool(found["mark"]))
            for found in BLOCK.finditer(page)]


def commands_of(text):
    """(command, the lines that it prints) of a console block."""
    commands = []
    for line in text.splitlines():
        if line.startswith("$ "):
            commands.append((line[2:], []))
        else:
            commands[-1][1].append(line)
    return commands


def words_of(line):
    """The words of a printed line. N stands for what differs each time."""
    line = re.sub(r"\d+(?:\.\d+)? (?:[num]?s|min|Hz|%|[kM]?B)(?= |$)", "N", line.replace("/home/robot", os.environ["HOME"]))
    return re.sub(r"-{2,}", "-", NUMBER.sub(lambda number: number[0] if len(number[0]) == 1 else "N", line)).split()


def same_word(expected, printed):
    return expected == printed or (expected == "-" and re.fullmatch(r"N|\d", printed) is not None)


def is_number(line):
    return re.fullmatch(r"-?\d+(\.\d+)?", line) is not None


def same_line(expected, printed):
    if is_number(expected) and is_number(printed):  # The robot drives in real time, and the machine may be busy.
        return abs(float(printed) - float(expected)) <= 0.4 * abs(float(expected))
    words = words_of(expected), words_of(printed)
    return len(words[0]) == len(words[1]) and all(map(same_word, *words))


def same(expected, printed):
    if not expected:
        return not printed
    if expected[0] == "...":
        return any(same(expected[1:], printed[skipped:]) for skipped in range(len(printed) + 1))
    return bool(printed) and same_line(expected[0], printed[0]) and same(expected[1:], printed[1:])


class Terminal:
    """A shell that prints to a terminal, and keeps its folder and its variables from command to command."""

    def __init__(self, folder, environment):
        self.folder = folder
        ours, theirs = pty.openpty()
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 50, 130, 0, 0))
        self.shell = subprocess.Popen(["bash"], stdin=subprocess.PIPE, stdout=theirs, stderr=theirs, text=True, cwd=folder,
                                      env={**environment, "TERM": "dumb", "NO_COLOR": "1"})
        os.close(theirs)
        self.printed = open(ours, encoding="utf-8", newline="\n")

    def start(self, command):
        self.shell.stdin.write(f"{command}\nprintf '\\n%s %s %s\\n' --end-- $? \"$PWD\"\n")
        self.shell.stdin.flush()

    def end(self):
        """The lines that the last command has printed, and its exit code."""
        lines = []
        while not (line := self.printed.readline().rstrip("\r\n")).startswith("--end-- "):
            lines.append(line)
        _, code, self.folder = line.split(" ", 2)
        return lines[:-1] if lines[-1] == "" else lines, int(code)

    def run(self, command):
        self.start(command)
        return self.end()

    def close(self):
        self.shell.stdin.close()
        self.shell.wait()
        self.printed.close()


class Host:
    """A network of its own, for as long as the process that holds it runs."""

    def __init__(self):
        self.holder = subprocess.Popen(["unshare", "-n", "cat"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                       stderr=subprocess.DEVNULL)
        try:
            self.holder.stdin.write(b"\n")
            self.holder.stdin.flush()
        except BrokenPipeError:
            pass
        self.ready = self.holder.stdout.read(1) == b"\n"

    def end(self):
        self.holder.stdin.close()
        self.holder.wait()
        self.holder.stdout.close()

    def inside(self, command):
        return f"nsenter --net=/proc/{self.holder.pid}/ns/net {command}"


class Tutorial(unittest.TestCase):
    def setUp(self):
        home = tempfile.TemporaryDirectory(prefix="tutorial_")
        self.addCleanup(home.cleanup)
        self.home = pathlib.Path(home.name)
        os.environ["HOME"] = home.name
        subprocess.run(["cmake", "--install", BUILD, "--prefix", self.home / "hgros", "--strip"], check=True,
                       stdout=subprocess.DEVNULL)
        self.assertFalse((self.home / "hgros/share/hgros/components/teleop.yaml").exists())  # The page makes it.
        self.domain = self.home.name
        self.environment = {name: value for name, value in os.environ.items() if name != "HGROS_COMPONENT_PATH"}
        self.environment.update(HGROS_DOMAIN=self.domain, PATH=f"{self.home}/hgros/bin:{os.environ['PATH']}")
        self.terminals = []
        self.killed = False  # From then on, where the robot is shows what was restored.
        self.first = self.terminal(self.home)
        self.addCleanup(self.end_everything)

    def terminal(self, folder):
        opened = Terminal(folder, self.environment)
        self.terminals.append(opened)
        return opened

    def end_everything(self):
        for domain in ("", "robot", "desk"):
            subprocess.run([self.home / "hgros/bin/hgros", "stop"], check=False, timeout=DEADLINE_S,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                           env={**self.environment, "HGROS_DOMAIN": self.domain + domain})
        for terminal in self.terminals:
            terminal.close()

    def typed(self, command):
        """The command as it is run here: in domains of its own, and with the real process."""
        command = re.sub(r"HGROS_DOMAIN=(\w+)", rf"HGROS_DOMAIN={self.domain}\1", command)
        return re.sub(r"\bPID\b", str(self.pid_of("drive")), command) if "PID" in command else command

    def pid_of(self, component):
        lines, _ = self.first.run("hgros ps --json")
        return next(one["pid"] for one in map(json.loads, lines) if component in str(one.get("component")))

    def compare(self, line, command, expected, printed, code):
        where = f"{PAGE.name}:{line}: $ {command}\n" + "\n".join(printed) + f"\nexit code {code}"
        fails = any(one.startswith("hgros: ") and not one.startswith("hgros: warning: ") for one in expected)
        self.assertEqual(code != 0, fails, where)
        self.assertTrue(same(expected, printed), where + "\nbut the page says\n" + "\n".join(expected))

    def drive_on(self, expected, printed):
        """A robot whose process stood still for longer than its time-out has not driven meanwhile."""
        if self.killed or not all(map(is_number, (*expected[:1], *printed[:1]))):
            return
        if expected and printed and float(printed[0]) < float(expected[0]):
            self.first.run("hgros pub wanted '{x: 0.4}'")

    def type_command(self, line, command, expected):
        self.killed = self.killed or command.startswith("kill ")
        deadline = time.monotonic() + DEADLINE_S
        while True:
            printed, code = self.first.run(self.typed(command))
            if same(expected, printed) or not READING.match(command) or time.monotonic() > deadline:
                break
            self.drive_on(expected, printed)
        self.compare(line, command, expected, printed, code)

    def follow(self, blocks):
        beside = None
        for line, kind, text, second in blocks:
            if kind != "console":
                self.assertIn(kind, ("cpp", "cmake", "yaml", "python"), f"{PAGE.name}:{line}")
                name = re.match(r"(?://|#) ([\w.]+)", text)
                self.assertTrue(name, f"{PAGE.name}:{line}: the first line does not name the file")
                pathlib.Path(self.first.folder, name[1]).write_text(text, encoding="utf-8")
                continue
            self.assertTrue(text.startswith("$ "), f"{PAGE.name}:{line}: a console block begins with a command")
            if second:
                self.assertIsNone(beside)
                *before, (command, expected) = commands_of(text)
                beside = (self.terminal(self.home), line, command, expected)
                for one, _ in before:
                    self.assertEqual(beside[0].run(one), ([], 0))
                beside[0].start(self.typed(command))
                continue
            for command, expected in commands_of(text):
                self.type_command(line, command, expected)
            if beside:
                self.compare(*beside[1:], *beside[0].end())
                beside = None
        self.assertIsNone(beside)

    def position(self, command):
        lines, _ = self.first.run(command + " echo odometry --once --field pose.position.x")
        return float(lines[0]) if lines and is_number(lines[0]) else 0.0

    def await_position(self, command, least, drive=lambda: None):
        deadline = time.monotonic() + DEADLINE_S
        while (position := self.position(command)) < least:
            drive()
            self.assertLess(time.monotonic(), deadline, position)

    def test_the_page_leads_to_the_example(self):
        started = time.monotonic()
        self.follow(blocks_of(PAGE.read_text(encoding="utf-8")))
        print(f"All steps took {time.monotonic() - started:.0f} s.")
        written = {path.name: path.read_text() for path in pathlib.Path(self.first.folder).iterdir() if path.is_file()}
        self.assertEqual(written, {path.name: path.read_text() for path in EXAMPLE.iterdir()})
        self.drive_by_keyboard()
        self.drive_between_two_networks()

    def drive_by_keyboard(self):
        self.first.run("hgros run two_processes.yaml --detach")
        ours, theirs = pty.openpty()
        pilot = subprocess.Popen([sys.executable, "pilot.py"], cwd=self.first.folder, env=self.environment, stdin=theirs)
        self.addCleanup(pilot.kill)
        self.await_position("hgros", 0.1, lambda: os.write(ours, b"w"))  # Keys before its start are lost.
        os.write(ours, b"q")
        self.assertEqual(pilot.wait(DEADLINE_S), 0)
        os.close(ours)
        os.close(theirs)
        self.first.run("hgros stop")

    def drive_between_two_networks(self):
        """As on two computers: two networks with a cable between them."""
        hosts = {"robot": Host(), "desk": Host()}
        for host in hosts.values():
            self.addCleanup(host.end)
        if not all(host.ready for host in hosts.values()):
            print("Two networks were not tried: this system does not allow network namespaces.")
            return
        robot, desk = hosts["robot"].holder.pid, hosts["desk"].holder.pid
        steps = [f"ip link add hgta netns {robot} type veth peer name hgtb netns {desk}"]
        for host, device, address in (("robot", "hgta", "10.197.0.1"), ("desk", "hgtb", "10.197.0.2")):
            steps += [hosts[host].inside(f"ip {words}") for words in
                      (f"address add {address}/24 dev {device}", "link set lo up", f"link set {device} up")]
        for step in steps:
            self.assertEqual(self.first.run(step), ([], 0), step)

        def hgros(host):
            return f"HGROS_DOMAIN={self.domain}{host} " + hosts[host].inside("hgros")
        for host in hosts:
            self.addCleanup(lambda host=host: self.first.run(hgros(host) + " stop"))
        second = self.terminal(self.first.folder)
        run = " run two_hosts.yaml --detach --set hosts.robot.address=10.197.0.1 --set hosts.desk.address=10.197.0.2 --host "
        second.start(hgros("robot") + run + "robot")
        printed, code = self.first.run(hgros("desk") + run + "desk")
        self.assertEqual((code, second.end()[1]), (0, 0), printed)
        self.assertEqual(self.position(hgros("robot")), 0)
        self.first.run(f"HGROS_DOMAIN={self.domain}desk " + hosts["desk"].inside("python3 pilot.py www"))
        self.await_position(hgros("robot"), 0.3)
        for host in hosts:
            self.assertEqual(self.first.run(hgros(host) + " stop")[1], 0)


def enter_own_namespaces():
    """Continues with a network and processes of its own if possible: the page's ports may be in use outside, and what
    runs in the background ends with this program, however it ends."""
    os.environ[OWN_NAMESPACES] = "tried"
    words = ["unshare", "--net", "--pid", "--fork", "--kill-child", "--mount-proc"]
    words += ["--map-root-user"] if os.geteuid() != 0 else []
    inside = ["sh", "-c", 'ip link set lo up && "$@"', "sh"]
    if shutil.which("unshare") and shutil.which("ip") and subprocess.run(
            [*words, *inside, "true"], check=False, stderr=subprocess.DEVNULL).returncode == 0:
        os.execvp("unshare", [*words, *inside, sys.executable, "-B", *sys.argv])


if __name__ == "__main__":
    if OWN_NAMESPACES not in os.environ:
        enter_own_namespaces()
    unittest.main()
