"""Runs hgros-viewer as a user does, next to a robot that publishes: without a window, or on a virtual screen."""

import ctypes
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
import zlib

VIEWER = os.environ["HGROS_VIEWER"]
PUBLISHER = os.environ["HGROS_VIEWER_PUBLISHER"]
TALKER = os.environ["HGROS_VIEWER_TALKER"]
CAMERAS = os.environ["HGROS_VIEWER_CAMERAS"]
SLAM2D = os.environ.get("SLAM2D", "")  # The command that runs the robot file.
SLAM2D_ROBOT = os.environ.get("SLAM2D_ROBOT", "")
DEADLINE_S = float(os.environ.get("HGROS_VIEWER_DEADLINE_S", "60"))

# What a PNG subtracts from each byte, by the mode of the row: from the bytes to the left, above, and between these.
GUESSES = (lambda left, above, corner: 0,
           lambda left, above, corner: left,
           lambda left, above, corner: above,
           lambda left, above, corner: (left + above) // 2,
           lambda left, above, corner: min((left, above, corner), key=lambda near: abs(left + above - corner - near)))


def pixels(path):
    """Width, height and rows of a PNG with 8 bits per channel and no palette, as the viewer writes them."""
    data = pathlib.Path(path).read_bytes()
    at, size, packed = 8, None, b""
    while at < len(data):
        length = int.from_bytes(data[at:at + 4], "big")
        kind, body = data[at + 4:at + 8], data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            size = int.from_bytes(body[:4], "big"), int.from_bytes(body[4:8], "big")
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    width, height = size
    raw, stride, rows, above = zlib.decompress(packed), 3 * width, [], bytes(3 * width)
    for y in range(height):
        guess, line = GUESSES[raw[y * (stride + 1)]], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for x in range(stride):
            left, corner = (line[x - 3], above[x - 3]) if x >= 3 else (0, 0)
            line[x] = (line[x] + guess(left, above[x], corner)) & 255
        above = bytes(line)
        rows.append(above)
    return width, height, rows


def colorful(path):
    """Share of the pixels that are neither background nor gray lines nor panels: the robot's data."""
    width, height, rows = pixels(path)
    count = sum(max(row[x:x + 3]) - min(row[x:x + 3]) > 80 for row in rows for x in range(0, 3 * width, 3))
    return count / (width * height)


class ViewerCase(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.environment = dict(os.environ, HGROS_DOMAIN=f"viewer-{os.getpid()}")
        self.running = []
        self.addCleanup(lambda: self.kill(*self.running))

    def kill(self, *processes):
        for process in processes:
            process.kill()
            process.wait()

    def start(self, *arguments, **options):
        process = subprocess.Popen([str(a) for a in arguments], env=self.environment, stderr=subprocess.PIPE, text=True,
                                   **options)
        self.addCleanup(process.stderr.close)
        self.running.append(process)
        return process

    def end(self, process, code=0, *words):
        """Waits until it ends with that exit code, after an error with these words."""
        ended, said = process.wait(timeout=DEADLINE_S), process.stderr.read()
        self.assertEqual(ended, code, said)
        for word in words:
            self.assertIn(word, said)

    def stop(self, viewer):
        viewer.send_signal(signal.SIGTERM)
        self.end(viewer)

    def file(self, name, text):
        path = pathlib.Path(self.folder.name, name)
        path.write_text(text, encoding="utf-8")
        return path

    def picture(self, name="picture"):
        return pathlib.Path(self.folder.name, f"{name}.png")

    def start_for_picture(self, frames, *arguments, inside=(), name="picture"):
        """A viewer that writes the picture at its end."""
        return self.start(*inside, VIEWER, "--offscreen", "320x240", "--no-panels", "--screenshot", self.picture(name),
                          "--frames", frames, *arguments)

    def read_until(self, viewer, wanted):
        deadline = time.monotonic() + DEADLINE_S
        while time.monotonic() < deadline:
            line = viewer.stderr.readline()
            if not line:
                break
            figures = dict(part.split("=") for part in line.split() if "=" in part)
            if "points" in figures and wanted(figures):
                return figures
        self.fail("The viewer has not printed the expected line.")

    def assert_says_in_time(self, words, code, *arguments):
        """Names that a viewer has heard of show only at its end, with that exit code. So it gets more time each time."""
        for seconds in (1, 4, 16):
            viewer = self.start(VIEWER, "--offscreen", "64x64", "--after", seconds, *arguments)
            self.assertEqual(viewer.wait(timeout=DEADLINE_S), code)
            said = viewer.stderr.read()
            if words in said:
                return
        self.assertIn(words, said)

    def line_with(self, viewer, words):
        """The next line of its standard error that contains these words; empty if the program ends first."""
        return next((line for line in viewer.stderr if words in line), "")


class InMemory(ViewerCase):
    def test_shows_what_it_is_told_and_by_itself_what_it_finds(self):
        cases = {"told": (["--channel", "cloud:foxglove.PointCloud,keep=all",
                           "--channel", "trajectory:foxglove.PosesInFrame"], 20, 0.02),
                 "found": ([], 60, 0.005), "half": (["--channel", "cloud,keep=all"], 60, 0.005)}
        viewers = {name: self.start_for_picture(frames, "--show-all", "--report", "0.1", *arguments, name=name)
                   for name, (arguments, frames, _) in cases.items()}
        self.start(PUBLISHER, 20, 2000, 1000)
        for name, viewer in viewers.items():
            with self.subTest(name):
                self.read_until(viewer, lambda figures: float(figures["points"]) > 0)
                self.end(viewer)
                self.assertGreater(colorful(self.picture(name)), cases[name][2])

    def test_shows_robots_whose_files_are_named(self):
        robot = self.file("robot.urdf", '<robot name="r"><link name="base"><visual><geometry><box size="6 3 2"/></geometry>'
                          '<material name="m"><color rgba="1 0.4 0 1"/></material></visual></link></robot>')
        viewer = self.start_for_picture(20, "--follow", "base", "--channel", "cloud,color=flat",
                                        "--display", f"Robot model,file={robot}")
        self.start(PUBLISHER, 20, 100, 1000)
        self.end(viewer)
        self.assertGreater(colorful(self.picture()), 0.005)

    def test_says_that_a_channel_carries_another_type_or_has_no_display(self):
        for channel, publisher, words, sentence in (
                ("cloud:foxglove.Grid", (PUBLISHER, 20, 100, 1000), "carries",
                 '"cloud" carries foxglove.PointCloud; a Grid shows foxglove.Grid.'),
                ("log", (TALKER, 1000, 30), "No display", 'No display shows "log", which carries foxglove.Log.')):
            with self.subTest(channel=channel):
                viewer = self.start(VIEWER, "--offscreen", "64x64", "--channel", channel)
                self.start(*publisher)
                self.assertIn(sentence, self.line_with(viewer, words))
                viewer.send_signal(signal.SIGTERM)
                viewer.wait(timeout=DEADLINE_S)

    def test_goes_on_when_the_publisher_was_killed_and_comes_again(self):
        viewer = self.start_for_picture(60, "--channel", "cloud:foxglove.PointCloud", "--report", "0.1")
        publisher = self.start(PUBLISHER, 20, 2000, 1000)
        self.read_until(viewer, lambda figures: float(figures["points"]) > 0)
        self.kill(publisher)
        self.start(PUBLISHER, 20, 2000, 1000)
        self.end(viewer)
        self.assertGreater(colorful(self.picture()), 0.005)

    def test_writes_a_layout_that_it_reads_again(self):
        layout = self.file("layout.yaml", "save_on_exit: true\ndisplays:\n  - kind: Point cloud\n    channel: cloud\n"
                           "    settings: {keep: all}\npanels: [Graph]\n")
        for _ in range(2):
            self.end(self.start(VIEWER, "--offscreen", "320x240", "--config", layout, "--frames", 3))
            written = layout.read_text()
            self.assertIn("keep: all", written)
            self.assertIn("kind: Graph", written)
            self.assertNotIn("Ground", written, "only what the layout names is shown")
        layout.write_text("displays:\n  - kind: Groud\n")
        self.end(self.start(VIEWER, "--offscreen", "64x64", "--config", layout), 1,
                 "layout.yaml:2:5: There is no display")

    def test_hands_its_pictures_to_ffmpeg(self):
        film = pathlib.Path(self.folder.name, "film.mp4")
        ffmpeg = self.file("ffmpeg", '#!/bin/sh\nfor word; do last=$word; done\nexec cat > "${last#file:}"\n')
        ffmpeg.chmod(0o755)
        self.environment["PATH"] = f"{self.folder.name}:{self.environment['PATH']}"
        self.end(self.start(VIEWER, "--offscreen", "64x48", "--frames", 2, "--record-video", film))
        self.assertEqual(film.stat().st_size % (64 * 48 * 3), 0)
        self.assertGreaterEqual(film.stat().st_size, 2 * 64 * 48 * 3)
        ffmpeg.write_text("#!/bin/sh\necho no room >&2\nexit 1\n")
        self.end(self.start(VIEWER, "--offscreen", "640x480", "--frames", 3, "--record-video", film), 1,
                 "failed and said: no room")

    def test_goes_on_beside_a_robot_that_sends_what_is_no_message(self):
        picture = self.picture()
        panels = ["Channels,measure=odometry,measure=broken_cloud", "Log", "Message,channel=broken_cloud,unfolded=pose",
                  "Plot,series=odometry pose.position.x,series=broken_scan start_angle", "Graph"]
        viewer = self.start(VIEWER, "--offscreen", "640x480", "--screenshot", picture, "--frames", 60,
                            *(part for panel in panels for part in ("--panel", panel)))
        self.start(TALKER, 1000, 30)
        self.end(viewer)
        self.assertTrue(picture.exists())

    def test_shows_clouds_of_a_million_points_that_come_ten_times_a_second(self):
        viewer = self.start(VIEWER, "--offscreen", "320x240", "--no-panels", "--report", "0.1", "--channel",
                            "cloud:foxglove.PointCloud,size=1")
        self.start(PUBLISHER, 10, 1_000_000, 1000)
        first = self.read_until(viewer, lambda figures: float(figures["points"]) == 1_000_000)
        later = self.read_until(viewer, lambda figures: float(figures["frames"]) > float(first["frames"]) + 5)
        self.assertEqual(float(later["points"]), 1_000_000)
        self.assertLess(float(later["rss_mb"]), 1000)
        self.stop(viewer)

    def test_draws_nothing_while_nothing_changes(self):
        viewer = self.start(VIEWER, "--offscreen", "320x240", "--report", "0.2", "--panel", "Log", "--panel", "Message",
                            "--panel", "Plot", "--panel", "Channels")
        # A second after the last picture, one more picture shows that nothing is drawn.
        last = {"frames": "", "seconds": 0}

        def still(figures):
            if figures["frames"] != last["frames"]:
                last.update(figures)
            return float(figures["frames"]) > 0 and float(figures["seconds"]) > float(last["seconds"]) + 1.5

        self.read_until(viewer, still)
        self.stop(viewer)

    def test_ends_by_saying_what_was_asked_for_and_never_came(self):
        robot = self.file("broken.urdf", "<robot>")
        for arguments, words in ((["--channel", "clodu"], 'The channel "clodu" was never published. Did you mean "cloud"?'),
                                 (["--channel", "clodu:foxglove.PointCloud"], 'The channel "clodu" was never published.'),
                                 (["--channel", "cloud", "--follow", "bsae"], '"bsae", which the camera should follow'),
                                 (["--fixed-frame", "mapp"], 'The fixed frame "mapp" was never found. Did you mean "map"?'),
                                 (["--display", "Robot model,file=none.urdf"], "none.urdf is not a file"),
                                 (["--display", f"Robot model,file={robot}"], "Robot model: "),
                                 (["--channel", "cloud:foxglove.Grid"],
                                  "foxglove.Grid is subscribed to by hgros-viewer")):
            with self.subTest(arguments=arguments):
                publisher = self.start(PUBLISHER, 20, 100, 1000)
                others = self.start(VIEWER, "--offscreen", "64x64", "--channel", "cloud")
                self.assert_says_in_time(words, 1, *arguments)
                self.kill(publisher, others)

    def test_says_what_it_found_and_could_not_draw(self):
        self.start(TALKER, 100_000, 30)
        words = 'No message came on the channel "broken_cloud" that could be shown.'
        self.assert_says_in_time(words, 0)  # It was not requested.

    def test_says_what_it_waits_for_while_nothing_arrives(self):
        domain = self.environment["HGROS_DOMAIN"]
        for viewer, code, words in [(self.start("env", *other, VIEWER, "--offscreen", "64x64", "--frames", 2, *arguments),
                                     code, words) for arguments, other, code, words in (
                ([], [], 0, ("Waiting for a program that publishes", f'the domain "{domain}" on this host')),
                (["--channel", "cloud:foxglove.PointCloud", "--channel", "scan"], [], 1,
                 ('Waiting for the channels "scan", "cloud".', f'the domain "{domain}"')),
                ([], ["HGROS_DOMAIN=none"], 0, ("Discovery is off", "--network")))]:
            with self.subTest(arguments=viewer.args):
                self.end(viewer, code, *words)

    def test_shows_a_large_gray_image_in_little_memory(self):
        viewer = self.start(VIEWER, "--offscreen", "320x240", "--report", "0.1")
        empty = self.read_until(viewer, lambda figures: float(figures["frames"]) >= 1)
        self.start(CAMERAS, 1, 8000, 8000, "mono8")
        shown = self.read_until(viewer, lambda figures: float(figures["gpu_mb"]) > 60)
        # The message, its picture, the driver's copy of that, the texture, and the next message with its picture: each
        # pixel is one byte there.
        self.assertLess(float(shown["rss_mb"]) - float(empty["rss_mb"]), 7 * 64)
        self.stop(viewer)

    @unittest.skipUnless(SLAM2D, "The demo is not built.")
    def test_shows_every_channel_of_the_demo_without_an_error(self):
        self.start(SLAM2D, "run", SLAM2D_ROBOT, "--set", "source.params.rate=15", cwd=self.folder.name,
                   stdout=subprocess.DEVNULL)
        for seconds in (3, 15, 30):  # It may take the demo longer to publish all of them.
            viewer = self.start(VIEWER, "--offscreen", "64x64", "--after", seconds, "--channel", "odometry", "--channel",
                                "trajectory", "--channel", "map")
            code, said = viewer.wait(timeout=DEADLINE_S), viewer.stderr.read()
            if "was never published" not in said:
                break
        self.assertEqual(code, 0, said)
        self.assertNotIn("hgros-viewer: ", said)

    def test_says_what_is_wrong_with_its_arguments(self):
        cases = ((["--channel", "cloud:foxglove.Nothing"], "No display shows"),
                 (["--channel", "cloud:foxglove.PointCloud,sise=3"], "no setting"),
                 (["--channel", "cloud:foxglove.PointCloud,keep=some"], "there are latest"),
                 (["--display", "Frame"], 'Did you mean "Frames"? It takes Robot model, Frames, Ground;'),
                 (["--display", "Grid"], "shows a channel: ask for it by --channel"),
                 (["--panel", "Radar"], "there are Channels"),
                 (["--panel", "Plot,seconds=long"], "from 1 to 600"),
                 (["--config", "x" * 300], "cannot be read: File name too long"),
                 (["--fps-limit", "inf"], "at most 1e12"),
                 (["--report", "0"], "--report must be a number above 0"),
                 (["--report", "inf"], "--report must be a number above 0"),
                 (["--after", "-1"], "--after must be a number of seconds from 0"),
                 (["--after", "nan"], "--after must be a number of seconds from 0"),
                 (["--frames", "0"], "--frames must be at least 1"),
                 (["--frames", "-1"], "--frames"),
                 (["--record-video", "x.avi", "--frames", "1"], "must end in one of them"),
                 (["--screenshot", "x.jpg", "--frames", "1"], "must end in .png"),
                 (["--screenshot", "x.png"], "--after"))
        for first in range(0, len(cases), 4):
            for viewer, words in [(self.start(VIEWER, "--offscreen", "64x64", *arguments), words)
                                  for arguments, words in cases[first:first + 4]]:
                with self.subTest(arguments=viewer.args):
                    self.assertNotEqual(viewer.wait(timeout=DEADLINE_S), 0)
                    self.assertIn(words, viewer.stderr.read())


def ask_to_close(screen, window):
    """Asks a window of an X screen to close, as a window manager does when a user clicks its close button."""
    x11 = ctypes.CDLL("libX11.so.6")
    x11.XOpenDisplay.restype = ctypes.c_void_p
    x11.XInternAtom.restype = ctypes.c_ulong
    x11.XInternAtom.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int]
    x11.XSendEvent.argtypes = [ctypes.c_void_p, ctypes.c_ulong, ctypes.c_int, ctypes.c_long, ctypes.c_void_p]
    x11.XCloseDisplay.argtypes = [ctypes.c_void_p]
    display = x11.XOpenDisplay(screen.encode())
    if not display:
        raise OSError(f"The screen {screen} cannot be reached.")
    protocols, deletion = (x11.XInternAtom(display, name, False) for name in (b"WM_PROTOCOLS", b"WM_DELETE_WINDOW"))
    # An XClientMessageEvent, whose fields begin 8 bytes apart: the type 33, ..., window, message type, format, data.
    event = (ctypes.c_long * 24)(33, 0, 0, 0, window, protocols, 32, deletion)
    x11.XSendEvent(display, window, False, 0, ctypes.byref(event))
    x11.XCloseDisplay(display)  # Sends what waits.


class InAWindow(ViewerCase):
    """On a virtual screen, with mouse and keys."""

    def setUp(self):
        super().setUp()
        missing = [name for name in ("Xvfb", "xdotool") if shutil.which(name) is None]
        if missing:
            self.skipTest(f"{' and '.join(missing)} are not installed; ./dev setup viewer installs them.")
        read, write = os.pipe()
        screen = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "800x600x24", "-nolisten", "tcp"],
                                  pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        self.running.append(screen)
        with os.fdopen(read) as number:
            self.environment["DISPLAY"] = ":" + number.readline().strip()

    def do(self, *arguments):
        return subprocess.run(["xdotool", *map(str, arguments)], env=self.environment, check=True, timeout=DEADLINE_S,
                              stdout=subprocess.PIPE, text=True).stdout

    def open(self, size, *arguments, **options):
        """A viewer in a window that has drawn, and the window."""
        viewer = self.start(VIEWER, "--size", size, "--report", "0.1", *arguments, **options)
        window = self.do("search", "--sync", "--name", "^hgros-viewer$").split()[0]
        self.read_until(viewer, lambda figures: float(figures["frames"]) >= 3)
        return viewer, window

    def await_pictures(self, viewer, count):
        drawn = float(self.read_until(viewer, lambda figures: True)["frames"])
        self.read_until(viewer, lambda figures: float(figures["frames"]) >= drawn + count)

    def test_turns_zooms_takes_another_size_and_never_replaces_a_layout_that_it_has_not_read(self):
        layout, other = self.file("hgros-viewer.yaml", "# mine\n"), pathlib.Path(self.folder.name, "hgros-viewer-2.yaml")
        viewer, window = self.open("640x480", cwd=self.folder.name)
        idle = self.read_until(viewer, lambda figures: True)
        self.do("mousemove", "--window", window, 400, 300, "mousedown", 1, "mousemove", "--window", window, 460, 330,
                "mouseup", 1, "click", 4, "click", 5)
        self.do("windowfocus", "--sync", window, "key", "F1")
        self.read_until(viewer, lambda figures: float(figures["frames"]) > float(idle["frames"]) + 3)
        turned = self.read_until(viewer, lambda figures: True)
        self.do("windowsize", window, 300, 200)
        self.read_until(viewer, lambda figures: float(figures["frames"]) > float(turned["frames"]))
        self.do("key", "l")
        self.read_until(viewer, lambda figures: other.exists())
        self.do("key", "4", "key", "l")
        self.read_until(viewer, lambda figures: "kind: Plot" in other.read_text())
        self.assertEqual(layout.read_text(), "# mine\n")
        self.stop(viewer)

    def test_opens_panels_picks_stands_still_and_writes_what_it_shows(self):
        layout = self.file("layout.yaml", "panels: [{kind: Graph, place: [300, 220, 340, 240]}]\n")
        given = layout.read_text()
        viewer, window = self.open("760x560", "--config", layout, cwd=self.folder.name)
        self.start(TALKER, 2000, 20)
        self.read_until(viewer, lambda figures: float(figures["frames"]) >= 10)
        self.do("windowfocus", "--sync", window, "key", "1", "key", "4", "key", "2", "key", "2")
        self.do("mousemove", "--window", window, 500, 200, "keydown", "shift", "click", 1, "keyup", "shift",
                "key", "m", "key", "Escape", "key", "space", "key", "n", "key", "space", "key", "F12", "key", "l")
        self.read_until(viewer, lambda figures: layout.read_text() not in ("", given))
        written = layout.read_text()
        for words in ("kind: Channels", "kind: Plot", "kind: Graph", "channel: odometry"):
            self.assertIn(words, written)
        self.assertNotIn("kind: Log", written, "it was closed again")
        self.read_until(viewer, lambda figures: list(pathlib.Path(self.folder.name).glob("hgros-viewer-*.png")))
        place = re.compile(r"kind: Graph\n +place: \[(\d+), (\d+),")
        left, top = map(int, place.search(written).groups())
        self.assertEqual(written.count("place:"), 1, "only one panel was placed")
        self.do("key", "1", "key", "4")  # They may cover it.
        # A window knows the item below the pointer from the next picture on.
        for deed in (("mousemove", "--window", window, left + 80, top + 8), ("mousedown", 1),
                     ("mousemove", "--window", window, left + 60, top + 28)):
            self.do(*deed)
            self.await_pictures(viewer, 3)
        self.do("mouseup", 1, "key", "l")
        self.read_until(viewer, lambda figures: layout.read_text() != written)
        self.assertEqual(tuple(map(int, place.search(layout.read_text()).groups())), (left - 20, top + 20))
        self.do("key", "p", "key", "p", "windowsize", window, 400, 300)
        self.await_pictures(viewer, 3)
        self.do("windowsize", window, 1, 1)
        self.stop(viewer)

    def test_ends_and_keeps_its_layout_when_its_window_is_closed(self):
        layout = self.file("layout.yaml", "save_on_exit: true\nfixed_frame: map\n")
        viewer, window = self.open("640x480", "--config", layout)
        self.assertNotIn("camera", layout.read_text())
        ask_to_close(self.environment["DISPLAY"], int(window))
        self.end(viewer)
        self.assertIn("camera", layout.read_text())


if __name__ == "__main__":
    unittest.main()
