#!/usr/bin/env python3
"""Runs the benchmarks against other middleware, on one host and between two, with scripts in place of their programs.
Checks what they report.

    HGROS_BENCH=<bench> peers_test.py [TEST...]
"""

import csv
import io
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

BENCH = pathlib.Path(os.environ["HGROS_BENCH"])
sys.path[:0] = [str(BENCH / "peers"), str(BENCH / "network")]

import figures  # noqa: E402
import headline  # noqa: E402
import modes  # noqa: E402
import one_run  # noqa: E402
import plan  # noqa: E402
import plots  # noqa: E402
import report  # noqa: E402
import ways  # noqa: E402

KB = 1024
# Replaces a program: prints latencies of 1, 2 and 6 times FACTOR us for every lane, and "silent" for silent lanes.
PROGRAM = """#!/bin/sh
[ "$1" != sub ] || exit 0
index=0
for lane in $(echo "${10}" | tr , ' '); do
  case $lane in
    *:0:0:*) ;;
    SILENT:*) echo "silent,$index" ;;
    *) echo "latency,$index,4,1000FACTOR 2000FACTOR 6000FACTOR " ;;
  esac
  index=$((index + 1))
done
echo "damaged,DAMAGED"
"""

# Replaces a program: writes where it ran to standard error, and prints a latency of FACTOR us for every lane.
FAR_PROGRAM = """#!/bin/sh
ip -brief address >> ADDRESSES_$1
[ "$1" != sub ] || exit 0
for index in 0 1 2; do echo "latency,$index,1,FACTOR000"; done
echo "damaged,0"
"""


def mode(peer, name, inter=True):
    return modes.Mode(peer, name, "script", name, inter)


def found(lane, *latencies_us, per_s=0.0):
    return one_run.Found(lane, list(latencies_us), per_s=per_s)


class Benchmark(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="hgros_peers_test_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def script(self, name, text):
        path = self.folder / f"peer_{name}"
        path.write_text(text)
        path.chmod(0o755)

    def run_script(self, script, *arguments):
        return subprocess.run(
            [sys.executable, "-B", str(BENCH / script), "--programs", str(self.folder),
             "--runs", str(self.folder / "runs.csv"), "--quick", *arguments],
            capture_output=True, text=True, check=False, timeout=50,
            env={**os.environ, "PYTHONPATH": str(BENCH / "peers")})


class Peers(Benchmark):
    def program(self, name, factor="", damaged="0", silent="none"):
        # ROLE MODE --name N --folder F --port P --lanes L: the lanes are the tenth word.
        self.script(name, PROGRAM.replace("FACTOR", factor).replace("DAMAGED", damaged).replace("SILENT", silent))

    def run_peers(self, *arguments):
        return self.run_script("peers/run_peers.py", *arguments)

    def test_parses_the_lines_of_a_program(self):
        lanes = [plan.Lane(KB, 3, 50, 0), plan.Lane(4 * KB, 3, 0, 0)]
        first, second = one_run.parse("latency,0,3,1500 2500 \nflood,0,200,150,0.5\nsilent,1\ndamaged,0\n", lanes)
        self.assertEqual(first.latencies_us, [1.5, 2.5])
        self.assertEqual((first.lost, first.per_s, first.flood_lost_percent), (1, 300, 25))
        self.assertTrue(second.silent)

    def test_refuses_lines_that_are_not_results_with_a_sentence(self):
        lanes = [plan.Lane(KB, 3, 0, 0)]
        for text, words in (("hello", "not a line of a result"), ("latency,0,3", "not a line of a result"),
                            ("silent,7", "a lane that was not requested"), ("damaged,2", "2 messages arrived damaged")):
            with self.assertRaisesRegex(ValueError, words):
                one_run.parse(text, lanes)

    def test_paced_throughput_is_all_bytes_over_the_sum_of_the_latencies(self):
        self.assertEqual(found(plan.Lane(3_000_000, 2, 0, 0, paced=True), 1000, 2000).paced_mb_per_s, 2000)

    def test_ratios_are_medians_over_rounds_that_have_both_sides(self):
        ours, other, inside = mode("ours", "ipc"), mode("ros1", "tcpros"), mode("ros1", "nodelet", inter=False)
        lane = plan.Lane(KB, 1, 50, 0)
        results = report.Results([ours, other, inside], plan.Plan(True, 3, 1, (lane,), (lane,)))
        for mine, theirs in ((1, 2), (9, 3), (4, 4)):
            results.begin_round()
            results.add(ours, [found(lane, mine, per_s=100)])
            results.add(other, [found(lane, theirs, per_s=50)])
        results.begin_round()
        results.add(ours, [found(lane, 1000)])  # No ratio counts this: the other is missing in its round.
        metrics = {name: value for name, value, _ in results.metrics()}
        self.assertEqual(metrics["ours_ipc_vs_ros1_tcpros_1KB"], 1)
        self.assertEqual(metrics["ours_ipc_vs_ros1_tcpros_msgs_per_s_1KB"], 2)
        self.assertEqual(metrics["ros1_tcpros_p50_us_1KB"], 3)
        self.assertFalse([name for name in metrics if "nodelet" in name])

    def test_a_fan_out_starts_every_receiver_and_then_the_sender(self):
        many = modes.Mode("ours", "fanout", "script", "bulk", True, receivers=3)
        started = list(one_run.commands(many, ["program", "--lanes", "L"], (one_run.Side(), one_run.Side())))
        self.assertEqual([name for name, _, _ in started], ["sub0", "sub1", "sub2", "pub"])
        self.assertEqual(started[2][1],
                         ["program", "sub", "bulk", "--lanes", "L", "--receivers", "3", "--receiver", "2"])
        self.assertEqual(started[3][1], ["program", "pub", "bulk", "--lanes", "L", "--receivers", "3"])

    def test_each_side_gets_its_addresses_environment_and_prefix(self):
        sides = (one_run.Side("10.0.0.1", "10.0.0.2", (), (("WHO", "sends"),)),
                 one_run.Side("10.0.0.2", "10.0.0.1", ("enter", "there"), (("WHO", "receives"),)))
        (_, there, receives), (_, here, sends) = one_run.commands(mode("ours", "tcp"), ["program"], sides)
        self.assertEqual(there, ["enter", "there", "program", "sub", "tcp", "--own", "10.0.0.2", "--other", "10.0.0.1"])
        self.assertEqual(here, ["program", "pub", "tcp", "--own", "10.0.0.1", "--other", "10.0.0.2"])
        self.assertEqual((receives, sends), ({"WHO": "receives"}, {"WHO": "sends"}))

    def headline_of(self, *rounds):
        """Each round: {mode's key: {size: us}}."""
        named = {one.key: one for one in modes.MODES}
        results = report.Results([named[key] for key in rounds[0]], plan.Plan(True, 3, 1, (), ()))
        for one in rounds:
            results.begin_round()
            for key, latencies in one.items():
                results.add(named[key], [found(plan.Lane(size, 1, 0, 0), value) for size, value in latencies.items()])
        return {name: value for name, value, _ in headline.metrics(results)}

    def test_the_fastest_way_of_a_peer_represents_it_in_each_round(self):
        values = self.headline_of(
            {"ours_shm": {KB: 6}, "iceoryx_listener": {KB: 2}, "iceoryx_waitset": {KB: 3}},
            {"ours_shm": {KB: 6}, "iceoryx_listener": {KB: 9}, "iceoryx_waitset": {KB: 3}},
            {"ours_shm": {KB: 6}, "iceoryx_listener": {KB: 4}, "iceoryx_waitset": {KB: 6}})
        self.assertEqual(values["shm_vs_iceoryx_1KB"], 2)
        self.assertEqual(values["shm_p50_us_1KB"], 6)
        self.assertNotIn("shm_bulk_vs_iceoryx_1KB", values)

    def test_compares_plain_messages_with_serializing_peers_and_bulk_with_its_smallest_size(self):
        values = self.headline_of({"ours_shm_plain": {KB: 8}, "ours_shm_bulk": {KB: 4, plan.MB * 4: 6},
                                   "ros1_tcpros": {KB: 16}, "raw_memcpy": {KB: 1}})
        self.assertEqual(values["shm_vs_ros1_1KB"], 0.5)
        self.assertEqual(values["shm_bulk_vs_ros1_1KB"], 0.25)
        self.assertEqual(values["shm_bulk_size_ratio"], 1.5)
        self.assertNotIn("shm_plain_4MB_over_memcpy", values)

    def test_a_run_reports_medians_means_losses_and_peers_that_are_missing_or_fail(self):
        self.program("raw_call")
        self.script("zeromq", "#!/bin/sh\necho 'the port is taken' >&2\nexit 2\n")
        done = self.run_peers("--only", "raw_call,fastdds,zeromq_ipc")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr.count("fastdds is left out: it needs libfastrtps-dev."), 1, done.stderr)
        self.assertNotIn("fastdds", done.stdout)
        self.assertIn("zeromq_ipc failed in round 2, and is left out from now on", done.stderr)
        self.assertIn("the port is taken", done.stderr)
        lines = list(csv.reader(io.StringIO(done.stdout)))
        self.assertTrue(all(len(line) == 3 for line in lines), done.stdout)
        values = {name: (float(value), unit) for name, value, unit in lines}
        self.assertEqual(values["rounds"], (3, "count"))
        self.assertEqual(values["raw_call_p50_us_1KB"], (2, "us"))
        self.assertEqual(values["raw_call_mean_us_4MB"], (3, "us"))
        self.assertEqual(values["raw_call_p99_us_4MB"], (6, "us"))
        self.assertEqual(values["raw_call_lost_1KB"], (3, "messages"))
        self.assertIn("raw_call_paced_mb_per_s_1MB", values)
        with open(self.folder / "runs.csv", newline="", encoding="utf-8") as file:
            self.assertEqual([row["mode"] for row in csv.DictReader(file)].count("call"), 3 * len(plan.QUICK.intra))

    def test_a_size_that_does_not_arrive_is_reported_once_and_skipped(self):
        self.program("raw_call", silent=str(4 * 1024 * KB))
        done = self.run_peers("--only", "raw_call")
        self.assertEqual(done.stderr.count("raw_call carries no message of 4MB here."), 1, done.stderr)
        self.assertNotIn("raw_call_p50_us_4MB", done.stdout)
        self.assertIn("raw_call_p50_us_1KB", done.stdout)

    def test_a_run_with_damaged_messages_has_no_result(self):
        self.program("raw_call", damaged="1")
        done = self.run_peers("--only", "raw_call")
        self.assertIn("1 messages arrived damaged", done.stderr)
        self.assertNotIn("raw_call_p50_us_1KB", done.stdout)

    def test_an_unknown_peer_is_an_error_that_lists_the_known_ones(self):
        done = self.run_peers("--only", "fastdd")
        self.assertNotEqual(done.returncode, 0)
        self.assertRegex(done.stderr, "There is no peer or mode fastdd; there are: .*fastdds_loan")

    def test_figures_find_each_mode_by_its_name_and_size(self):
        values = {"ours_pointer_p50_us_1MB": 2, "ours_pointer_p50_us_4KB": 1, "ours_pointer_tbb_p50_us_4KB": 7,
                  "ours_ipc_p50_us_4KB": 9}
        self.assertEqual(plots.curves(values, "p50_us", False),
                         {"ours pointer": [(4, 1), (1024, 2)], "ours pointer tbb": [(4, 7)]})


class Network(Benchmark):
    def program(self, name, factor):
        self.script(name, FAR_PROGRAM.replace("FACTOR", factor).replace("ADDRESSES", str(self.folder / "addresses")))

    def run_network(self, *arguments):
        done = self.run_script("network/run_network.py", *arguments)
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

    def test_sender_and_receiver_share_only_the_line_and_a_missing_peer_is_left_out_with_one_sentence(self):
        self.program("ours", "1")
        done = self.run_network("--only", "ours,fastdds")
        self.assertEqual(done.stderr.count("fastdds is left out: it needs libfastrtps-dev."), 1, done.stderr)
        self.assertIn("network_ours_p50_us_1KB", self.values(done))
        sender = (self.folder / "addresses_pub").read_text()
        receiver = (self.folder / "addresses_sub").read_text()
        self.assertIn("10.111.0.1", sender)
        self.assertNotIn("10.111.0.2", sender)
        self.assertIn("10.111.0.2", receiver)
        self.assertNotIn("10.111.0.1", receiver)
        self.assertEqual({line.split()[0].split("@")[0] for line in (sender + receiver).splitlines()},
                         {"lo", "hgba", "hgbb"})

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
