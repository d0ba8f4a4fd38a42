#!/usr/bin/env python3
"""Runs the SLAM example as one, two and three processes and as two robots, and compares their results.

    SLAM2D=<binary> SLAM2D_REFERENCE=<binary> slam2d_processes_test.py [TEST...]
"""

import gzip
import json
import os
import pathlib
import pty
import signal

from slam2d_programs import CLOSED, DATA, ROBOTS, SCANS, THREE, TWO, Slam2dTest, main


class Slam2dProcesses(Slam2dTest):
    def test_an_invalid_command_line_is_reported_with_the_fix(self):
        for arguments, sentence in (
                (["--log", "missing.log"], "The log missing.log cannot be opened: No such file or directory. Name a "),
                (["--log"], "--log needs a value after it."),
                (["--log", "--quiet"], "--log needs a value, but the option --quiet follows."),
                (["--scans", "none"], "--scans must be a whole number from 1 to 999999999, but is \"none\"."),
                (["--scans", "1", "--scans", "2"], "--scans may be given only once."),
                (["--scan", "5"], "There is no option --scan. Did you mean --scans?"),
                (["5"], "\"5\" does not belong to an option.")):
            code, _, err = self.end(self.start(*arguments))
            self.assertEqual((code, err.startswith(f"slam2d: {sentence}")), (2, True), err)

    def test_one_process_gets_the_reference_result(self):
        self.assertEqual(self.hashes(self.start("--json", "--scans", SCANS)), self.reference(SCANS))
        self.assertTrue((self.folder / "slam2d_out/map.png").read_bytes().startswith(b"\x89PNG"))
        self.assertEqual(len((self.folder / "slam2d_out/trajectory.tum").read_text().splitlines()), SCANS)

    def test_two_processes_get_the_reference_result(self):
        self.assert_all_agree(self.start_plan(TWO, {"front": ["--scans", SCANS]}), self.reference(SCANS))

    def test_three_processes_get_the_reference_result(self):
        self.assert_all_agree(self.start_plan(THREE, {"source": ["--scans", SCANS]}), self.reference(SCANS))

    def test_three_processes_find_each_other_by_themselves(self):
        domain = {**os.environ, "HGROS_DOMAIN": f"slam2d-test-{os.getpid()}"}
        processes = {}
        for name, (nodes, *_) in THREE.items():
            config = self.folder / f"{name}.yaml"
            config.write_text(f"slam2d:\n  nodes: {nodes}\n")
            more = ["--scans", SCANS] if name == "source" else []
            processes[name] = self.start("--json", "--config", config, *more, env=domain)
        self.assert_all_agree(processes, self.reference(SCANS))

    def test_the_mapper_moves_to_another_robot_while_running(self):
        extra = {"robot1": ["--scans", SCANS, "--move-mapper-at", 120]}
        processes = self.start_plan(ROBOTS, extra)
        code, out, err = self.end(processes["robot2"])
        self.assertEqual(code, 0, err)
        mapped = [json.loads(line) for line in out.splitlines()]
        # The scans from 120 on, and the end.
        self.assertEqual([one["messages"] for one in mapped if one.get("node") == "mapper"], [SCANS - 120 + 1])
        self.assertEqual(self.hashes(processes["robot1"]), self.reference(SCANS))

    def test_a_closed_channel_leaves_its_node_to_another_process(self):
        for first in ("robot1", "robot2"):
            with self.subTest(first=first):
                processes = {}
                for name in sorted(CLOSED, key=lambda name: name != first):
                    file = self.write_config(name, CLOSED[name])
                    if name == "robot1":
                        file.write_text(file.read_text() + "data_graph: {close_channels: [pre_channel]}\n")
                    more = ["--scans", SCANS] if name == "robot1" else []
                    processes[name] = self.start("--json", "--patience", 20, "--config", file, *more)
                    if name == first:
                        self.assertTrue(self.await_line(processes[name], "Waiting for the"))
                code, _, err = self.end(processes["robot2"])
                self.assertEqual(code, 0, err)
                self.assertEqual(self.hashes(processes["robot1"]), self.reference(SCANS))

    def test_a_paced_log_gets_the_same_result(self):
        self.assertEqual(self.hashes(self.start("--json", "--scans", 50, "--rate", 10)), self.reference(50))

    def test_a_log_gets_the_reference_result_in_one_and_three_processes(self):
        log = pathlib.Path(DATA) / "lidar2d/intel.clf.gz"
        if not DATA or not log.exists():
            self.skipTest("HGROS_DATA names no folder with lidar2d/intel.clf.gz")
        expected = self.reference(1500, log)
        self.assertEqual(self.hashes(self.start("--json", "--scans", 1500, "--log", log)), expected)
        self.assert_all_agree(self.start_plan(THREE, {"source": ["--scans", 1500, "--log", log]}), expected)

    def test_ctrl_c_writes_the_map_so_far(self):
        ours, theirs = pty.openpty()
        process = self.start("--rate", 1, "--out", "so_far", stderr=theirs, text=False)
        os.close(theirs)
        seen = b""
        while b"scan " not in seen:
            seen += os.read(ours, 4096)
        process.send_signal(signal.SIGINT)
        code, out, _ = self.end(process)
        os.close(ours)
        self.assertEqual(code, 130)
        self.assertIn(b"so_far/map.png", out)
        self.assertIn(b"so_far/odometry.png", out)
        self.assertTrue((self.folder / "so_far/map.png").exists())

    def test_the_map_is_saved_when_another_process_asks(self):
        own = {**os.environ, "HGROS_DOMAIN": f"slam2d-{os.getpid()}-saved"}
        running = self.start("--json", "--scans", 100, "--rate", 2, env=own)
        code = 1
        while code != 0 and running.poll() is None:  # until the first scans are drawn
            code, out, err = self.end(self.start("--save-map", env=own))
        self.assertEqual(code, 0, err)
        self.assertIn(f"{self.folder}/slam2d_out/map.png, after ", out)
        self.assertTrue((self.folder / "slam2d_out/map.png").exists())
        self.assertIn("log time    0.0 s .. ", out)
        self.assertIn("robot       x = ", out)  # the transforms of source and matcher
        self.assertEqual(self.hashes(running), self.reference(100))

    def test_saving_the_map_reports_at_once_that_no_demo_runs(self):
        code, _, err = self.end(self.start("--save-map", env={**os.environ, "HGROS_DOMAIN": f"slam2d-{os.getpid()}"}))
        self.assertEqual(code, 1)
        self.assertIn("The map was not saved: Nobody serves \"save_map\"", err)

    def test_a_process_that_dies_ends_the_others(self):
        processes = self.start_plan(THREE, {"source": ["--rate", 1]})
        err = ""
        while "scan " not in err:  # the first line of progress: it runs
            err = processes["mapper"].stderr.readline()
            self.assertNotEqual(err, "", "the mapper has ended")
        processes["mapper"].kill()
        for name in ("source", "matcher"):
            code, _, err = self.end(processes[name])
            self.assertEqual(code, 1, err)
            self.assertIn("which ran mapper and writer, is gone before the work was done", err)

    def test_a_process_without_the_others_ends_with_an_error(self):
        process = self.start("--config", self.write_config("matcher", THREE["matcher"]), "--patience", 1)
        code, _, err = self.end(process)
        self.assertEqual(code, 1)
        self.assertIn("no other process with the source was found within 1 s", err)

    def test_invalid_input_ends_with_code_2_and_an_error(self):
        cut = self.folder / "cut.clf.gz"
        cut.write_bytes(gzip.compress(os.urandom(10000))[:5000])
        empty = self.folder / "empty.clf"
        empty.write_text("# nothing\n")
        unknown_node = self.folder / "node.yaml"
        unknown_node.write_text("slam2d: {nodes: [maper]}\n")
        unknown_key = self.folder / "key.yaml"
        unknown_key.write_text("slam2d: {node: [mapper]}\n")
        front = self.write_config("front", TWO["front"])
        cases = {("--log", self.folder / "none.clf"): "none.clf",
                 ("--log", cut): "cut.clf.gz",
                 ("--log", empty): "empty.clf",
                 ("--rate", "fast"): "--rate",
                 ("--config", unknown_node): "node.yaml:1:18: There is no node \"maper\"",
                 ("--config", unknown_key): "key.yaml:1:10: Unknown key \"node\" in slam2d",
                 ("--config", front, "--move-mapper-at", 5): "--move-mapper-at is for the process that runs the mapper",
                 ("--config", self.folder / "none.yaml"): "none.yaml"}
        for arguments, sentence in cases.items():
            with self.subTest(arguments=arguments):
                code, out, err = self.end(self.start(*arguments))
                self.assertEqual((code, out), (2, ""), err)
                self.assertIn(sentence, err)


if __name__ == "__main__":
    main(Slam2dProcesses)
