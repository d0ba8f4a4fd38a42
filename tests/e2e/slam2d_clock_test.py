#!/usr/bin/env python3
"""Follows the log time of the SLAM example, in its own processes and in others.

    SLAM2D=<binary> SLAM2D_REFERENCE=<binary> SLAM2D_CLOCK=<binary> slam2d_clock_test.py [TEST...]
"""

import os
import pty
import re
import subprocess

from slam2d_programs import SCANS, THREE, Slam2dTest, main

LAST_S = (SCANS - 1) / 10  # Ten scans a second.


class Slam2dClock(Slam2dTest):
    def follow(self, *seconds, env):
        process = subprocess.Popen([os.environ["SLAM2D_CLOCK"], *map(str, seconds)], stdout=subprocess.PIPE, text=True,
                                   env=env)
        self.processes.append(process)
        return process

    def test_another_process_sleeps_by_the_logs_time(self):
        own = {**os.environ, "HGROS_DOMAIN": f"slam2d-{os.getpid()}-clock"}
        follower = self.follow(0.0001, LAST_S, env=own)
        running = self.start("--json", "--scans", SCANS, "--rate", 0.001, env=own)
        # Between the first two scans, for which the demo waits 100 s.
        shown = float(follower.stdout.readline())
        self.assertGreaterEqual(shown, 0.0001)
        self.assertLess(shown, 0.1)
        # Without a rate the clock steps from scan to scan as they are processed, and stands still after the last one.
        self.assertEqual(self.end(self.start("--set-param", "slam.source.rate=0", env=own))[0], 0)
        self.assertEqual(float(follower.stdout.readline()), LAST_S)
        self.assertEqual(self.hashes(running), self.reference(SCANS))

    def test_the_processes_of_the_demo_follow_the_logs_time(self):
        ours, theirs = pty.openpty()
        self.start("--config", self.write_config("mapper", THREE["mapper"]), stderr=theirs, text=False)
        os.close(theirs)
        for name, more in (("source", ["--rate", 2]), ("matcher", [])):
            self.start("--config", self.write_config(name, THREE[name]), *more)
        seen = b""
        while not re.search(rb"scan \d+, \d+ scans/s, log time [0-9]+\.[1-9] s", seen):
            seen += os.read(ours, 4096)
        os.close(ours)

    def test_every_process_reports_the_time_of_the_log(self):
        processes = self.start_plan(THREE, {"source": ["--scans", SCANS]})
        for process in processes.values():
            result = self.result(process)
            self.assertEqual((result["log_first_s"], result["log_last_s"]), (0.0, LAST_S))
        code, out, err = self.end(self.start("--scans", 20))
        self.assertEqual(code, 0, err)
        self.assertRegex(out, r"log time    0\.0 s \.\. 1\.9 s, at [0-9.]+ times real time\n")


if __name__ == "__main__":
    main(Slam2dClock)
