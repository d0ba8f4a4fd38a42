"""hgros doctor finds faults that are planted in the SLAM example."""

import json
import re
import os
import subprocess
import time
import unittest

import slam2d_programs

HGROS = os.environ["HGROS"]
FAULTS = os.environ["SLAM2D_FAULTS"]


class Doctor(slam2d_programs.Slam2dTest):
    def setUp(self):
        super().setUp()
        self.environment = {**os.environ, "HGROS_DOMAIN": f"doctor{os.getpid()}"}

    def hgros(self, *words):
        return subprocess.run([HGROS, *words], env=self.environment, text=True, capture_output=True,
                              timeout=slam2d_programs.DEADLINE_S)

    def findings(self):
        done = self.hgros("doctor", "--json")
        return done.returncode, [json.loads(line) for line in done.stdout.splitlines()]

    def start_demo(self):
        """The demo in real time, as one process that others discover."""
        self.start("--rate", "1", "--json", env=self.environment)

    def await_channel(self, name, users="publishers"):
        deadline = time.monotonic() + slam2d_programs.DEADLINE_S
        while not any(one["channel"] == name and one[users]
                      for one in map(json.loads, self.hgros("list", "--json").stdout.splitlines())):
            self.assertLess(time.monotonic(), deadline, name)

    def test_finds_five_faults(self):
        self.start_demo()
        faulty = subprocess.Popen([FAULTS], env=self.environment)
        self.processes.append(faulty)
        self.await_channel("trajectory")
        self.await_channel("trajectroy", "subscribers")
        viewer = subprocess.Popen([HGROS, "echo", "map", "--full"], env=self.environment, stdout=subprocess.DEVNULL)
        self.processes.append(viewer)
        self.await_channel("map", "subscribers")
        forbidden = self.hgros("control", "forbid", "map", "--session", "slam2d")
        self.assertEqual(forbidden.returncode, 0, forbidden)

        deadline = time.monotonic() + slam2d_programs.DEADLINE_S
        expected = (
            r'type: reporter:\d+ publishes foxglove.PoseInFrame on "report", but faulty:\d+ subscribes to '
            r'foxglove.Log',
            r'name: Nobody publishes "trajectroy", to which faulty:\d+ subscribes. slam2d:\d+ publishes "trajectory"',
            r'callback: faulty:\d+ slow is busy for \d+ % of the time',
            r'queue: faulty:\d+ full drops .* because its queue of 4 is full',
            r'forbidden: slam2d:\d+ publishes "map", to which hgros:\d+ subscribes, but no message passes')
        while True:  # On a busy machine, not every two seconds show all.
            code, findings = self.findings()
            self.assertEqual(code, 1)
            said = "\n".join(one["check"] + ": " + one["what"] for one in findings)
            missing = [one for one in expected if not re.search(one, said)]
            if not missing:
                break
            self.assertLess(time.monotonic(), deadline, (missing, said))
        for one in findings:
            self.assertNotEqual(one["fix"], "", one)

    def test_finds_nothing_in_the_demo_itself(self):
        self.start_demo()
        self.await_channel("trajectory")
        _, findings = self.findings()
        # A busy machine may slow down the demo.
        self.assertEqual([one for one in findings if one["check"] in ("type", "name", "publisher", "forbidden")], [])


if __name__ == "__main__":
    slam2d_programs.main(Doctor)
