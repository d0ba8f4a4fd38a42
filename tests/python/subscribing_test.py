import asyncio
import contextlib
import gc
import logging
import pathlib
import re
import textwrap
import threading
import time
import weakref

from support import DEADLINE_S, RobotTest, main, wait_until

import hgros
from hgros import _hgros
from google.protobuf.message import DecodeError
from foxglove.LaserScan_pb2 import LaserScan
from foxglove.Log_pb2 import Log


def _others_woken():
    """How often the threads of this process but the calling one have slept so far."""
    woken = 0
    for task in pathlib.Path("/proc/self/task").iterdir():
        if int(task.name) == threading.get_native_id():
            continue
        with contextlib.suppress(OSError):  # It may have ended meanwhile.
            woken += int(re.search(r"^voluntary_ctxt_switches:\s*(\d+)", (task / "status").read_text(), re.M).group(1))
    return woken


class Subscribing(RobotTest):
    def test_callback_gets_message_and_info_from_another_session(self):
        robot, other = self.session(), self.session()
        heard = []
        robot.subscribe("log", Log, lambda message, info: heard.append((message, info)))
        publisher = other.advertise("log", Log)
        self.assertTrue(other.wait_for_subscribers("log", timeout=DEADLINE_S))
        publisher.publish(Log(message="hello"))
        self.spin_until(robot, lambda: heard)
        message, info = heard[0]
        self.assertIs(type(message), Log)
        self.assertEqual(message.message, "hello")
        self.assertTrue(info.remote)
        self.assertEqual(info.sequence, 1)
        self.assertEqual(f"{info.publisher:016x}", other.id)
        self.assertGreater(info.publish_time_ns, 0)

    def test_others_see_the_type_that_a_subscription_names(self):
        robot, other = self.session(), self.session()
        robot.subscribe("log", Log, lambda message, info: None)
        wait_until(lambda: [one.type_name for one in other.channels() if one.name == "log"] == ["foxglove.Log"])
        with self.assertRaises(hgros.TypeMismatch):
            robot.subscribe("log", LaserScan, lambda message, info: None)

    def test_decorator_returns_the_function_and_subscriptions_are_found_by_their_channel(self):
        robot = self.session()

        @robot.subscribe("log")
        def on_log(message, info):
            pass

        self.assertEqual(on_log.__name__, "on_log")
        again = robot.subscribe("log", callback=on_log)
        other = robot.subscribe("other", callback=on_log)
        robot.timer(1, lambda tick: None)
        first, second = robot.subscriptions("log")
        self.assertIs(first.callback, on_log)
        self.assertIs(second, again)
        self.assertEqual(robot.subscriptions(), [first, again, other])
        self.assertEqual(robot.subscriptions("nothing"), [])
        robot.advertise("log", Log).publish(Log())
        self.spin_until(robot, lambda: first.run == 1)
        first.end()
        self.assertEqual(robot.subscriptions("log"), [again])

    def test_messages_come_in_order_to_callbacks_on_the_spinning_thread(self):
        robot = self.session()
        heard = []

        def on_log(message, info):
            heard.append((message.line, threading.get_ident()))
            if len(heard) == 500:
                robot.stop()

        robot.subscribe("log", Log, on_log, queue=hgros.KeepAll(1000))
        publisher = robot.advertise("log", Log)
        with self.beside(lambda: [publisher.publish(Log(line=i), timeout=DEADLINE_S) for i in range(500)]):
            robot.spin()
        self.assertEqual(heard, [(i, threading.get_ident()) for i in range(500)])

    def test_exceptions_are_counted_and_the_first_ten_logged_with_traceback(self):
        robot = self.session()
        publisher = robot.advertise("log", Log)

        def fails(message, info):
            raise ValueError(f"message {message.line}")

        with self.assertLogs("hgros", logging.ERROR) as said:
            heard = robot.subscribe("log", Log, fails, queue=hgros.KeepLast(100))
            for line in range(50):
                publisher.publish(Log(line=line))
            self.spin_until(robot, lambda: heard.failed == 50)
        self.assertEqual(heard.run, 50)
        self.assertEqual(len(said.output), 11, said.output)
        for line in range(10):
            self.assertIn('channel "log"', said.output[line])
            self.assertIn(f"ValueError: message {line}", said.output[line])
            self.assertIn("in fails", said.output[line])
        self.assertIn('A callback of channel "log" raises exceptions again and again: 11 so far.', said.output[10])

    def test_exception_of_a_callback_keeps_nothing(self):
        robot = self.session()
        probes = []

        class Probe:
            pass

        def fails(message, info):
            probe = Probe()
            probes.append(weakref.ref(probe))
            raise DecodeError("of a message inside the message")

        subscription = robot.subscribe("log", Log, fails)
        publisher = robot.advertise("log", Log)
        gc.disable()
        self.addCleanup(gc.enable)
        logging.disable(logging.CRITICAL)  # What tests capture keeps exceptions.
        self.addCleanup(logging.disable, logging.NOTSET)
        for i in range(1, 4):
            publisher.publish(Log())
            self.spin_until(robot, lambda: subscription.failed == i)
        self.assertEqual([probe() for probe in probes], [None] * 3)
        self.assertEqual((subscription.failed, subscription.not_decoded), (3, 0))

    def test_ended_subscription_hears_nothing(self):
        robot = self.session()
        heard = []
        subscription = robot.subscribe("log", callback=lambda message, info: heard.append(message))
        publisher = robot.advertise("log", Log)
        publisher.publish(Log())
        subscription.end()
        publisher.publish(Log())
        self.assertFalse(subscription.active)
        robot.spin_once(0.05)
        self.assertEqual(heard, [])
        subscription.end()

    def test_callback_may_end_its_own_subscription(self):
        robot = self.session()
        heard = []

        def once(message, info):
            heard.append(message)
            subscription.end()

        subscription = robot.subscribe("log", Log, once)
        publisher = robot.advertise("log", Log)
        publisher.publish(Log())
        publisher.publish(Log())
        self.spin_until(robot, lambda: heard)
        robot.spin_once(0.05)
        self.assertEqual(len(heard), 1)

    def test_callback_may_close_the_session(self):
        robot = self.session()
        robot.subscribe("log", Log, lambda message, info: robot.close())
        robot.advertise("log", Log).publish(Log())
        robot.spin()
        self.assertTrue(robot.closed)

    def test_close_ends_a_spin_on_another_thread(self):
        robot = self.session()
        with self.beside(robot.spin):
            wait_until(robot._spins.locked)
            robot.close()

    def test_started_session_calls_callbacks_without_spin(self):
        robot = self.session()
        heard = threading.Event()
        robot.subscribe("log", Log, lambda message, info: heard.set())
        robot.start()
        robot.advertise("log", Log).publish(Log())
        self.assertTrue(heard.wait(DEADLINE_S))
        with self.assertRaisesRegex(hgros.Error, "spins already"):
            robot.spin()

    def test_what_callbacks_miss_and_raise_is_counted_where_commands_see_it(self):
        robot = self.session()
        publisher = robot.advertise("log", Log)

        lines = []

        def slow(message, info):
            lines.append(message.message)
            time.sleep(0.02)
            if message.message == "3":
                raise RuntimeError("the third")

        with self.assertLogs("hgros", "WARNING") as said:
            heard = robot.subscribe("log", Log, slow, queue=hgros.KeepLast(4), name="slow")
            for number in range(10):
                publisher.publish(Log(message=str(number % 4)))
            self.spin_until(robot, lambda: heard.run == 4)
            wait_until(lambda: any("has dropped" in line for line in said.output))
        self.assertEqual(lines, ["2", "3", "0", "1"])  # The oldest are dropped.
        node, = robot.snapshot().channel("log").nodes
        self.assertEqual((heard.received, heard.dropped, heard.run, heard.failed), (10, 6, 4, 1))
        self.assertEqual((node.received, node.dropped, node.run, node.failed), (10, 6, 4, 1))
        self.assertGreaterEqual(node.run_time.median_ns, 15_000_000)
        self.assertGreater(node.queue_wait.max_ns, 20_000_000)
        dropped = [line for line in said.output if "has dropped" in line]
        self.assertEqual(len(dropped), 1, said.output)
        self.assertIn('"slow" on channel "log" has dropped 1 of', dropped[0])

    def test_many_threads_publish_and_subscribe(self):
        robot = self.session()
        counts = [0] * 4

        def count(at):
            def callback(message, info):
                counts[at] += 1
            return callback

        for at in range(4):
            robot.subscribe("log", Log, count(at), queue=hgros.KeepAll(100))
        publisher = robot.advertise("log", Log)
        robot.start()
        threads = [threading.Thread(target=lambda: [publisher.publish(Log(), timeout=DEADLINE_S) for _ in range(100)])
                   for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        wait_until(lambda: counts == [400] * 4, "every message everywhere")

    def test_lossless_subscription_that_is_full_can_be_closed(self):
        robot = self.session()
        robot.subscribe("log", Log, lambda message, info: None, queue=hgros.KeepAll(1))
        publisher = robot.advertise("log", Log)
        with self.assertRaises(hgros.QueueFull):
            while True:
                publisher.publish(Log(), timeout=0.02)
        robot.close()

    def test_close_ends_what_a_callback_waits_for(self):
        robot = self.session()
        waits = threading.Event()

        @robot.subscribe("log", Log)
        def on_log(message, info):
            waits.set()
            list(messages)

        messages = robot.messages("nothing")
        robot.start()
        robot.advertise("log", Log).publish(Log())
        self.assertTrue(waits.wait(DEADLINE_S))
        with self.beside(robot.close):
            pass

    def test_interrupted_close_can_be_done_again(self):
        robot = self.session()
        subscription = robot.subscribe("log", Log, lambda message, info: None)
        end, ended = subscription.end, []

        def interrupted():
            end()
            ended.append(True)
            raise KeyboardInterrupt

        subscription.end = interrupted
        with self.assertRaises(KeyboardInterrupt):
            robot.close()
        self.assertTrue(ended)
        self.assertTrue(robot._native.closed)
        robot.close()
        self.assertTrue(robot._closed)

    def test_wrong_callbacks_are_refused_at_once(self):
        robot = self.session()

        async def later(*arguments):
            pass

        for register in (lambda callback: robot.subscribe("log", callback=callback),
                         lambda callback: robot.timer(1, callback), lambda callback: robot.serve("log", Log, Log, callback),
                         robot.params.on_change("a")):
            with self.assertRaisesRegex(TypeError, "async def"):
                register(later)
            with self.assertRaisesRegex(TypeError, "argument"):
                register(lambda: None)

    def test_spin_finds_messages_whose_key_an_interrupted_spin_had_taken(self):
        robot = self.session()
        robot.subscribe("log", Log, lambda message, info: robot.stop())
        robot.advertise("log", Log).publish(Log())
        self.assertTrue(robot._ready.take())  # Here a signal ends the spin.
        with self.beside(robot.spin):
            pass

    def test_spin_once_finds_messages_whose_key_an_interrupted_spin_had_taken(self):
        robot = self.session()
        heard = []
        robot.subscribe("log", Log, lambda message, info: heard.append(message), queue=hgros.KeepLast(1000))
        robot.advertise("log", Log).publish(Log())
        self.assertTrue(robot._ready.take())  # Here a signal ends the spin.
        self.assertTrue(robot.spin_once())
        self.assertEqual(len(heard), 1)

    def test_spin_once_tells_whether_a_callback_ran(self):
        robot, other = self.session(), self.session()
        subscription = robot.subscribe("log", LaserScan, lambda message, info: None)
        robot.params.on_change("a")(lambda paths: None)
        self.assertFalse(robot.spin_once())
        log = other.advertise("log", Log)
        self.assertTrue(other.wait_for_subscribers("log", timeout=DEADLINE_S))
        log.publish(Log())
        wait_until(lambda: subscription.received == 1)
        with self.assertLogs("hgros", logging.ERROR):
            self.assertFalse(robot.spin_once(0.01))  # A message of another type: no callback.
        robot.params.set("a", 1)
        self.assertTrue(robot.spin_once())

    def test_spin_once_waits_for_a_callback_until_its_deadline(self):
        robot, other = self.session(), self.session()
        heard = []
        robot.subscribe("log", LaserScan, lambda message, info: heard.append(message))
        again = robot.subscribe("again", Log, lambda message, info: heard.append(message))
        wrong, right = other.advertise("log", Log), other.advertise("again", Log)
        self.assertTrue(other.wait_for_subscribers("log", timeout=DEADLINE_S))
        self.assertTrue(other.wait_for_subscribers("again", timeout=DEADLINE_S))

        def publish():
            wait_until(robot._spins.locked)
            wrong.publish(Log())
            wait_until(lambda: robot.subscriptions("log")[0].not_decoded == 1)
            right.publish(Log())

        with self.beside(publish), self.assertLogs("hgros", logging.ERROR):
            self.assertTrue(robot.spin_once(DEADLINE_S))
        self.assertEqual((len(heard), again.run), (1, 1))

    def test_start_is_refused_while_another_thread_spins_and_stop_ends_spin_once(self):
        robot = self.session()
        found = []
        with self.beside(lambda: found.append(robot.spin_once(1000))):
            wait_until(robot._spins.locked)
            with self.assertRaisesRegex(hgros.Error, "spins already"):
                robot.start()
            robot.stop()
        self.assertEqual(found, [False])
        robot.start()
        self.assertTrue(robot._thread.is_alive())

    def test_stop_right_after_start_ends_the_thread(self):
        robot = self.session()
        for _ in range(50):
            robot.start()
            robot.stop()
            self.assertFalse(robot._thread.is_alive())

    def test_close_beside_start_does_not_fail(self):
        for _ in range(100):
            robot = self.session()

            def start():
                with contextlib.suppress(hgros.Error):
                    robot.start()

            with self.beside(start):
                robot.close()
            self.assertTrue(robot.closed)

    def test_wake_up_that_comes_just_before_the_wait_ends_it(self):
        robot = self.session()
        for ready in (robot._ready, _hgros.ReadyList()):
            ready.take()
            ready.wake()
            self.assertEqual(ready.wait(3600), [])  # Longer than the test may take.

    def test_waiting_thread_receives_itself(self):
        robot = self.session()
        heard = []
        robot.subscribe("log", Log, lambda message, info: heard.append(message), queue=hgros.KeepLast(1000))
        sender = self.python(textwrap.dedent("""
            import hgros, time
            from foxglove.Log_pb2 import Log
            with hgros.Session() as robot:
                publisher = robot.advertise("log", Log)
                robot.wait_for_subscribers("log", timeout=20)
                for i in range(300):
                    publisher.publish(Log())
                    time.sleep(0.002)
                input()
            """))
        # Other threads have their own work a few times a second. On a busy machine, messages come while this thread works.
        for _ in range(5):
            count, woken, begin = len(heard), _others_woken(), time.monotonic()
            self.spin_until(robot, lambda: len(heard) >= count + 50)
            woken = _others_woken() - woken
            if woken < (len(heard) - count) / 2 + 40 * (time.monotonic() - begin):
                break
        else:
            self.fail(f"{woken} wake-ups of other threads for {len(heard) - count} messages")
        sender.communicate("\n", timeout=DEADLINE_S)


class Iterating(RobotTest):
    def test_close_ends_a_loop_and_the_session_before_it_returns(self):
        for _ in range(10):
            robot, other = hgros.Session(), self.session()
            other.advertise("log", Log)
            messages, heard = robot.messages("log"), []
            with self.beside(lambda: heard.append(list(messages))):
                self.assertTrue(robot.wait_for_publishers("log", timeout=DEADLINE_S))
                threads = len(list(pathlib.Path("/proc/self/task").iterdir()))
                robot.close()
                self.assertLess(len(list(pathlib.Path("/proc/self/task").iterdir())), threads)
            self.assertEqual(heard, [[]])

    def test_loop_ends_when_no_message_comes(self):
        robot = self.session()
        messages = robot.messages("log", Log, timeout=0.05)
        publisher = robot.advertise("log", Log)
        for i in range(3):
            publisher.publish(Log(line=i))
        self.assertEqual([message.line for message in messages], [0, 1, 2])
        publisher.publish(Log(line=3))
        self.assertEqual([message.line for message in messages], [3])
        self.assertEqual(messages.info.sequence, 4)

    def test_subscription_ends_with_the_object(self):
        robot = self.session()
        robot.advertise("log", Log)
        messages = robot.messages("log", Log)
        self.assertTrue(robot.wait_for_subscribers("log", timeout=DEADLINE_S))
        del messages
        wait_until(lambda: not robot.wait_for_subscribers("log", timeout=0.0))

    def test_async_for_ends_when_no_message_comes(self):
        async def listen():
            robot = self.session()
            publisher = robot.advertise("log", Log)
            messages = robot.messages("log", Log, timeout=DEADLINE_S)
            asyncio.get_running_loop().call_later(0.02, publisher.publish, Log(line=7))
            async for message in messages:
                messages.timeout = 0.05
                yield message.line

        async def lines():
            return [line async for line in listen()]

        self.assertEqual(asyncio.run(lines()), [7])

    def test_callbacks_run_in_an_event_loop(self):
        async def run():
            robot = self.session()
            robot.subscribe("log", Log, lambda message, info: robot.stop())
            publisher = robot.advertise("log", Log)
            asyncio.get_running_loop().call_later(0.02, publisher.publish, Log())
            await asyncio.wait_for(robot.spin_async(), DEADLINE_S)

        asyncio.run(run())

    def test_waiting_thread_lets_others_run(self):
        robot = self.session()
        turns = 0
        done = threading.Event()

        def work():
            nonlocal turns
            while not done.is_set():
                turns += 1
                time.sleep(0)

        with self.beside(work):
            list(robot.messages("log", Log, timeout=0.2))
            done.set()
        self.assertGreater(turns, 10)


if __name__ == "__main__":
    main()
