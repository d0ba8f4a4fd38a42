#!/usr/bin/env python3
"""The cost of hgros-viewer and RViz while a robot drives: CPU, memory, frames per second. Prints metric,value,unit."""

import argparse
import csv
import os
import pathlib
import statistics
import subprocess
import sys
import threading
import time

import graphics_memory
import installed
from screen import Screen
from subjects import SUBJECTS

TICK = os.sysconf("SC_CLK_TCK")
PAGE = os.sysconf("SC_PAGE_SIZE")
HZ = 10
POINTS = 20_000


def emit(metric, value, unit):
    print(f"{metric},{value:.4g},{unit}", flush=True)


def say(text):
    print(text, file=sys.stderr, flush=True)


def cpu_s(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICK


def rss_mb(pid):
    return int(pathlib.Path(f"/proc/{pid}/statm").read_text(encoding="utf-8").split()[1]) * PAGE / 2**20


class Samples:
    """One row per second: seconds, CPU in % of a core, MB (2^20 bytes), frames per second."""

    def __init__(self, subject):
        self.subject = subject
        self.rows = []
        self.begin = self.last = time.monotonic()
        self.cpu = cpu_s(subject.process.pid)
        self.frames = subject.frames()

    def take(self, seconds):
        for _ in range(seconds):
            time.sleep(max(0, self.last + 1 - time.monotonic()))
            if self.subject.process.poll() is not None:
                raise RuntimeError(f"{self.subject.name} has ended early.")
            now, cpu, frames = time.monotonic(), cpu_s(self.subject.process.pid), self.subject.frames()
            elapsed = now - self.last
            self.rows.append((now - self.begin, 100 * (cpu - self.cpu) / elapsed, rss_mb(self.subject.process.pid),
                              (frames - self.frames) / elapsed))
            self.last, self.cpu, self.frames = now, cpu, frames

    def around(self, second, half=5):
        """Means of the rows around a second; at the end, of the last ones."""
        low, high = second - half, second + half
        if high > self.rows[-1][0]:
            low, high = self.rows[-1][0] - 2 * half, self.rows[-1][0]
        rows = [row for row in self.rows if low < row[0] <= high + 0.5]
        return tuple(statistics.mean(row[column] for row in rows) for column in (1, 2, 3))

    def write(self, path):
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(("seconds", "cpu_percent", "rss_mb", "fps"))
            writer.writerows([f"{value:.2f}" for value in row] for row in self.rows)


def turn_camera(subject, seconds):
    """Milliseconds per frame while the camera is dragged around."""
    window = subject.window()
    subject.screen.do("mousemove", "--window", window, 600, 400, "mousedown", 1)
    frames, begin = subject.frames(), time.monotonic()
    x = 600
    while time.monotonic() < begin + seconds:
        x = x + 4 if x < 800 else 600
        subject.screen.do("mousemove", "--window", window, x, 400)
        time.sleep(0.02)
    time.sleep(0.6)  # Ours reports its frames twice a second.
    frames, elapsed = subject.frames() - frames, time.monotonic() - begin
    subject.screen.do("mouseup", 1)
    return 1000 * elapsed / max(frames, 1)


def measure_growth(subject, folder, seconds):
    """A run that keeps every scan, with the path drawn as axes."""
    say(f"{subject.name}: {seconds} s of {POINTS} points at {HZ} Hz, all kept.")
    subject.start("all")
    time.sleep(3)
    play = subject.play(HZ, POINTS, HZ * (seconds + 12))
    time.sleep(1)
    subject.show_everything()
    samples = Samples(subject)
    samples.take(seconds)
    samples.write(folder / f"{subject.prefix or 'ours_'}growth.csv")
    marks = [second for second in (10, 60, 120) if second <= seconds] or [10]
    for second in marks:
        cpu, rss, fps = samples.around(second)
        emit(f"{subject.prefix}cpu_percent_at_{second}s", cpu, "percent of a core")
        emit(f"{subject.prefix}rss_mb_at_{second}s", rss, "MB")
        emit(f"{subject.prefix}fps_at_{second}s", fps, "1/s")
        emit(f"{subject.prefix}cpu_ms_per_frame_at_{second}s", 10 * cpu / fps if fps else float("inf"), "ms")
    first, last = samples.around(marks[0]), samples.around(marks[-1])
    emit(f"{subject.prefix}cpu_growth", last[0] / first[0], "ratio")
    if len(marks) > 1:
        points = POINTS * HZ * (marks[-1] - marks[0])
        emit(f"{subject.prefix}bytes_per_point", 2**20 * (last[1] - first[1]) / points, "bytes")
    emit(f"{subject.prefix}moving_frame_ms_at_{marks[-1]}s", turn_camera(subject, 6), "ms")
    subprocess.run(["import", "-window", "root", str(folder / f"{subject.prefix or 'ours_'}growth.png")],
                   env=subject.screen.environment, check=False, timeout=60) if installed.has("import") else None
    play.wait(30)
    subject.end()
    return last[0]


def measure_still(subject, keep, metric, seconds):
    """An idle scene, or one scan at a time."""
    say(f"{subject.name}: {seconds} s with {'one scan' if keep == 'latest' else 'nothing'} in view.")
    subject.start(keep)
    time.sleep(4)
    play = subject.play(HZ, POINTS, HZ * (seconds + 4)) if keep == "latest" else None
    time.sleep(2)
    samples = Samples(subject)
    samples.take(seconds)
    cpu, rss, fps = samples.around(seconds, half=seconds / 2)
    emit(f"{subject.prefix}{metric}_cpu_percent", cpu, "percent of a core")
    emit(f"{subject.prefix}{metric}_rss_mb", rss, "MB")
    emit(f"{subject.prefix}{metric}_fps", fps, "1/s")
    if play:
        play.wait(30)
    subject.end()


NO_CARD = 77  # Exit code of bench_viewer_frames.


class NoCard(Exception):
    pass


def measure_frames(build, environment, what, prefix=""):
    """Runs bench_viewer_frames and passes on its lines. Returns the peak of the card's memory."""
    with subprocess.Popen([str(build / "bench/viewer/bench_viewer_frames"), *what], env=environment, stdout=subprocess.PIPE,
                          text=True) as frames:
        peak = graphics_memory.Peak(frames.pid)
        ended = threading.Event()

        def look():
            while not ended.wait(0.1):
                peak.look()

        watch = threading.Thread(target=look, daemon=True)
        watch.start()
        try:
            for line in frames.stdout:
                print(prefix + line, end="", flush=True)
        finally:
            ended.set()
            watch.join()
    if frames.returncode == NO_CARD:
        raise NoCard
    if frames.returncode != 0:
        raise RuntimeError(f"bench_viewer_frames {' '.join(what)} ended with status {frames.returncode}.")
    return peak.bytes


def measure_all_frames(build, environment, sizes):
    # Draws like a driver that has only OpenGL 3.3. Only Mesa follows this variable; others draw as before.
    copied = {"MESA_EXTENSION_OVERRIDE": "-GL_ARB_buffer_storage"}
    measure_frames(build, environment, [*sizes, "decay", "messages"])
    measure_frames(build, environment | copied, ["messages"], "copied_")
    if not graphics_memory.has_card():
        say("There is no graphics card. Its memory is not measured.")
        return
    card = {name: value for name, value in environment.items() if name not in ("LIBGL_ALWAYS_SOFTWARE", "GALLIUM_DRIVER")}
    try:
        for size in sizes:
            most = measure_frames(build, card, ["card", size], "card_")
            if most is not None:
                emit(f"card_peak_mb_{size}M", most / 2**20, "MB")
        measure_frames(build, card, ["card", "decay", "messages"], "card_")
        measure_frames(build, card | copied, ["card", "messages"], "card_copied_")
    except NoCard:
        say("The graphics card does not draw without a window. Its memory is not measured.")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", type=pathlib.Path, required=True)
    parser.add_argument("--folder", type=pathlib.Path, required=True)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    seconds, starts, still = (20, 3, 6) if arguments.quick else (120, 10, 20)
    last_cpu = {}
    with Screen(arguments.folder) as screen:
        subjects = [kind(screen, arguments.build) for kind in SUBJECTS]
        if arguments.only:
            subjects = [subject for subject in subjects if (subject.prefix or "ours_") == arguments.only + "_"]
        for subject in list(subjects):
            if why := subject.missing():
                say(f"{subject.name} is left out: {why}")
                subjects.remove(subject)
        for subject in subjects:
            times = [subject.first_frame_s() for _ in range(starts + 1)][1:]  # The first one warms the file cache.
            emit(f"{subject.prefix}startup_ms", 1000 * statistics.median(times), "ms")
            measure_still(subject, "nothing", "idle", still)
            measure_still(subject, "latest", "scan", still)
        for subject in subjects:
            last_cpu[subject.prefix] = measure_growth(subject, arguments.folder, seconds)
        if len(last_cpu) == 2:
            emit("cpu_over_rviz", last_cpu[""] / last_cpu["rviz_"], "ratio")
        for metric, megabytes in installed.sizes(arguments.build):
            emit(metric, megabytes, "MB")
        if "" in last_cpu:
            measure_all_frames(arguments.build, screen.environment, ["1"] if arguments.quick else ["1", "10", "50"])


if __name__ == "__main__":
    main()
