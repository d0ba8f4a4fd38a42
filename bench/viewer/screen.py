"""A screen in memory, and the processes that a measurement starts. All of them end with their context."""

import os
import signal
import subprocess


class Screen:
    """Xvfb with one screen; `environment` shows programs there."""

    def __init__(self, folder, width=1280, height=800):
        self.folder = folder
        self.started = []
        read, write = os.pipe()
        self.server = self.start("xvfb", ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{width}x{height}x24", "-nolisten",
                                          "tcp", "+extension", "GLX"], os.environ, pass_fds=[write])
        os.close(write)
        with os.fdopen(read) as number:
            display = ":" + number.readline().strip()
        self.environment = dict(os.environ, DISPLAY=display, LIBGL_ALWAYS_SOFTWARE="1", GALLIUM_DRIVER="llvmpipe",
                                HOME=str(folder), ROS_HOME=str(folder), ROS_LOG_DIR=str(folder), QT_X11_NO_MITSHM="1")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in reversed(self.started):
            end(process)

    def start(self, name, command, environment=None, **options):
        """Its standard error is in the folder, as NAME.log."""
        with open(self.folder / f"{name}.log", "wb") as log:
            process = subprocess.Popen(command, env=environment or self.environment, stdin=subprocess.DEVNULL, stdout=log,
                                       stderr=log, **options)
        self.started.append(process)
        return process

    def said(self, name):
        return (self.folder / f"{name}.log").read_text(encoding="utf-8", errors="replace")

    def do(self, *arguments):
        """xdotool"""
        return subprocess.run(["xdotool", *map(str, arguments)], env=self.environment, check=True, timeout=30,
                              stdout=subprocess.PIPE, text=True).stdout


def end(process, patience_s=5):
    if process.poll() is None:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(patience_s)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
