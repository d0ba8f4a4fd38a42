"""The SLAM example as its tests start it: HGROS is the command, SLAM2D the folder of the example's robot files,
SLAM2D_REFERENCE a program that computes the same without the library."""

import contextlib
import json
import os
import pathlib
import re
import subprocess
import tempfile
import time
import unittest

HGROS = os.environ["HGROS"]
ROBOTS = pathlib.Path(os.environ["SLAM2D"])
REFERENCE = os.environ["SLAM2D_REFERENCE"]
DATA = os.environ.get("HGROS_DATA", "")
DEADLINE_S = float(os.environ.get("SLAM2D_DEADLINE_S", "50"))
SCANS = 100
# So slow that the robot ends only if the rate is set.
SLOW = {"source.params.scans": SCANS, "source.params.rate": 0.001}


class Slam2dTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="slam2d_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.start_apart()
        self.processes = []
        self.addCleanup(self.end_processes)

    def start_apart(self):
        """What starts from now on does not meet what runs already."""
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=self.folder))
        self.environment = {**os.environ, "HGROS_DOMAIN": self.folder.name}

    def end_processes(self):
        for process in self.processes:
            if process.poll() is None:
                process.kill()
            with contextlib.suppress(ValueError):
                process.communicate()

    def popen(self, *words, **options):
        options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": self.environment,
                   **options}
        process = subprocess.Popen(list(map(str, words)), cwd=self.folder, **options)
        self.processes.append(process)
        return process

    def start(self, robot, settings=None, *more, **options):
        """Runs a robot file of the example, or of the test's folder, with values from the command line."""
        sets = [word for path, value in (settings or {}).items() for word in ("--set", f"{path}={value}")]
        own = self.folder / robot
        return self.popen(HGROS, "run", own if own.exists() else ROBOTS / robot, *sets, *more, **options)

    def on_free_ports(self, robot):
        """A copy of a robot file whose endpoints are sockets in the test's folder, because ports may be in use."""
        text = (ROBOTS / robot).read_text().replace("include: ", f"include: {ROBOTS}/")
        (self.folder / robot).write_text(re.sub(r'"tcp://[^"]*:(\d+)"', rf'"ipc://{self.folder}/\1.ipc"', text))
        return robot

    def hgros(self, *words):
        return subprocess.run([HGROS, *map(str, words)], env=self.environment, cwd=self.folder, text=True,
                              capture_output=True, timeout=DEADLINE_S)

    def hgros_until_it_works(self, running, *words):
        """Repeats a command until it succeeds, as long as the robot runs."""
        while True:
            done = self.hgros(*words)
            if done.returncode == 0:
                return done
            self.assertIsNone(running.poll(), done)

    def await_line(self, process, part):
        """Reads what the robot writes until a line contains the text; returns the line, or "" at the end."""
        return next((line for line in iter(process.stdout.readline, "") if part in line), "")

    def end(self, process):
        """Waits for a process; returns exit code, standard output and standard error."""
        try:
            out, err = process.communicate(timeout=DEADLINE_S)
        except subprocess.TimeoutExpired:
            self.fail(f"{process.args} hangs")
        return process.returncode, out, err

    def hashes(self, process):
        """The hashes that a robot reports which ends well."""
        code, out, err = self.end(process)
        self.assertEqual(code, 0, out + err)
        found = re.findall(r"hashes      map ([0-9a-f]{16}), trajectory ([0-9a-f]{16})", out)
        self.assertEqual(len(found), 1, out + err)
        self.report = out
        return found[0]

    def reference(self, *arguments):
        done = subprocess.run([REFERENCE, *map(str, arguments)], check=True, text=True, capture_output=True,
                              timeout=DEADLINE_S)
        return tuple(done.stdout.split())
