"""The wheel: built from the build folder, installed into a virtual environment, and used there."""

import importlib.util
import os
import pathlib
import subprocess
import sys
import tarfile
import tempfile

from support import RobotTest, main

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = os.environ["HGROS_BUILD"]
PROGRAM = """
import hgros
from foxglove.Log_pb2 import Log

with hgros.Session() as robot:
    logs = robot.messages("log", Log, timeout=15)
    robot.advertise("log", Log).publish(Log(message=hgros.__file__))
    print(next(logs).message)
"""
COMPONENT = """
from foxglove.Log_pb2 import Log


class Talker:
    def __init__(self, context):
        context.advertise("log", Log)
"""


class Wheel(RobotTest):
    def setUp(self):
        super().setUp()
        for module, package in (("build", "python3-build"), ("venv", "python3-venv"), ("ensurepip", "python3-venv")):
            if importlib.util.find_spec(module) is None:
                self.skipTest(f"the Debian package {package} is not installed")
        self.folder = pathlib.Path(self.opened.enter_context(tempfile.TemporaryDirectory()))

    def run_in_folder(self, *command, **variables):
        environment = {name: value for name, value in os.environ.items()
                       if name not in ("PYTHONPATH", "HGROS_COMPONENT_PATH")} | variables
        done = subprocess.run(command, cwd=self.folder, env=environment, text=True, capture_output=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_wheel_works_in_a_virtual_environment(self):
        self.run_in_folder(sys.executable, "-m", "build", "--no-isolation", "--wheel", "-C", f"build={BUILD}", "-o", ".",
                           ROOT)
        (wheel,) = self.folder.glob("hgros-*.whl")
        # With Debian's protobuf and numpy.
        self.run_in_folder(sys.executable, "-m", "venv", "--system-site-packages", "place")
        self.run_in_folder("place/bin/pip", "install", "--no-index", wheel)
        used = self.run_in_folder("place/bin/python", "-c", PROGRAM)
        self.assertTrue(used.startswith(f"{self.folder}/place/lib/"), used)
        (self.folder / "talker.py").write_text(COMPONENT)
        shown = self.run_in_folder("place/bin/hgros", "components", "talker:Talker",
                                   VIRTUAL_ENV=str(self.folder / "place"))
        self.assertIn(f"{self.folder}/place/lib/", shown)

    def test_source_archive_has_what_is_built(self):
        if not (ROOT / ".git").exists():
            self.skipTest("this is no clone")
        self.run_in_folder(sys.executable, "-m", "build", "--no-isolation", "--sdist", "-o", ".", ROOT)
        (archive,) = self.folder.glob("hgros-*.tar.gz")
        with tarfile.open(archive) as opened:
            names = {name.partition("/")[2] for name in opened.getnames()}
        for name in ("PKG-INFO", "pyproject.toml", "CMakeLists.txt", "bindings/python/wheel_of_install.py"):
            self.assertTrue(name in names, name)


if __name__ == "__main__":
    main()
