#!/usr/bin/env python3
"""Follows the log time of the SLAM example, in its own processes and in others.

    HGROS=<binary> SLAM2D=<folder> SLAM2D_REFERENCE=<binary> SLAM2D_CLOCK=<binary>
        slam2d_clock_test.py [TEST...]
"""

import os

from slam2d_programs import SCANS, SLOW, Slam2dTest, main

LAST_S = (SCANS - 1) / 10  # Ten scans a second.


class Slam2dClock(Slam2dTest):
    def test_another_process_sleeps_by_the_logs_time(self):
        for robot in ("one_process.yaml", "three_processes.yaml"):
            with self.subTest(robot=robot):
                follower = self.popen(os.environ["SLAM2D_CLOCK"], 0.0001, LAST_S)
                running = self.start(robot, SLOW)
                # Between the first two scans, for which the robot waits 100 s.
                shown = float(follower.stdout.readline())
                self.assertGreaterEqual(shown, 0.0001)
                self.assertLess(shown, 0.1)
                # Without a rate the clock steps from scan to scan as they are processed, and stands still at the end.
                self.hgros_until_it_works(running, "param", "set", "source", "rate", 0)
                self.assertEqual(float(follower.stdout.readline()), LAST_S)
                self.assertEqual(self.hashes(running), self.reference(SCANS))

    def test_the_report_names_the_time_of_the_log(self):
        code, out, err = self.end(self.start("one_process.yaml", {"source.params.scans": 20}))
        self.assertEqual(code, 0, err)
        self.assertRegex(out, r"log time    0\.0 s \.\. 1\.9 s, at [0-9.]+ times real time\n")


if __name__ == "__main__":
    main(Slam2dClock)
