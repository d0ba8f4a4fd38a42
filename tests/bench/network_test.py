#!/usr/bin/env python3
"""Runs the benchmark between two hosts with scripts in place of its programs, and checks what it reports.

    HGROS_BENCH=<bench> network_test.py [TEST...]
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

BENCH = pathlib.Path(os.environ["HGROS_BENCH"])
sys.path[:0] = [str(BENCH / "peers"), str(BENCH / "network")]

import figures  # noqa: E402
import one_run  # noqa: E402
import plan  # noqa: E402
import report  # noqa: E402
import ways  # noqa: E402

KB = 1024
# Replaces a program: writes where it ran to standard error, and prints a latency of FACTOR us for every lane.
PROGRAM = """#!/bin/sh
ip -brief address >> ADDRESSES_$1
[ "$1" != sub ] || exit 0
for index in 0 1 2; do echo "latency,$index,1,FACTOR000"; done
echo "damaged,0"
"""


class Network(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="hgros_network_test_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def program(self, name, factor):
        path = self.folder / f"peer_{name}"
        path.write_text(PROGRAM.replace("FACTOR", factor).replace("ADDRESSES", str(self.folder / "addresses")))
        path.chmod(0o755)

    def run_network(self, *arguments):
        done = subprocess.run(
            [sys.executable, "-B", str(BENCH / "network" / "run_network.py"), "--programs", str(self.folder),
             "--runs", str(self.folder / "runs.csv"), "--quick", *arguments],
            capture_output=True, text=True, check=False, timeout=50,
            env={**os.environ, "PYTHONPATH": str(BENCH / "peers")})
        if "This benchmark needs two network namespaces" in done.stderr:
            self.skipTest(done.stderr.strip())
        return done

    def values(self, done):
        self.assertEqual(done.returncode, 0, done.stderr)
        return {name: float(value) for name, value, _ in (line.split(",") for line in done.stdout.splitlines())}

    def test_measures_both_lines_and_divides_ours_by_the_others(self):
        self.program("raw_socket", "2")
        self.program("ours", "6")
        self.program("cyclone", "3")
        values = self.values(self.run_network("--only", "raw_tcp,ours,cyclonedds"))
        for suffix in ("", "_100mbit"):
            self.assertEqual(values[f"latency_ratio_1KB{suffix}"], 3)
            self.assertEqual(values[f"network_vs_cyclonedds_4MB{suffix}"], 2)
            self.assertEqual(values[f"network_ours_p50_us_64KB{suffix}"], 6)
        self.assertAlmostEqual(values["line_time_us_4MB"] * 10, values["line_time_us_4MB_100mbit"], delta=10)

    def test_sender_and_receiver_run_on_hosts_that_share_only_the_line(self):
        self.program("ours", "1")
        self.run_network("--only", "ours")
        sender = (self.folder / "addresses_pub").read_text()
        receiver = (self.folder / "addresses_sub").read_text()
        self.assertIn("10.111.0.1", sender)
        self.assertNotIn("10.111.0.2", sender)
        self.assertIn("10.111.0.2", receiver)
        self.assertNotIn("10.111.0.1", receiver)
        self.assertEqual({line.split()[0].split("@")[0] for line in (sender + receiver).splitlines()},
                         {"lo", "hgba", "hgbb"})

    def test_a_missing_peer_is_left_out_with_one_sentence(self):
        self.program("ours", "1")
        done = self.run_network("--only", "ours,fastdds")
        self.assertEqual(done.stderr.count("fastdds is left out: it needs libfastrtps-dev."), 1, done.stderr)
        self.assertIn("network_ours_p50_us_1KB", self.values(done))

    def test_an_unknown_way_is_an_error_that_lists_the_known_ones(self):
        done = self.run_network("--only", "ros2")
        self.assertNotEqual(done.returncode, 0)
        self.assertRegex(done.stderr, "There is no way ros2; there are: raw_tcp, .*cyclonedds")

    def test_the_faster_way_of_a_peer_represents_it_in_each_round(self):
        line = ways.LINES[1]
        modes = {mode.peer: mode for mode in ways.ways(line)}
        results = report.Results(list(modes.values()), ways.QUICK)
        results.begin_round()
        for peer, us in (("ours", 6), ("fastdds", 4), ("fastdds_default", 3)):
            results.add(modes[peer], [one_run.Found(plan.Lane(KB, 1, 0, 0), [us])])
        values = {name: value for name, value, _ in figures.metrics(results)}
        self.assertEqual(values["network_vs_fastdds_1KB_100mbit"], 2)
        self.assertNotIn("network_vs_ros1_1KB_100mbit", values)

    def test_slow_lines_get_fewer_messages_and_longer_timeouts(self):
        fast, slow = (ways.FULL.lane(line, plan.MB * 4) for line in ways.LINES)
        self.assertGreater(fast.timed, slow.timed)
        self.assertEqual(slow.timed, ways.FULL.least)
        self.assertEqual(slow.transit_us, 335544)


if __name__ == "__main__":
    unittest.main()
