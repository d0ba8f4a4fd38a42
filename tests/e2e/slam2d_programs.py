"""The SLAM example as its tests start it: SLAM2D and SLAM2D_REFERENCE name the binaries."""

import contextlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

BINARY = os.environ["SLAM2D"]
REFERENCE = os.environ["SLAM2D_REFERENCE"]
os.environ.setdefault("HGROS_DOMAIN", "none")
DATA = os.environ.get("HGROS_DATA", "")
DEADLINE_S = float(os.environ.get("SLAM2D_DEADLINE_S", "50"))
SCANS = 300

THREE = {
    "source": ("[source]", "source", "scan, odometry, clock, ready", {"matcher": "ready", "mapper": "ready, done"}),
    "matcher": ("[matcher]", "matcher", "pre_channel, trajectory, ready",
                {"source": "scan, clock, ready", "mapper": "next_channel, ready, done"}),
    "mapper": ("[mapper, writer]", "mapper", "next_channel, map, ready, done",
               {"source": "clock, ready", "matcher": "pre_channel, ready"}),
}
TWO = {
    "front": ("[source, matcher]", "front", "pre_channel, clock, ready", {"back": "next_channel, ready, done"}),
    "back": ("[mapper, writer]", "back", "next_channel, map, ready, done", {"front": "pre_channel, clock, ready"}),
}
ROBOTS = {
    "robot1": ("[source, matcher, mapper, writer]", "robot1", "map_state, clock, ready, done", {"robot2": "ready"}),
    "robot2": ("[mapper]\n  standby: true", "robot2", "next_channel, ready",
               {"robot1": "map_state, pre_channel, clock, ready, done"}),
}
CLOSED = {
    "robot1": ("[source, matcher, mapper, writer]", "robot1", "pre_channel, clock, ready, done",
               {"robot2": "next_channel, ready"}),
    "robot2": ("[mapper]", "robot2", "next_channel, ready", {"robot1": "pre_channel, clock, ready, done"}),
}


class Slam2dTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="slam2d_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.processes = []
        self.addCleanup(self.end_processes)

    def end_processes(self):
        for process in self.processes:
            if process.poll() is None:
                process.kill()
            with contextlib.suppress(ValueError):
                process.communicate()

    def write_config(self, name, plan):
        nodes, endpoint, published, subscribed = plan
        subscribers = "".join(f"    - {{ip: \"ipc://{self.folder}/{other}.ipc\", channels: [{channels}]}}\n"
                              for other, channels in subscribed.items())
        closed = "data_graph: {close_channels: [next_channel]}\n" if "standby" in nodes else ""
        file = self.folder / f"{name}.yaml"
        file.write_text(f"slam2d:\n  nodes: {nodes}\ntime: simulated\n"
                        f"network:\n  publisher:\n"
                        f"    {{ip: \"ipc://{self.folder}/{endpoint}.ipc\", channels: [{published}]}}\n"
                        f"  subscribers:\n{subscribers}{closed}")
        return file

    def start(self, *arguments, **options):
        options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, **options}
        process = subprocess.Popen([BINARY, *map(str, arguments)], cwd=self.folder, **options)
        self.processes.append(process)
        return process

    def await_line(self, process, part):
        """Reads standard error until a line contains the text; False at its end."""
        return any(part in line for line in iter(process.stderr.readline, ""))

    def start_plan(self, plan, extra=None):
        """Starts every process of the plan; returns them by name."""
        extra = extra or {}
        return {name: self.start("--json", "--config", self.write_config(name, part), *extra.get(name, []))
                for name, part in plan.items()}

    def end(self, process):
        """Waits for a process; returns exit code, standard output and standard error."""
        try:
            out, err = process.communicate(timeout=DEADLINE_S)
        except subprocess.TimeoutExpired:
            self.fail(f"{process.args} hangs")
        return process.returncode, out, err

    def result(self, process):
        """The --json output of a process that ends well."""
        code, out, err = self.end(process)
        self.assertEqual(code, 0, err)
        results = [json.loads(line) for line in out.splitlines()]
        for node in results:
            if node["kind"] == "node":
                self.assertEqual(node["dropped"], 0, node)
        return next(one for one in results if one["kind"] == "result")

    def hashes(self, process):
        result = self.result(process)
        return result["map_hash"], result["trajectory_hash"]

    def reference(self, *arguments):
        done = subprocess.run([REFERENCE, *map(str, arguments)], check=True, text=True, capture_output=True,
                              timeout=DEADLINE_S)
        return tuple(done.stdout.split())

    def assert_all_agree(self, processes, expected):
        self.assertEqual({name: self.hashes(process) for name, process in processes.items()},
                         dict.fromkeys(processes, expected))


def main(test_case):
    """Runs those tests of the class that the command line names, or all."""
    unittest.main(argv=[sys.argv[0], *(f"{test_case.__name__}.{name}" for name in sys.argv[1:])])
