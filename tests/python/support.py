"""What the tests of the Python package share. The package is found through PYTHONPATH."""

import contextlib
import os
import subprocess
import sys
import threading
import time
import unittest
import uuid

import hgros

DEADLINE_S = float(os.environ.get("HGROS_DEADLINE_S", 45.0))


def wait_until(predicate, what="the predicate"):
    """Waits until predicate() holds; fails after DEADLINE_S."""
    deadline = time.monotonic() + DEADLINE_S
    while not predicate():
        if time.monotonic() > deadline:
            raise AssertionError(f"{what} did not hold within {DEADLINE_S} s")
        time.sleep(0.002)


def rounds(few, many):
    """How often a test repeats what only chance may break: `few` times, or `many` with random seeds."""
    return many if os.environ.get("HGROS_SEED") == "random" else few


class RobotTest(unittest.TestCase):
    """Each test has a domain of its own."""

    def setUp(self):
        self.domain = "test_" + uuid.uuid4().hex[:12]
        os.environ["HGROS_DOMAIN"] = self.domain
        self.opened = contextlib.ExitStack()
        self.addCleanup(self.opened.close)

    def session(self, **options):
        return self.opened.enter_context(hgros.Session(**options))

    def spin_until(self, robot, predicate):
        deadline = time.monotonic() + DEADLINE_S
        while not predicate():
            self.assertLess(time.monotonic(), deadline, "the callbacks did not do what was awaited")
            robot.spin_once(0.05)

    @contextlib.contextmanager
    def beside(self, function):
        """While a thread runs the function, which has to end after the block."""
        thread = threading.Thread(target=function, daemon=True)
        thread.start()
        yield
        thread.join(DEADLINE_S)
        self.assertFalse(thread.is_alive(), "the thread does not end")

    def python(self, code):
        return self.program("-c", code)

    def program(self, *arguments):
        """A process of Python, with pipes for its input and output."""
        process = subprocess.Popen([sys.executable, *arguments], text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE)
        self.opened.callback(self._end, process)
        return process

    @staticmethod
    def _end(process):
        if process.poll() is None:
            process.kill()
        process.communicate()

    def finish(self, process):
        """Its output, error output and exit code, at the latest after DEADLINE_S."""
        out, err = process.communicate(timeout=DEADLINE_S)
        return out, err, process.returncode


def say_hello():
    """What a process of multiprocessing runs in a test."""
    from foxglove.Log_pb2 import Log

    with hgros.Session() as robot:
        publisher = robot.advertise("log", Log)
        assert robot.wait_for_subscribers("log", timeout=40)
        publisher.publish(Log(message="hello from a child"))


def main():
    unittest.main(verbosity=1)
