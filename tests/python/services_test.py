import asyncio
import contextlib
import gc
import logging
import os
import threading
import time

from support import DEADLINE_S, RobotTest, main, wait_until

import hgros
from foxglove.Log_pb2 import Log
from foxglove.Vector2_pb2 import Vector2


def add(request):
    if request.x < 0:
        raise ValueError("x is below zero")
    return Log(message=str(request.x + request.y))


class Services(RobotTest):
    def served(self):
        server, client = self.session(), self.session()
        self.service = server.serve("add", Vector2, Log, add)
        server.start()
        return server, client

    def call(self, robot, name, *args, **options):
        """Calls once the service is found."""
        self.assertTrue(robot.wait_for_service(name, timeout=DEADLINE_S))
        return robot.call(name, *args, **options).result()

    def failure(self, call):
        with self.assertRaises(hgros.CallError) as failed:
            call.result()
        return failed.exception

    def test_call_gets_the_reply_of_another_session_whose_type_the_server_may_tell(self):
        _, client = self.served()
        for types in ((Log,), ()):
            reply = self.call(client, "add", Vector2(x=1, y=2), *types, timeout=DEADLINE_S)
            self.assertEqual(reply.message, "3.0")
            if types:
                self.assertIs(type(reply), Log)

    def test_exception_of_a_handler_is_logged_and_reaches_the_caller(self):
        server, _ = self.served()
        with self.assertLogs("hgros", logging.ERROR) as logged:
            failure = self.failure(server.call("add", Vector2(x=-1), Log, timeout=DEADLINE_S))
        self.assertEqual(failure.kind, "handler failed")
        self.assertIn("ValueError: x is below zero", str(failure))
        self.assertIn("in add", logged.output[0])
        self.assertEqual((self.service.run, self.service.failed), (1, 1))

    def test_handler_may_raise_what_cannot_be_said_or_return_another_type(self):
        class Unspeakable(Exception):
            def __str__(self):
                raise RuntimeError("no words")

        faults = [ValueError(b"$GPG\xfcA".decode(errors="surrogateescape")), Unspeakable()]

        def fail(request):
            if not faults:
                return request
            raise faults.pop(0)

        server = self.session()
        server.serve("fail", Vector2, Log, fail)
        server.start()
        for words in (r"ValueError: $GPG\udcfcA", "Unspeakable (its __str__ has raised RuntimeError)",
                      "must return foxglove.Log"):
            with self.assertLogs("hgros", logging.ERROR):
                self.assertIn(words, str(self.failure(server.call("fail", Vector2(), Log, timeout=DEADLINE_S))))

    def test_call_without_a_server_that_spins_times_out_is_cancelled_or_ends_with_its_service(self):
        robot = self.session()
        self.assertEqual(self.failure(robot.call("nothing", Vector2(), Log, timeout=0.2)).kind, "no server")
        self.assertFalse(robot.wait_for_service("nothing", timeout=0.1))
        service = robot.serve("add", Vector2, Log, add)
        self.assertEqual(self.failure(robot.call("add", Vector2(), Log, timeout=0.05)).kind, "timed out")
        call = robot.call("add", Vector2(), Log, timeout=DEADLINE_S)
        call.cancel()
        self.assertEqual(self.failure(call).kind, "cancelled")
        call = robot.call("add", Vector2(), Log, timeout=DEADLINE_S)
        service.end()
        self.assertIn(self.failure(call).kind, ("handler failed", "server gone"))

    def test_dropped_call_goes_on(self):
        robot = self.session()
        served = []
        robot.serve("add", Vector2, Log, lambda request: served.append(request.x) or Log())
        robot.call("add", Vector2(x=3), Log, timeout=DEADLINE_S)
        gc.collect()
        self.spin_until(robot, lambda: served)
        self.assertEqual(served, [3])

    def test_thread_that_waits_for_itself_gets_an_error(self):
        robot = self.session()
        robot.serve("add", Vector2, Log, add)
        kinds = []

        @robot.subscribe("log")
        def on_log(message, info):
            try:
                robot.call("add", Vector2(), Log, timeout=DEADLINE_S).result()
            except hgros.CallError as error:
                kinds.append(error.kind)

        robot.advertise("log", Log).publish(Log())
        self.spin_until(robot, lambda: kinds)
        self.assertEqual(kinds, ["would deadlock"])

    def test_call_is_awaited(self):
        async def run():
            server, _ = self.served()
            replies = await asyncio.gather(*(server.call("add", Vector2(x=i), Log, timeout=DEADLINE_S) for i in range(5)))
            return [reply.message for reply in replies]

        self.assertEqual(asyncio.run(run()), ["0.0", "1.0", "2.0", "3.0", "4.0"])

    def test_calls_need_no_descriptor_unless_they_are_waited_for(self):
        def descriptors():
            return len(os.listdir("/proc/self/fd"))

        server, client = self.served()
        self.call(client, "add", Vector2(x=1, y=2))
        gc.disable()  # What has ended goes without it.
        self.addCleanup(gc.enable)
        logging.disable(logging.CRITICAL)
        self.addCleanup(logging.disable, logging.NOTSET)
        before = descriptors()
        calls = [client.call("add", Vector2(x=x, y=0)) for x in range(-50, 50)]
        self.assertLess(descriptors(), before + 10)
        for call in calls:
            with contextlib.suppress(hgros.CallError):
                call.result()
        calls.clear()
        call = None
        self.assertLess(descriptors(), before + 10)

        async def awaited():
            await asyncio.gather(*(client.call("add", Vector2(x=x, y=0)) for x in range(-50, 50)), return_exceptions=True)

        asyncio.run(awaited())
        self.assertLess(descriptors(), before + 10)

    def test_server_does_not_handle_what_a_task_has_cancelled(self):
        server, client = self.session(), self.session()
        begun, goes_on, handled = threading.Event(), threading.Event(), []

        def slow(request):
            handled.append(request.x)
            begun.set()
            goes_on.wait(DEADLINE_S)
            return Log()

        server.serve("slow", Vector2, Log, slow)
        server.start()
        self.addCleanup(goes_on.set)

        async def awaited(call):
            return await call

        async def give_up():
            with self.assertRaises(asyncio.TimeoutError):
                await asyncio.wait_for(awaited(client.call("slow", Vector2(x=2))), 0.05)

        with self.beside(lambda: self.call(client, "slow", Vector2(x=1))):
            self.assertTrue(begun.wait(DEADLINE_S))
            asyncio.run(give_up())
            with self.beside(lambda: self.call(client, "slow", Vector2(x=3))):  # It comes after the cancellation.
                wait_until(lambda: server.snapshot().channel("hgros/serve/slow").nodes[0].received == 3)
                goes_on.set()
        self.assertEqual(handled, [1, 3])

    def test_session_that_closes_while_a_handler_runs_sends_its_reply(self):
        owner, caller = self.session(), self.session()
        entered, leave, replies = threading.Event(), threading.Event(), []
        self.addCleanup(leave.set)
        timer = owner.timer(1000, print)

        @owner.serve("slow", Vector2, Log)
        def slow(request):
            entered.set()
            leave.wait(DEADLINE_S)
            return Log(message="late")

        owner.start()
        with self.beside(lambda: replies.append(self.call(caller, "slow", Vector2(), Log, timeout=DEADLINE_S))):
            self.assertTrue(entered.wait(DEADLINE_S))
            with self.beside(owner.close):
                wait_until(lambda: not timer.active)  # What came after it, the service, has been looked at before.
                leave.set()
        self.assertEqual([reply.message for reply in replies], ["late"])


class Time(RobotTest):
    def test_slow_timer_skips_turns_and_counts_them(self):
        robot = self.session()
        ticks = []

        def on_tick(tick):
            ticks.append(tick)
            if len(ticks) == 1:
                robot.sleep(0.05)

        timer = robot.timer(0.01, on_tick)
        self.spin_until(robot, lambda: len(ticks) >= 3)
        self.assertGreaterEqual(sum(tick.missed for tick in ticks), 2)
        self.assertLessEqual(ticks[0].planned_ns, ticks[0].now_ns)
        self.assertLess(abs(robot.now_ns - time.time_ns()), 10**9, "the clock of the system")
        for before, after in zip(ticks, ticks[1:]):
            self.assertEqual(after.planned_ns - before.planned_ns, 10_000_000 * (1 + after.missed))
        timer.end()
        robot.spin_once(0.03)
        count = len(ticks)
        robot.spin_once(0.03)
        self.assertEqual(len(ticks), count)

    def test_timers_without_a_name_take_that_of_one_that_has_ended(self):
        robot = self.session()
        together = [robot.timer(0.01, print), robot.timer(0.01, print)]
        self.assertNotEqual(together[0].name, together[1].name)
        for timer in together:
            timer.end()
            timer.end()
        for _ in range(20):
            robot.sleep(1e-6)
            robot.rate(0.01).close()
            robot.timer(0.01, print).end()
        self.assertEqual(len([one for one in robot.snapshot().channels if "python" in one.name]), 2)

    def test_rate_turns_without_drift(self):
        robot = self.session()
        ticks = [tick for tick, _ in zip(robot.rate(0.01), range(4))]
        self.assertEqual(ticks[3].planned_ns - ticks[0].planned_ns,
                         10_000_000 * (3 + sum(tick.missed for tick in ticks[1:])))

    def test_rate_ends_with_its_session(self):
        robot = self.session()
        rate = robot.rate(1000)
        threading.Timer(0.05, robot.close).start()
        self.assertEqual(list(rate), [])

    def test_rate_of_a_session_that_another_thread_closes_meanwhile_ends(self):
        robot = self.session()
        add = robot._streams.add
        robot._streams.add = lambda rate: (robot.close(), add(rate))
        with self.beside(lambda: list(robot.rate(1000))):
            pass

    def test_simulated_time_moves_timers(self):
        from hgros.SimulatedTime_pb2 import SimulatedTime

        robot, simulator = self.session(text="time: simulated"), self.session()
        clock = simulator.advertise("clock", SimulatedTime, latched=1)
        clock.publish(SimulatedTime(time_ns=1000 * 10**9, rate=1, paused=True, clock_id=7))
        wait_until(lambda: robot.now_ns == 1000 * 10**9, "the simulated clock")
        ticks = []

        @robot.timer(3600)
        def on_tick(tick):
            ticks.append(tick)

        clock.publish(SimulatedTime(time_ns=4600 * 10**9, rate=1, paused=True, clock_id=7))
        self.spin_until(robot, lambda: ticks)
        self.assertEqual(ticks[0].planned_ns, 4600 * 10**9)


if __name__ == "__main__":
    main()
