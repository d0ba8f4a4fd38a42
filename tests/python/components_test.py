"""Components in Python, run by the command `hgros` in processes of its own."""

import json
import os
import pathlib
import re
import signal
import subprocess
import tempfile

from support import DEADLINE_S, RobotTest, main, rounds, wait_until

import hgros
from foxglove.KeyValuePair_pb2 import KeyValuePair
from foxglove.Vector2_pb2 import Vector2

HGROS = os.environ["HGROS_COMMAND"]
PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "python.md"

PARTS = """
import pathlib
import threading
import time

import hgros
from foxglove.KeyValuePair_pb2 import KeyValuePair
from foxglove.Vector2_pb2 import Vector2


class Numbers:
    def __init__(self, context):
        self.context = context
        self.transforms = context.transforms
        self.number = 0
        self.most = context.params.declare("most", 1_000_000, "The last number", least=1)
        self.numbers = context.advertise("number", Vector2)
        context.timer(0.002, self.send, name="send")

    def send(self, tick):
        if self.number < self.most:
            self.number += 1
            self.numbers.publish(Vector2(x=self.number))


class Sum:
    def __init__(self, context):
        self.state = KeyValuePair(key="0", value="0")  # How many, and their sum.
        self.sums = context.advertise("sum", KeyValuePair)
        self.fails_at = context.params.declare("fails_at", 0, "The number at which the callback raises")
        context.subscribe("number", Vector2, self.add, queue=hgros.KeepAll(1000))

    def add(self, number, info):
        if number.x == self.fails_at:
            raise ValueError("this number is not added")
        self.state = KeyValuePair(key=str(int(self.state.key) + 1), value=str(int(self.state.value) + int(number.x)))
        self.sums.publish(self.state)

    def save(self) -> KeyValuePair:
        return self.state

    def restore(self, state: KeyValuePair) -> None:
        self.state = state


class Unspeakable(Exception):
    def __str__(self):
        raise RuntimeError("no words")


class Receiver:
    def __init__(self, context):
        self.context = context
        self.faults = [ValueError(b"$GPG\\xfcA".decode(errors="surrogateescape")), Unspeakable()]
        context.timer(0.002, self.read, name="read")
        context.serve("next", Vector2, Vector2, self.next)

    def read(self, tick):
        if self.faults:
            raise self.faults.pop()

    def next(self, request):
        self.context.log.info("read %s", b"\\xfc".decode(errors="surrogateescape"))
        if self.faults or request.x == 0:
            raise Unspeakable
        return request


class Doubler:
    def __init__(self, context):
        context.serve("double", Vector2, Vector2, lambda request: Vector2(x=2 * request.x))


class Caller:
    def __init__(self, context):
        self.context = context
        self.double = context.client("double", Vector2, Vector2)
        self.own = context.client("theirs", Vector2, Vector2)
        self.sums = context.advertise("sum", KeyValuePair)
        context.serve("own", Vector2, Vector2, lambda request: request)
        context.timer(0.02, self.call, name="call")

    def call(self, tick):
        try:
            self.own.call(Vector2(), timeout=5.0).result()
        except hgros.CallError as fault:
            self.sums.publish(KeyValuePair(key=fault.kind, value=str(self.double.call(Vector2(x=4)).result().x)))


class Words:
    def __init__(self, context):
        self.words = context.advertise("word", KeyValuePair)
        self.reset = context.client("reset", KeyValuePair, KeyValuePair)
        self.sums = context.advertise("sum", KeyValuePair)
        context.subscribe("count", KeyValuePair, lambda count, info: self.sums.publish(count))
        context.timer(0.02, self.send, name="send")

    def send(self, tick):
        self.words.publish(KeyValuePair(value="a"))
        self.sums.publish(self.reset.call(KeyValuePair(key="back", value="again")).result())


class Busy:
    def __init__(self, context):
        context.timer(0.01, self.work, name="work")

    def work(self, tick):
        print("busy")
        while True:
            pass


class Ends:
    def __init__(self, context):
        self.context = context
        self.how = context.params.declare("how", "finish", "How it ends", choices=["finish", "fail"])

    def activate(self):
        self.context.log.warning("It ends by %s.", self.how)
        getattr(self.context, self.how)("as told")


class Late:
    # Its log is used after its end, and with a line that cannot be written.
    def __init__(self, context):
        context.log.warning("%d", "no number")
        threading.Thread(target=self.watch, args=(context,), daemon=True).start()

    def watch(self, context):
        try:
            while context.now_ns:
                time.sleep(0.002)
        except hgros.Error:
            context.log.warning("after\\x1b[31m\\nthe end")
            print("It goes on.")


class Broken:
    def __init__(self, context):
        raise ValueError("no such port\\x1b[31m")


class Patient:
    def __init__(self, context):
        pass

    def activate(self):
        while not pathlib.Path("go").exists():
            time.sleep(0.002)


class Slow:
    def __init__(self, context):
        self.done = KeyValuePair()
        self.sums = context.advertise("sum", KeyValuePair)
        self.numbers = context.subscribe("number", Vector2, self.work, queue=hgros.KeepLast(1))

    def work(self, number, info):
        time.sleep(0.1)
        age = time.clock_gettime_ns(time.CLOCK_MONOTONIC) - info.publish_monotonic_ns
        self.sums.publish(KeyValuePair(key=str(age // 1_000_000), value=str(int(number.x))))

    def save(self) -> KeyValuePair:
        return self.done

    def restore(self, state: KeyValuePair) -> None:
        self.done = state


class Vague:
    def __init__(self, context):
        pass

    def save(self):
        return Vector2()

    def restore(self, state):
        pass
"""


class ComponentTest(RobotTest):
    def setUp(self):
        super().setUp()
        self.folder = pathlib.Path(self.opened.enter_context(tempfile.TemporaryDirectory()))
        (self.folder / "parts.py").write_text(PARTS)

    def hgros(self, *arguments, env=None):
        return subprocess.run([HGROS, *arguments], env=env, cwd=self.folder, text=True, capture_output=True, timeout=60)

    def robot(self, text):
        """Starts a robot, whose log is in the file `log`."""
        (self.folder / "robot.yaml").write_text(text)
        log = self.opened.enter_context((self.folder / "log").open("w"))
        process = subprocess.Popen([HGROS, "run", "robot.yaml"], cwd=self.folder, stdout=log, stderr=log,
                                   stdin=subprocess.DEVNULL)
        self.opened.callback(lambda: process.poll() is None and (process.kill(), process.wait()))
        return process

    def log(self):
        return (self.folder / "log").read_text()

    def sums(self, channel="sum"):
        return self.opened.enter_context(self.session().messages(channel, KeyValuePair, timeout=DEADLINE_S,
                                                                 queue=hgros.KeepAll(100_000)))

    def interrupt(self, robot):
        robot.send_signal(signal.SIGINT)
        self.assertEqual(robot.wait(DEADLINE_S), -signal.SIGINT, self.log())

    def move(self, component, place, messages):
        moved = self.hgros("move", component, "--to", place)
        self.assertEqual(moved.returncode, 0, moved.stderr + self.log())
        before = messages.info.publisher
        wait_until(lambda: next(messages) and messages.info.publisher != before, "the move")

    def check_sum(self, message):
        """All numbers up to this one were added, each once."""
        self.assertEqual(int(message.value), int(message.key) * (int(message.key) + 1) // 2)


class Components(ComponentTest):
    def test_what_a_class_uses_is_known_before_it_runs(self):
        shown = self.hgros("components", "parts:Sum", "parts:Numbers", "parts:Caller", "--json")
        self.assertEqual(shown.returncode, 0, shown.stderr)
        total, numbers, caller = map(json.loads, shown.stdout.splitlines())
        self.assertEqual(total["state"], "foxglove.KeyValuePair")
        self.assertEqual(total["subscribes"], [{"channel": "number", "type": "foxglove.Vector2"}])
        self.assertEqual(total["publishes"], [{"channel": "sum", "type": "foxglove.KeyValuePair"}])
        self.assertEqual((numbers["transforms"], total["transforms"]), (True, False))
        self.assertEqual(numbers["timers"], [{"timer": "send", "period_ns": 2_000_000}])
        self.assertEqual((numbers["params"][0]["path"], numbers["params"][0]["least"]), ("most", 1))
        self.assertEqual([one["service"] for one in caller["calls"]], ["double", "theirs"])
        self.assertEqual([one["service"] for one in caller["serves"]], ["own"])

    def test_faults_of_a_robot_are_found_before_it_runs(self):
        (self.folder / "robot.yaml").write_text("components:\n"
                                                "  a: {type: parts:Numbers, params: {most: 0}}\n"
                                                "  b: {type: parts:Sum, remap: {nmber: other}}\n")
        checked = self.hgros("check", "robot.yaml")
        self.assertEqual(checked.returncode, 1)
        self.assertIn("most must be at least 1", checked.stdout + checked.stderr)
        self.assertIn('Did you mean "number"?', checked.stdout + checked.stderr)

    def test_faults_of_classes_name_what_is_wrong(self):
        (self.folder / "bad.py").write_text("\n\nimport no_such_module\n")
        (self.folder / "syntax.py").write_text("class :\n")
        for name, expected in {
            "parts:Broken": f"ValueError: no such port\\x1b[31m ({self.folder}/parts.py:",
            "parts:Brokn": 'Did you mean "Broken"?',
            "no_such_part:Any": 'Python has no module "no_such_part"',
            "bad:Any": f"No module named 'no_such_module' ({self.folder}/bad.py:3)",
            "syntax:Any": "SyntaxError",
            ":X": 'There is no component type ":X". Write a module, a colon and the name of a class in it',
            "parts:": 'There is no component type "parts:". Write a module',
            ".parts:Sum": 'There is no component type ".parts:Sum". Write a module',
            "parts:Vague": "does not say what `save` returns",
        }.items():
            with self.subTest(name):
                shown = self.hgros("components", name)
                self.assertEqual(shown.returncode, 1)
                self.assertIn(expected, shown.stderr)
                self.assertNotIn("\x1b", shown.stderr)
                self.assertNotIn("importlib", shown.stderr)
                if name == "parts:Broken":
                    self.assertRegex(shown.stderr, r'parts\.py", line \d+, in __init__')

    def test_virtual_environment_of_another_version_is_refused(self):
        environment = self.folder / "place"
        environment.mkdir()
        for line, expected in (("version_info = 3.12.1.final.0", f"The virtual environment {environment} has Python 3.12.1.final.0"),
                               ("version = 3.8.18", "has Python 3.8.18, and components run in Python 3.11."),
                               ("version = 3.11.2", None)):
            with self.subTest(line):
                (environment / "pyvenv.cfg").write_text(f"home = /usr/bin\ninclude-system-site-packages = true\n{line}\n")
                shown = self.hgros("components", "parts:Sum", env=os.environ | {"VIRTUAL_ENV": str(environment)})
                self.assertEqual(shown.returncode, 0 if expected is None else 1, shown.stderr)
                if expected is not None:
                    self.assertIn(expected, shown.stderr)
                    self.assertIn(f"-m venv --system-site-packages {environment}, or start the robot without VIRTUAL_ENV.",
                                  shown.stderr)

    def test_ctrl_c_ends_a_callback_that_never_returns(self):
        robot = self.robot("components:\n  busy: {type: parts:Busy}\n  numbers: {type: parts:Numbers}\n")
        wait_until(lambda: "busy" in self.log(), "the callback")
        robot.send_signal(signal.SIGINT)
        robot.wait(DEADLINE_S)

    def test_finish_and_fail_end_the_robot(self):
        for how, code in (("finish", 0), ("fail", 1)):
            with self.subTest(how):
                robot = self.robot(f"components: {{ends: {{type: 'parts:Ends', params: {{how: {how}}}}}}}\n")
                self.assertEqual(robot.wait(DEADLINE_S), code, self.log())
                self.assertIn(f"It ends by {how}.", self.log())

    def test_component_of_the_page_works_as_typed(self):
        blocks = re.findall(r"```(python|yaml)\n(.*?)```", PAGE.read_text(), re.S)
        code = next(text for kind, text in blocks if kind == "python" and "class Tracker" in text)
        robot_file = next(text for kind, text in blocks if kind == "yaml" and "tracker:Tracker" in text)
        (self.folder / "tracker.py").write_text(code)
        nearest = self.session().messages("nearest", Vector2, timeout=DEADLINE_S)
        robot = self.robot(robot_file)
        self.assertEqual(next(nearest).x, 0.75)
        self.interrupt(robot)


class ComponentRobots(ComponentTest):
    def test_moves_lose_no_message_and_keep_only_the_newest_for_one_that_is_slower_than_its_publisher(self):
        sums, slow = self.sums(), self.sums("slow")
        robot = self.robot("components:\n"
                           "  numbers: {type: parts:Numbers}\n"
                           "  total: {type: parts:Sum}\n"
                           "  slow: {type: parts:Slow, remap: {sum: slow}}\n"
                           "processes:\n"
                           "  one: {components: [numbers, total, slow]}\n"
                           "  two: {}\n")
        self.check_sum(next(sums))
        next(slow)
        wait_until(lambda: "starting" not in self.hgros("ps").stdout, "the start of both processes")
        for place in ("two", "one", "two")[:rounds(2, 3)]:
            self.move("total", place, sums)
            for _ in range(50):
                self.check_sum(next(sums))
        for place in ("two", "one", "two")[:rounds(2, 3)]:
            self.move("slow", place, slow)
            values = []
            wait_until(lambda: values.append(next(slow)) or int(values[-1].key) < 1000, "a message of this moment")
            self.assertLess(len(values), 30, values)
            self.assertEqual([int(one.value) for one in values], sorted(int(one.value) for one in values))
        self.interrupt(robot)

    def test_a_restart_waits_until_the_others_of_the_process_have_begun(self):
        self.robot("components:\n  total: {type: parts:Sum}\n  patient: {type: parts:Patient}\n")
        wait_until(lambda: "starting" in self.hgros("ps").stdout, "the start")
        asked = []
        while not asked or asked[-1].wait() != 0:  # Refused until all have been told to begin.
            asked.append(subprocess.Popen([HGROS, "restart", "total"], cwd=self.folder, text=True,
                                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE))
            self.opened.callback(asked[-1].stderr.close)
            try:
                self.assertIn("still starts", asked[-1].communicate(timeout=1)[1])
            except subprocess.TimeoutExpired:  # It waits.
                (self.folder / "go").touch()
        rows = [json.loads(line) for line in self.hgros("ps", "--json").stdout.splitlines()]
        self.assertEqual([row["restarts"] for row in rows if row["component"] == "patient"], [0], rows)

    def test_a_callback_that_raises_is_logged_and_constructed_again_with_its_state(self):
        sums = self.sums()
        robot = self.robot("components:\n"
                           "  numbers: {type: parts:Numbers}\n"
                           "  total: {type: parts:Sum, params: {fails_at: 100}, restart: on-exception, "
                           "checkpoint: 10ms}\n"
                           "  late: {type: parts:Late}\n")
        wait_until(lambda: "It is constructed again" in self.log(), "the restart")
        wait_until(lambda: int(next(sums).key) > 100, "the count that goes on from the state")
        self.assertIn("ValueError: this number is not added", self.log())
        self.assertRegex(self.log(), r'total .*parts\.py", line \d+, in add')
        # The log of a component that has ended goes to the output of its process.
        wait_until(lambda: "COMPONENT" in self.log() and "TypeError" in self.log(), "the line that cannot be written")
        wait_until(lambda: self.hgros("restart", "late").returncode == 0, "the restart")
        wait_until(lambda: re.search(r"main +It goes on", self.log()), "the thread")
        self.assertRegex(self.log(), r"main +late: after\\x1b\[31m\n")
        self.interrupt(robot)

    def test_components_of_one_process_call_each_other_have_parameters_and_may_raise_what_cannot_be_said(self):
        sums = self.sums()
        self.robot("components:\n"
                   "  caller: {type: parts:Caller, remap: {theirs: own}}\n"
                   "  doubler: {type: parts:Doubler}\n"
                   "  gps: {type: parts:Receiver}\n"
                   "  total: {type: parts:Sum}\n")
        answer = next(sums)
        self.assertEqual((answer.key, answer.value), ("would deadlock", "8.0"))
        self.assertIn("Unspeakable (its __str__ has raised RuntimeError)",
                      self.hgros("call", "next", "{x: 0}", "--timeout", str(DEADLINE_S)).stderr)
        self.assertIn("x: 1", self.hgros("call", "next", "{x: 1}", "--timeout", str(DEADLINE_S)).stdout)
        self.assertIn(r"ValueError: $GPG\udcfcA", self.log())
        self.assertIn(r"read \udcfc", self.log())

        def param(*words):
            return self.hgros("param", *words, "--timeout", "30")

        wait_until(lambda: param("get", "total", "fails_at").stdout.strip() == "0", "the parameter")
        self.assertEqual(param("set", "total", "fails_at", "7").returncode, 0)
        self.assertEqual(param("get", "total", "fails_at").stdout.strip(), "7")

    def test_components_of_both_languages_share_a_process(self):
        if not any(pathlib.Path(one, "hgros_test_words.yaml").exists()
                   for one in os.environ["HGROS_COMPONENT_PATH"].split(":")):
            self.skipTest("the library hgros_test_words is not built")
        sums = self.sums()
        self.robot("components:\n"
                   "  words: {type: parts:Words}\n"
                   "  counter: {type: words/Counter, nodes: {word: {executor: inline}}}\n")
        self.assertEqual({"again", "a count"},
                         {"a count" if one.value.isdigit() else one.value for one in (next(sums) for _ in range(20))})


if __name__ == "__main__":
    main()
