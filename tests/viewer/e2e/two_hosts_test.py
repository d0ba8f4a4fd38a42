"""The paper's second use case: the robot on one host, hgros-viewer on another, each with a network file only."""

import pathlib
import shutil
import subprocess
import unittest

from viewer_test import PUBLISHER, ViewerCase, colorful

ROBOT_ADDRESS, DESK_ADDRESS = "10.112.0.1", "10.112.0.2"
ROBOT_FILE = """network:
  publisher: {ip: "tcp://*:5553", channels: [lidar_visual_channel, re_optimized_poses, tf, tf_static]}
"""
DESK_FILE = f"""network:
  subscribers:
    - {{ip: "tcp://{ROBOT_ADDRESS}:5553", channels: [lidar_visual_channel, re_optimized_poses, tf, tf_static]}}
"""


class Host:
    """An unnamed network namespace and a runtime folder. They disappear with the process that holds them."""

    def __init__(self, case):
        self.holder = subprocess.Popen(["unshare", "-n", "cat"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                       stderr=subprocess.DEVNULL)
        case.addCleanup(self.end)
        self.runtime = pathlib.Path(case.folder.name, f"host{self.holder.pid}")
        self.runtime.mkdir(mode=0o700)
        try:
            self.holder.stdin.write(b"\n")
            self.holder.stdin.flush()
        except BrokenPipeError:
            pass
        if self.holder.stdout.read(1) != b"\n":
            case.skipTest("this system does not allow network namespaces.")

    def end(self):
        self.holder.stdin.close()
        self.holder.wait()
        self.holder.stdout.close()

    @property
    def inside(self):
        return ["nsenter", f"--net=/proc/{self.holder.pid}/ns/net", "env", f"XDG_RUNTIME_DIR={self.runtime}"]


class OnAnotherHost(ViewerCase):
    def setUp(self):
        super().setUp()
        missing = [name for name in ("unshare", "nsenter", "ip") if shutil.which(name) is None]
        if missing:
            self.skipTest(f"{' and '.join(missing)} are not installed.")
        self.robot, self.desk = Host(self), Host(self)
        self.line("ip", "link", "add", "hgva", "netns", str(self.robot.holder.pid), "type", "veth", "peer", "name", "hgvb",
                  "netns", str(self.desk.holder.pid))
        for host, device, address in ((self.robot, "hgva", ROBOT_ADDRESS), (self.desk, "hgvb", DESK_ADDRESS)):
            self.line(*host.inside, "ip", "address", "add", f"{address}/24", "dev", device)
            self.line(*host.inside, "ip", "link", "set", "lo", "up")
            self.line(*host.inside, "ip", "link", "set", device, "up")

    def line(self, *words):
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            self.skipTest(f'"{" ".join(words)}" failed: {done.stderr.strip()}')

    def start_robot(self):
        return self.start(*self.robot.inside, PUBLISHER, 20, 3000, 100_000, self.file("robot.yaml", ROBOT_FILE))

    def test_shows_the_robot_that_its_network_file_names(self):
        viewer = self.start_for_picture(40, "--network", self.file("desk.yaml", DESK_FILE), "--show-all", "--report", "0.1",
                                        "--channel", "lidar_visual_channel,keep=all",
                                        "--channel", "re_optimized_poses,style=both", inside=self.desk.inside)
        self.start_robot()
        self.read_until(viewer, lambda figures: float(figures["points"]) > 6000)
        self.end(viewer)
        self.assertGreater(colorful(self.picture()), 0.02)

    def test_goes_on_when_the_robot_was_killed_and_comes_again(self):
        viewer = self.start_for_picture(120, "--network", self.file("desk.yaml", DESK_FILE), "--show-all", "--report", "0.1",
                                        "--channel", "lidar_visual_channel,keep=all", inside=self.desk.inside)
        robot = self.start_robot()
        first = self.read_until(viewer, lambda figures: float(figures["points"]) > 6000)
        self.kill(robot)
        self.start_robot()
        self.read_until(viewer, lambda figures: float(figures["points"]) > float(first["points"]) + 6000)
        self.end(viewer)
        self.assertGreater(colorful(self.picture()), 0.02)


if __name__ == "__main__":
    unittest.main()
