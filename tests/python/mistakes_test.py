"""Mistakes that programs make: each ends with a sentence that says what is wrong, where, and how to mend it."""

import math
import os
import shutil
import subprocess
import sys
import tempfile
import warnings

import numpy as np
from support import DEADLINE_S, RobotTest, main, wait_until

import hgros
from foxglove.Log_pb2 import Log
from foxglove.PointCloud_pb2 import PointCloud
from foxglove.RawImage_pb2 import RawImage
from foxglove.Vector2_pb2 import Vector2

RED = "\x1b[31m"


class Mistakes(RobotTest):
    def refused(self, call, kind, expected):
        with self.subTest(expected):
            with self.assertRaises(kind) as raised:
                call()
            self.assertIn(expected, str(raised.exception))
            self.assertNotIn("incompatible function arguments", str(raised.exception))

    def test_decorators_without_brackets_are_refused(self):
        robot = self.session()

        def function(*arguments):
            pass

        self.refused(lambda: robot.subscribe(function), TypeError, "write it with brackets and the name")
        self.refused(lambda: robot.timer(function), TypeError, "write it with brackets and the seconds")
        self.refused(lambda: robot.params.on_change(function), TypeError, "write it with brackets and the name")
        self.refused(lambda: robot.timer(0), ValueError, "A period must be above 0 s")
        self.refused(lambda: robot.timer(0, print), ValueError, "A period must be above 0 s")

    def test_message_for_a_class_and_class_for_a_message_are_named(self):
        robot = self.session()
        publisher = robot.advertise("log", Log)
        self.refused(lambda: robot.advertise("other", Log()), TypeError, "Give Log without brackets")
        self.refused(lambda: publisher.publish(Log), TypeError, 'carries foxglove.Log, not the class Log')
        self.refused(lambda: publisher.publish(Vector2()), TypeError, 'Channel "log" carries foxglove.Log, not Vector2')
        self.refused(lambda: robot.advertise("other", int), TypeError, "is not a class of messages")
        self.refused(lambda: robot.subscribe("log", int), TypeError, "is not a class of messages")
        self.refused(lambda: robot.subscribe("log", lambda message, info: None), TypeError,
                     'robot.subscribe("log", callback=')
        self.refused(lambda: robot.call("add", Log, Log), TypeError, 'The request to service "add" is a message, not <class')

    def test_arguments_of_a_wrong_type_are_named(self):
        robot = self.session()
        publisher = robot.advertise("log", Log)
        self.refused(lambda: robot.advertise(5, Log), TypeError, "The name of a channel is a text, not 5")
        self.refused(lambda: robot.messages(None), TypeError, "The name of a channel is a text, not None")
        self.refused(lambda: robot.serve(None, Log, Log), TypeError, "The name of a service is a text, not None")
        self.refused(lambda: robot.messages("log", timeout="1"), TypeError, "A timeout is a number of seconds, not '1'")
        self.refused(lambda: publisher.publish(Log(), "1"), TypeError, "A timeout is a number of seconds, not '1'")
        self.refused(lambda: robot.transforms.lookup("a", "b", timeout="1"), TypeError, "A timeout is a number of seconds")
        self.refused(lambda: robot.wait_for_subscribers("log", timeout="1"), TypeError, "A timeout is a number of seconds")
        self.refused(lambda: robot.sleep("1"), TypeError, "A sleep is a number of seconds, not '1'")
        self.refused(lambda: robot.sleep(math.nan), TypeError, "A sleep is a number of seconds, not nan")
        self.refused(lambda: robot.messages("log", timeout=math.nan), TypeError, "A timeout is a number of seconds, not nan")
        for queue in (5, hgros.KeepLast):
            self.refused(lambda queue=queue: robot.subscribe("log", Log, print, queue=queue), TypeError, "A queue is hgros.KeepLast(")
        self.refused(lambda: hgros.KeepLast("a"), ValueError, "not 'a'")
        for size in (12.5, -1, "12"):
            self.refused(lambda size=size: robot.loan("image", RawImage, size), TypeError, f"whole number of bytes, not {size!r}")

    def test_two_types_of_a_channel_name_the_lines_of_the_program(self):
        robot = self.session()
        robot.advertise("log", Log)
        first = sys._getframe().f_lineno - 1
        with self.assertRaises(hgros.TypeMismatch) as raised:
            robot.advertise("log", Vector2)
        self.assertIn(f"{__file__}:{first + 3}: ", str(raised.exception))
        self.assertIn("foxglove.Vector2", str(raised.exception))
        self.assertIn(f"first used with it at {__file__}:{first})", str(raised.exception))
        robot.serve("add", Log, Log, lambda request: request)
        self.refused(lambda: robot.serve("add", Log, Log, lambda request: request), hgros.Error, f"{__file__}:")

    def test_arrays_over_messages_of_other_types_are_refused(self):
        self.refused(lambda: hgros.points(Vector2()), TypeError, "messages of foxglove.PointCloud, not foxglove.Vector2")
        self.refused(lambda: hgros.points(PointCloud), TypeError, "messages of foxglove.PointCloud")
        self.refused(lambda: hgros.image(PointCloud()), TypeError, "messages of foxglove.RawImage, not foxglove.PointCloud")

    def test_bytes_that_do_not_fit_the_loan_name_both_sizes(self):
        with self.session().loan("image", RawImage, 4) as image:
            self.refused(lambda: setattr(image, "data", b"abc"), hgros.Error, "4 bytes, and what is written into its data has 3")
            self.refused(lambda: setattr(image, "data", np.zeros(1, np.complex64)[:0]), hgros.Error, "complex")
            image.data = np.ones((2, 2), np.uint8)  # Also what has more dimensions.
            self.assertEqual(bytes(image.data), b"\1\1\1\1")

    def test_matrices_that_are_no_transform_say_why(self):
        transforms = self.session().transforms
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for matrix, reason in ((np.eye(4) * (1 + 0j), "its numbers are complex"), (np.eye(3), "its shape is (3, 3)"),
                                   ("text", "could not convert"), ([[1], [1, 2]], "inhomogeneous"),
                                   (np.eye(4) * 2, "its last row is"), (np.full((4, 4), np.nan), "finite"),
                                   (np.diag([1, 1, -1, 1]), "is no rotation")):
                self.refused(lambda matrix=matrix: transforms.send_static("a", "b", matrix), hgros.TransformError, reason)
        transforms.send_static("a", "b", np.eye(4, dtype=int))

    def test_control_characters_in_errors_are_escaped(self):
        robot, other = self.session(), self.session()

        @robot.serve("fails", Log, Log)
        def fails(request):
            raise ValueError(f"{RED}\n\u202e")

        robot.start()
        wait_until(lambda: any(one.name == "hgros/call/fails" and one.subscribers for one in other.channels()))
        with self.assertLogs("hgros"):
            self.refused(lambda: other.call("fails", Log(), Log, timeout=DEADLINE_S).result(), hgros.CallError,
                         r"ValueError: \x1b[31m\n\u202e")
        robot.transforms.send_static("a", "b", np.eye(4))
        self.refused(lambda: robot.transforms.lookup(RED, "b"), hgros.TransformError, r"\x1b[31m")
        self.refused(lambda: robot.subscribe(RED, Log, lambda: 0), TypeError, r"\x1b[31m")
        self.refused(lambda: robot.subscribe(RED, lambda: 0), TypeError, r"\x1b[31m")
        self.refused(lambda: hgros.Session(RED), hgros.ConfigError, r"\x1b[31m")
        self.refused(lambda: hgros.image(RawImage(encoding=RED)), hgros.Error, r"\x1b[31m")

    def test_a_python_that_cannot_use_the_package_says_so(self):
        package = os.path.dirname(hgros.__file__)
        with tempfile.TemporaryDirectory() as folder:
            shutil.copytree(package, folder + "/hgros", ignore=shutil.ignore_patterns("*.so", "*_pb2.py*", "__pycache__"))
            open(folder + "/hgros/_hgros.cpython-27-other.so", "w").close()
            for options, expected in ((["-S"], "needs google.protobuf, which"), ([], "was built for Python 2.7, and this is")):
                if options:
                    os.symlink(hgros._hgros.__file__, folder + "/hgros/" + os.path.basename(hgros._hgros.__file__))
                ended = subprocess.run([sys.executable, *options, "-c", "import hgros"], text=True, capture_output=True,
                                       env={"PYTHONPATH": folder}, timeout=60)
                self.assertIn(expected, ended.stderr.splitlines()[-1])
                if options:
                    os.remove(folder + "/hgros/" + os.path.basename(hgros._hgros.__file__))

    def test_a_subinterpreter_cannot_use_the_package_and_says_so(self):
        program = ("import _xxsubinterpreters as interpreters\n"
                   "interpreters.run_string(interpreters.create(isolated=False), 'import hgros')\n")
        ended = subprocess.run([sys.executable, "-c", program], text=True, capture_output=True, timeout=60)
        self.assertIn("works only in the main interpreter", ended.stderr.splitlines()[-1])


if __name__ == "__main__":
    main()
