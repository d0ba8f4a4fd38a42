"""The two viewers: how each is started, and how its presented frames are counted."""

import mmap
import os
import pathlib
import shutil
import socket
import struct
import time

from screen import end


class Ours:
    prefix = ""
    name = "hgros-viewer"

    def __init__(self, screen, build):
        self.screen = screen
        self.build = pathlib.Path(build)
        self.environment = dict(screen.environment, HGROS_DOMAIN=f"bench-viewer-{os.getpid()}")

    def missing(self):
        return "" if self.program.exists() else "hgros-viewer is not built."

    @property
    def program(self):
        return self.build / "apps/viewer/app/hgros-viewer"

    def start(self, keep):
        """`keep`: "nothing", "latest" or "all"."""
        command = [str(self.program), "--no-panels", "--size", "1280x800", "--report", "0.5", "--fixed-frame", "map"]
        if keep == "nothing":
            command += ["--channel", "nothing:foxglove.PointCloud"]
        else:
            command += ["--channel", f"scan:foxglove.PointCloud,keep={keep},color=value,size=2",
                        "--channel", "path:foxglove.PosesInFrame,style=axes"]
        self.process = self.screen.start("viewer", command, self.environment)
        return self.process

    def play(self, hz, points, steps):
        return self.screen.start("play", [str(self.build / "bench/viewer/bench_viewer_play_ours"), str(hz), str(points),
                                          str(steps)], self.environment)

    def frames(self):
        for line in reversed(self.screen.said("viewer").splitlines()):
            figures = dict(part.split("=") for part in line.split() if part.count("=") == 1)
            if "frames" in figures:
                return int(figures["frames"])
        return 0

    def window(self):
        return self.screen.do("search", "--sync", "--name", "^hgros-viewer$").split()[0]

    def show_everything(self):
        window = self.window()
        self.screen.do("windowfocus", "--sync", window, "key", "--window", window, "z")

    def first_frame_s(self):
        """Seconds from the process's start to its end after one frame: slightly more than until the first frame."""
        begin = time.monotonic()
        process = self.screen.start("start", [str(self.program), "--size", "1280x800", "--frames", "1"], self.environment)
        process.wait(30)
        return time.monotonic() - begin

    def end(self):
        end(self.process)


class RViz:
    prefix = "rviz_"
    name = "RViz"

    def __init__(self, screen, build):
        self.screen = screen
        self.build = pathlib.Path(build)
        self.master = None
        self.runs = 0

    def missing(self):
        if not shutil.which("rviz") or not shutil.which("rosmaster"):
            return "RViz is not installed."
        return "" if (self.build / "bench/viewer/bench_viewer_play_ros1").exists() else "its publisher is not built."

    def need_master(self):
        if self.master:
            return
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.environment = dict(self.screen.environment, ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1")
        self.master = self.screen.start("rosmaster", ["rosmaster", "--core", "-p", str(port)], self.environment)
        for _ in range(100):
            try:
                socket.create_connection(("127.0.0.1", port), 1).close()
                return
            except OSError:
                time.sleep(0.1)
        raise RuntimeError("rosmaster does not answer: " + self.screen.said("rosmaster"))

    def start(self, keep):
        self.need_master()
        here = pathlib.Path(__file__).resolve().parent
        text = (here / "yard.rviz.in").read_text(encoding="utf-8")
        text = text.replace("@CLOUD@", "false" if keep == "nothing" else "true")
        text = text.replace("@DECAY@", "1000000" if keep == "all" else "0")
        self.runs += 1
        configuration = self.screen.folder / f"yard{self.runs}.rviz"
        configuration.write_text(text, encoding="utf-8")
        swaps = self.screen.folder / f"swaps{self.runs}"
        swaps.write_bytes(bytes(16))
        with open(swaps, "r+b") as file:
            self.swaps = mmap.mmap(file.fileno(), 16)
        environment = dict(self.environment, HGROS_SWAPS=str(swaps),
                           LD_PRELOAD=str(self.build / "bench/viewer/libbench_viewer_swaps.so"))
        self.process = self.screen.start("rviz", [os.path.realpath(shutil.which("rviz")), "-d", str(configuration)], environment)
        return self.process

    def play(self, hz, points, steps):
        return self.screen.start("play", [str(self.build / "bench/viewer/bench_viewer_play_ros1"), str(hz), str(points),
                                          str(steps)], self.environment)

    def frames(self):
        return struct.unpack("<QQ", self.swaps[:16])[0]

    def window(self):
        return self.screen.do("search", "--sync", "--onlyvisible", "--name", "RViz").split()[0]

    def show_everything(self):
        """The camera starts at the pose in its file."""

    def first_frame_s(self):
        begin = time.monotonic_ns()
        process = self.start("nothing")
        limit = time.monotonic() + 60
        while self.frames() == 0 and process.poll() is None and time.monotonic() < limit:
            time.sleep(0.005)
        first = struct.unpack("<QQ", self.swaps[:16])[1]
        end(process)
        return (first - begin) / 1e9

    def end(self):
        end(self.process)


SUBJECTS = (Ours, RViz)
