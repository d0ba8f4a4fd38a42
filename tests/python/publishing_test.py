import os
import subprocess
import sys
import textwrap
import unittest.mock

from support import DEADLINE_S, RobotTest, main, wait_until

import hgros
from foxglove.Log_pb2 import Log


class Publishing(RobotTest):
    def test_full_lossless_queue_of_program_or_configuration_raises_and_nothing_is_lost(self):
        for text, options, least in (("", {"queue": hgros.KeepAll(2)}, 2),
                                     ("data_graph: {nodes: {all: {queue: {keep_all: 3}}}}", {"name": "all"}, 3)):
            with self.subTest(text), self.session(text=text) as robot:
                messages = robot.messages("log", Log, timeout=DEADLINE_S, **options)
                publisher = robot.advertise("log", Log)
                published = 0
                with self.assertRaises(hgros.QueueFull) as refused:
                    while published < 1000:
                        publisher.publish(Log(line=published))
                        published += 1
                self.assertIn('channel "log"', str(refused.exception))
                self.assertGreaterEqual(published, least)
                self.assertEqual([next(messages).line for _ in range(published)], list(range(published)))
                messages.timeout = 0.05
                self.assertEqual(list(messages), [])
                self.assertEqual(messages.dropped, 0)

    def test_timeout_waits_for_room(self):
        robot = self.session()
        messages = robot.messages("log", Log, timeout=DEADLINE_S, queue=hgros.KeepAll(1))
        publisher = robot.advertise("log", Log)
        with self.assertRaises(hgros.QueueFull):
            while True:
                publisher.publish(Log(), timeout=0.05)
        next(messages)
        publisher.publish(Log(), timeout=DEADLINE_S)

    def test_no_memory_for_a_message_raises_and_the_session_goes_on(self):
        program = textwrap.dedent("""
            import resource
            import hgros
            from foxglove.RawImage_pb2 import RawImage

            SIZE = 64_000_000
            with hgros.Session() as robot:
                publish = robot.advertise("image", RawImage)
                image = RawImage(data=bytes(SIZE))
                used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
                # For the bytes that protobuf makes, and not for those that are published.
                resource.setrlimit(resource.RLIMIT_AS, (used + SIZE * 3 // 2, resource.RLIM_INFINITY))
                try:
                    bytes(SIZE * 2)
                    raise SystemExit("no limit")
                except MemoryError:
                    pass
                try:
                    publish(image)
                except hgros.PublishError as fault:
                    print(fault)
                resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
                publish(image)
            """)
        ended = subprocess.run([sys.executable, "-c", program], text=True, capture_output=True, timeout=60,
                               env={**os.environ, "MALLOC_ARENA_MAX": "1"})  # Others would take address space.
        if ended.stderr == "no limit\n":
            self.skipTest("This system does not limit the address space.")  # qemu
        self.assertEqual(ended.stdout, 'Nothing was published on channel "image": There is no memory to write the '
                                       'message for other sessions.\n', ended.stderr)
        self.assertEqual(ended.returncode, 0)

    def test_publisher_of_a_closed_session_raises_and_the_session_still_has_its_name_and_id(self):
        robot = self.session(name="robot")
        publisher, before = robot.advertise("log", Log), robot.id
        robot.close()
        self.assertEqual((robot.name, robot.id), ("robot", before))
        with self.assertRaises(hgros.SessionClosed):
            publisher.publish(Log())
        with self.assertRaisesRegex(hgros.Error, "The session is closed"):
            robot.advertise("log", Log)

    def test_configuration_file_with_a_mistake_says_where(self):
        with self.assertRaisesRegex(hgros.ConfigError, "text:1:"):
            hgros.Session(text="netwrk: {}")
        with unittest.mock.patch.dict(os.environ, HGROS_CONFIG="netwrk: {}"):
            with self.assertRaisesRegex(hgros.ConfigError, "HGROS_CONFIG:1:"):
                hgros.Session()
            self.session(text="").close()  # One of its own.

    def test_latched_message_comes_once_if_the_configuration_makes_the_queue_lossless(self):
        robot = self.session(text="data_graph: {nodes: {all: {queue: {keep_all: 3}}}}")
        robot.advertise("log", Log, latched=1).publish(Log(line=1))
        messages = robot.messages("log", Log, timeout=DEADLINE_S, name="all")
        self.assertEqual(next(messages).line, 1)
        messages.timeout = 0.1
        self.assertEqual(list(messages), [])

    def test_message_of_a_callback_has_its_cause(self):
        robot = self.session()
        first, second = robot.advertise("first", Log), robot.advertise("second", Log)
        infos = {}

        @robot.subscribe("first")
        def on_first(message, info):
            infos["first"] = info
            second.publish(message)

        @robot.subscribe("second")
        def on_second(message, info):
            infos["second"] = info

        first.publish(Log())
        self.spin_until(robot, lambda: "second" in infos)
        self.assertEqual(infos["second"].cause, infos["first"].key)
        self.assertEqual(infos["first"].cause, 0)

    def test_waits_for_subscribers_and_for_publishers(self):
        robot, other = self.session(), self.session()
        robot.advertise("log", Log)
        self.assertFalse(robot.wait_for_subscribers("log", timeout=0.0))
        messages = other.messages("log")
        self.assertTrue(robot.wait_for_subscribers("log", timeout=DEADLINE_S))
        self.assertTrue(other.wait_for_publishers("log", timeout=DEADLINE_S))
        messages.close()
        wait_until(lambda: not robot.wait_for_subscribers("log", timeout=0.0))


if __name__ == "__main__":
    main()
