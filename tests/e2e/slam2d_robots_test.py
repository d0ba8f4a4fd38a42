#!/usr/bin/env python3
"""Runs the SLAM example's robot files, compares their results, and finds planted faults by hgros doctor.

    HGROS=<binary> SLAM2D=<folder> SLAM2D_REFERENCE=<binary> SLAM2D_CLOCK=<binary> SLAM2D_FAULTS=<binary>
        slam2d_robots_test.py [CLASS...]
"""

import contextlib
import gzip
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import time
import unittest

from slam2d_programs import DATA, DEADLINE_S, HGROS, ROBOTS, SCANS, SLOW, Slam2dTest

SHORT = {"source.params.scans": SCANS}


def free_ports(count):
    """Ports below those that the system gives to whoever asks for any, so that no other test gets one meanwhile."""
    given = int(pathlib.Path("/proc/sys/net/ipv4/ip_local_port_range").read_text().split()[0])
    lowest, ports = 10000, []
    span = max(given, 2 * lowest) - lowest
    for offset in range(span):
        port = lowest + (7 * os.getpid() + offset) % span
        with contextlib.suppress(OSError), socket.create_server(("", port)):
            ports.append(port)
        if len(ports) == count:
            break
    return ports


class Slam2dResults(Slam2dTest):
    def test_one_process_gets_the_reference_result_and_reports_it(self):
        (self.folder / "some.relations").write_text("0.0 1.0 1.3 0 0 0 0 0\n900.0 901.0 0 0 0 0 0 0\n")
        running = self.start("one_process.yaml", {**SHORT, "writer.params.relations": "some.relations"})
        self.assertEqual(self.hashes(running), self.reference(SCANS))
        self.assertRegex(self.report, r"log time    0\.0 s \.\. 9\.9 s, at [0-9.]+ times real time\n")
        self.assertRegex(self.report, r"relations   1 compared, 1 without poses: [0-9.]+ m \+- 0\.0000 m")
        self.assertTrue((self.folder / "slam2d_out/map.png").read_bytes().startswith(b"\x89PNG"))
        self.assertTrue((self.folder / "slam2d_out/odometry.png").exists())
        self.assertEqual(len((self.folder / "slam2d_out/trajectory.tum").read_text().splitlines()), SCANS)

    def test_three_processes_get_the_reference_result(self):
        scans = 300  # The path comes back to where it was.
        running = self.start("three_processes.yaml", {"source.params.scans": scans})
        self.assertEqual(self.hashes(running), self.reference(scans))

    def test_two_hosts_get_the_reference_result(self):
        ports = {f"hosts.{host}.port": port for host, port in zip(("cart", "base"), free_ports(2))}
        cart, base = (self.start("two_hosts.yaml", {**SHORT, **ports}, "--host", host, "--name", host)
                      for host in ("cart", "base"))
        self.assertEqual(self.hashes(base), self.reference(SCANS))
        code, out, err = self.end(cart)
        self.assertEqual(code, 0, out + err)

    def test_two_robots_get_the_reference_result_whoever_starts_first(self):
        for first in ("robot1.yaml", "robot2.yaml"):
            with self.subTest(first=first):
                robots = {}
                for robot in sorted(("robot1.yaml", "robot2.yaml"), key=lambda name: name != first):
                    self.on_free_ports(robot)
                    robots[robot] = self.start(robot, SHORT if robot == "robot1.yaml" else {})
                    if robot == first:
                        self.assertIn("COMPONENT", self.await_line(robots[robot], "COMPONENT"))
                self.assertEqual(self.hashes(robots["robot1.yaml"]), self.reference(SCANS))
                code, out, err = self.end(robots["robot2.yaml"])
                self.assertEqual(code, 0, out + err)

    def test_a_paced_log_gets_the_same_result(self):
        settings = {"source.params.scans": 50, "source.params.rate": 10}
        self.assertEqual(self.hashes(self.start("one_process.yaml", settings)), self.reference(50))


class Slam2dLogs(Slam2dTest):
    def test_a_log_gets_the_reference_result_in_one_and_three_processes(self):
        log = pathlib.Path(DATA) / "lidar2d/intel.clf.gz"
        if not DATA or not log.exists():
            self.skipTest("HGROS_DATA names no folder with lidar2d/intel.clf.gz")
        expected = self.reference(1500, log)
        settings = {"source.params.scans": 1500, "source.params.log": log}
        self.assertEqual(self.hashes(self.start("one_process.yaml", settings)), expected)
        self.assertEqual(self.hashes(self.start("three_processes.yaml", settings)), expected)


class Slam2dAnywhere(Slam2dTest):
    def test_each_component_may_run_anywhere(self):
        text = (ROBOTS / "one_process.yaml").read_text().replace("include: ", f"include: {ROBOTS}/")
        for component in ("source", "matcher", "mapper", "writer"):
            with self.subTest(component=component):
                file = self.folder / "apart.yaml"
                file.write_text(f"{text}processes: {{apart: {{components: [{component}], essential: true}}}}\n")
                self.assertEqual(self.hashes(self.start("apart.yaml", SHORT)), self.reference(SCANS))


class Slam2dOthers(Slam2dTest):
    def start_closed(self):
        """A robot that sends no scan to its own mapper."""
        self.on_free_ports("robot1.yaml")
        (self.folder / "closed.yaml").write_text("include: robot1.yaml\ncomponents: {mapper: {type: slam2d/Mapper}}\n"
                                                 "data_graph: {close_channels: [pre_channel]}\n")
        return self.start("closed.yaml", SHORT)

    def test_a_robot_without_a_mapper_or_whose_mapper_gets_no_scan_says_what_it_waits_for(self):
        closed = self.start_closed()
        self.start_apart()
        self.on_free_ports("robot1.yaml")
        alone = self.start("robot1.yaml", SHORT)
        self.assertIn("Does one run, and do the channels pre_channel, next_channel and map_state pass between the two?",
                      self.await_line(alone, "It waits for a mapper."))
        self.start("robot2.yaml")
        self.assertEqual(self.hashes(alone), self.reference(SCANS))
        self.assertIn("pre_channel", self.await_line(closed, "It waits for the map after the last scan."))
        closed.send_signal(signal.SIGINT)
        code, out, err = self.end(closed)
        self.assertEqual(code, -signal.SIGINT, out + err)

    def test_a_mapper_beside_a_robot_whose_own_one_gets_no_scan_does_its_work(self):
        self.on_free_ports("robot2.yaml")
        closed = self.start_closed()
        self.start("robot2.yaml")
        self.assertEqual(self.hashes(closed), self.reference(SCANS))

    def test_another_process_sleeps_by_the_logs_time(self):
        last_s = (SCANS - 1) / 10  # Ten scans a second.
        for robot in ("one_process.yaml", "three_processes.yaml"):
            with self.subTest(robot=robot):
                follower = self.popen(os.environ["SLAM2D_CLOCK"], 0.0001, last_s)
                running = self.start(robot, SLOW)
                # Between the first two scans, for which the robot waits 100 s.
                shown = float(follower.stdout.readline())
                self.assertGreaterEqual(shown, 0.0001)
                self.assertLess(shown, 0.1)
                # Without a rate the clock steps from scan to scan as they are processed, and stands still at the end.
                self.hgros_until_it_works(running, "param", "set", "source", "rate", 0)
                self.assertEqual(float(follower.stdout.readline()), last_s)
                self.assertEqual(self.hashes(running), self.reference(SCANS))

    def await_channel(self, name, users="publishers"):
        deadline = time.monotonic() + DEADLINE_S
        while not any(one["channel"] == name and one[users]
                      for one in map(json.loads, self.hgros("list", "--json").stdout.splitlines())):
            self.assertLess(time.monotonic(), deadline, name)

    def test_doctor_finds_five_faults_and_no_others_in_the_demo_itself(self):
        self.start("one_process.yaml", {"source.params.rate": 1})  # In real time, discovered by others.
        self.await_channel("trajectory")
        self.popen(os.environ["SLAM2D_FAULTS"])
        self.await_channel("trajectroy", "subscribers")
        self.popen(HGROS, "echo", "map", "--full", stdout=subprocess.DEVNULL)
        self.await_channel("map", "subscribers")
        forbidden = self.hgros("control", "forbid", "map", "--session", "main", "--timeout", "30")
        self.assertEqual(forbidden.returncode, 0, forbidden)

        deadline = time.monotonic() + DEADLINE_S
        expected = (
            r'type: reporter:\d+ publishes foxglove.PoseInFrame on "report", but faulty:\d+ subscribes to '
            r'foxglove.Log',
            r'name: Nobody publishes "trajectroy", to which faulty:\d+ subscribes. main:\d+ publishes "trajectory"',
            r'callback: faulty:\d+ slow is busy for \d+ % of the time',
            r'queue: faulty:\d+ full drops .* because its queue of 4 is full',
            r'forbidden: main:\d+ publishes "map", to which hgros:\d+ subscribes, but no message passes')
        while True:  # On a busy machine, not every two seconds show all.
            done = self.hgros("doctor", "--json", "--timeout", "30")
            self.assertEqual(done.returncode, 1)
            findings = [json.loads(line) for line in done.stdout.splitlines()]
            said = "\n".join(one["check"] + ": " + one["what"] for one in findings)
            missing = [one for one in expected if not re.search(one, said)]
            if not missing:
                break
            self.assertLess(time.monotonic(), deadline, (missing, said))
        # A busy machine may slow down the demo, and any machine may have faults of its own.
        of_channels = ("type", "name", "publisher", "forbidden")
        self.assertEqual(sorted(one["check"] for one in findings if one["check"] in of_channels),
                         ["forbidden", "name", "type"], said)
        for one in findings:
            self.assertNotEqual(one["fix"], "", one)


class Slam2dEnds(Slam2dTest):
    def test_the_map_is_saved_on_request_and_by_ctrl_c(self):
        running = self.start("one_process.yaml", {"source.params.rate": 1, "writer.params.out": "so_far"})
        # Until the first scans are drawn, and the transforms of source and matcher have come.
        while "robot" not in (said := self.hgros_until_it_works(running, "call", "save_map", "{}").stdout):
            self.assertIsNone(running.poll())
        self.assertIn(f"{self.folder}/so_far/map.png", said)
        (self.folder / "so_far/map.png").unlink()
        running.send_signal(signal.SIGINT)
        _, out, _ = self.end(running)
        self.assertIn("This is the map so far:", out)
        self.assertIn("so_far/odometry.png", out)
        self.assertTrue((self.folder / "so_far/map.png").exists())

    def pid_of(self, component):
        for line in self.hgros("ps", "--json").stdout.splitlines():
            found = json.loads(line)
            if component in json.dumps(found.get("component", "")):
                return found["pid"]
        self.fail(f"hgros ps does not show {component}")

    def test_an_essential_process_that_is_killed_ends_the_robot(self):
        running = self.start("three_processes.yaml", SLOW)
        self.assertIn("COMPONENT", self.await_line(running, "COMPONENT"))
        os.kill(self.pid_of("matcher"), signal.SIGKILL)
        code, out, err = self.end(running)
        self.assertEqual(code, 1, out + err)
        self.assertIn('The robot ends, because "matching" is essential.', out + err)

    def test_a_mapper_that_is_killed_is_started_again_and_the_robot_goes_on(self):
        running = self.start("three_processes.yaml", SLOW)
        self.hgros_until_it_works(running, "call", "save_map", "{}")
        os.kill(self.pid_of("mapper"), signal.SIGKILL)
        self.assertIn("It is started again.", self.await_line(running, "started again"))
        self.hgros_until_it_works(running, "param", "set", "source", "rate", "0")
        code, out, err = self.end(running)
        self.assertEqual(code, 1, out + err)  # A process has failed.
        self.assertIn(f"writer    It has finished: {SCANS} scans are in the map.", out)

    def test_a_mapper_that_is_constructed_again_or_moves_draws_the_same_map(self):
        running = self.start("three_processes.yaml", SLOW)
        self.hgros_until_it_works(running, "call", "save_map", "{}")
        for name in ("mapper", "mapping"):
            self.hgros_until_it_works(running, "restart", name)
        self.hgros_until_it_works(running, "call", "save_map", "{}")
        while "starting" in self.hgros("ps").stdout:
            self.assertIsNone(running.poll())
        for place in ("matching", "files", "mapping", "matching"):
            moved = self.hgros("move", "mapper", "--to", place)
            self.assertEqual((moved.returncode, moved.stdout, moved.stderr), (0, "", ""))
        self.hgros_until_it_works(running, "param", "set", "source", "rate", "0")
        self.assertEqual(self.hashes(running), self.reference(SCANS))

    def test_unusable_input_is_an_error_that_names_it(self):
        empty = self.folder / "empty.clf"
        empty.write_text("# nothing\n")
        cases = ({"source.params.log": self.folder / "none.clf"}, "none.clf cannot be opened"), \
            ({"source.params.log": empty}, "empty.clf"), \
            ({"source.params.rate": "fast"}, "rate must be a number"), \
            ({"writer.params.relations": "none.relations"}, "none.relations"), \
            ({"source.params.lgo": "x"}, 'log')
        for settings, sentence in cases:
            with self.subTest(settings=settings):
                code, out, err = self.end(self.start("one_process.yaml", settings))
                self.assertNotEqual(code, 0, out + err)
                self.assertIn(sentence, out + err)

    def test_a_damaged_log_ends_the_robot_with_an_error(self):
        cut = self.folder / "cut.clf.gz"
        cut.write_bytes(gzip.compress(os.urandom(10000))[:5000])
        code, out, err = self.end(self.start("three_processes.yaml", {"source.params.log": cut}))
        self.assertEqual(code, 1, out + err)
        self.assertIn("cut.clf.gz", out + err)


if __name__ == "__main__":
    unittest.main()
