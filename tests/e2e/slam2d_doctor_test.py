"""hgros doctor finds faults that are planted in the SLAM example."""

import json
import os
import re
import subprocess
import time

import slam2d_programs

FAULTS = os.environ["SLAM2D_FAULTS"]


class Doctor(slam2d_programs.Slam2dTest):
    def findings(self):
        done = self.hgros("doctor", "--json", "--timeout", "30")
        return done.returncode, [json.loads(line) for line in done.stdout.splitlines()]

    def start_demo(self):
        """The demo in real time, as one process that others discover."""
        self.start("one_process.yaml", {"source.params.rate": 1})

    def await_channel(self, name, users="publishers"):
        deadline = time.monotonic() + slam2d_programs.DEADLINE_S
        while not any(one["channel"] == name and one[users]
                      for one in map(json.loads, self.hgros("list", "--json").stdout.splitlines())):
            self.assertLess(time.monotonic(), deadline, name)

    def test_finds_five_faults(self):
        self.start_demo()
        self.popen(FAULTS)
        self.await_channel("trajectory")
        self.await_channel("trajectroy", "subscribers")
        self.popen(slam2d_programs.HGROS, "echo", "map", "--full", stdout=subprocess.DEVNULL)
        self.await_channel("map", "subscribers")
        forbidden = self.hgros("control", "forbid", "map", "--session", "main", "--timeout", "30")
        self.assertEqual(forbidden.returncode, 0, forbidden)

        deadline = time.monotonic() + slam2d_programs.DEADLINE_S
        expected = (
            r'type: reporter:\d+ publishes foxglove.PoseInFrame on "report", but faulty:\d+ subscribes to '
            r'foxglove.Log',
            r'name: Nobody publishes "trajectroy", to which faulty:\d+ subscribes. main:\d+ publishes "trajectory"',
            r'callback: faulty:\d+ slow is busy for \d+ % of the time',
            r'queue: faulty:\d+ full drops .* because its queue of 4 is full',
            r'forbidden: main:\d+ publishes "map", to which hgros:\d+ subscribes, but no message passes')
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
