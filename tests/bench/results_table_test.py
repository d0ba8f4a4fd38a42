#!/usr/bin/env python3
"""Runs bench/results_table.py on made-up results, and reads the tables that it writes.

    HGROS_BENCH=<bench> results_table_test.py [TEST...]
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(os.environ["HGROS_BENCH"], "results_table.py")
PAGE = """before
<!-- results: written by bench/results_table.py -->
old
<!-- results: end -->
after
"""


class ResultsTable(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="hgros_results_test_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.page = self.folder / "page.md"
        self.page.write_text(PAGE)

    def result(self, name, *lines):
        (self.folder / name).mkdir()
        (self.folder / name / "result.csv").write_text("".join(f"{line}\n" for line in lines))
        (self.folder / name / "machine.txt").write_text("the machine\n")

    def write(self):
        done = subprocess.run([sys.executable, "-B", SCRIPT, "--results", self.folder, "--into", self.page],
                              capture_output=True, text=True, check=False, timeout=30)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.page.read_text()

    def test_every_metric_is_in_its_row_and_column(self):
        self.result("peers", "shm_p50_us_1KB,12.345,us", "shm_p50_us_4MB,1234.5,us", "shm_vs_ros1_64KB,0.25,ratio",
                    "raw_tcp_p50_us_1KB,9,us", "shm_fanout8_bulk_4MB_us,99.9,us")
        self.result("network", "network_ours_p50_us_1KB,80,us", "network_vs_ros1_1KB,0.5,ratio",
                    "network_vs_ros1_1KB_100mbit,0.75,ratio", "latency_ratio_4MB,1.01,ratio", "latency_4MB_ms,34,ms")
        text = self.write()
        for row in ("| `shm_p50_us` | 12.3 |  |  |  |  |  | 1230 |", "| `shm_vs_ros1` |  |  |  | 0.25 |  |  |  |",
                    "| `raw_tcp` | 9 |  |  |  |  |  |  |", "| `shm_fanout8_bulk_4MB_us` | 99.9 |",
                    "| `ours` | 80 |  |  |  |  |  |  |", "| `network_vs_ros1` | 0.5 |  |  |  |  |  |  |",
                    "| `network_vs_ros1` | 0.75 |  |  |  |  |  |  |", "| `latency_ratio` |  |  |  |  |  |  | 1.01 |"):
            self.assertIn(row, text)
        self.assertEqual(text.count("the machine."), 2)

    def test_means_throughput_and_viewers_have_their_own_tables(self):
        self.result("peers", "raw_tcp_p50_us_1KB,9,us", "raw_tcp_mean_us_1KB,11,us", "raw_call_paced_mb_per_s_5MB,700,MB/s")
        self.result("viewer", "fps_at_10s,11.5,1/s", "rviz_fps_at_10s,1.9,1/s", "frame_ms_10M,61,ms", "startup_ms,170,ms",
                    "rviz_startup_ms,320,ms", "installed_mb,14.4,MB")
        text = self.write()
        for row in ("| `raw_tcp` | 9 |  |  |  |  |  |  |", "| `raw_tcp` | 11 |  |  |  |  |  |  |",
                    "| `raw_call` |  |  |  | 700 |  |", "| `fps` | 11.5 |  |  |", "| `rviz_fps` | 1.9 |  |  |",
                    "| `frame_ms` |  | 61 |  |", "| `startup_ms` | 170 | 320 |", "| `installed_mb` | 14.4 |  |"):
            self.assertIn(row, text)

    def test_replaces_only_the_text_between_the_marks_and_is_repeatable(self):
        text = self.write()
        self.assertTrue(text.startswith("before\n") and text.endswith("after\n"))
        self.assertNotIn("old", text)
        self.assertIn("No result yet. `./dev bench peers` creates it.", text)
        self.assertEqual(self.write(), text)


if __name__ == "__main__":
    unittest.main()
