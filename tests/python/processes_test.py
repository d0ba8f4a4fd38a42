import os
import signal

from support import RobotTest, main, rounds

import hgros
from foxglove.Log_pb2 import Log


class Processes(RobotTest):
    def test_ctrl_c_ends_spin_a_publisher_that_waits_for_room_and_a_loop_at_once(self):
        process = self.python("import hgros\n"
                              "from foxglove.Log_pb2 import Log\n"
                              "def interrupted(wait):\n"
                              "    try: print('ready', flush=True); wait()\n"
                              "    except KeyboardInterrupt: print('interrupted', flush=True)\n"
                              "with hgros.Session() as robot:\n"
                              "    robot.subscribe('log', callback=lambda message, info: None)\n"
                              "    interrupted(robot.spin)\n"
                              "def publish():\n"
                              "    while True: publisher.publish(Log(), timeout=1000)\n"
                              "with hgros.Session() as robot:\n"
                              "    messages = robot.messages('log', queue=hgros.KeepAll(1))\n"
                              "    publisher = robot.advertise('log', Log)\n"
                              "    interrupted(publish)\n"
                              "with hgros.Session() as robot:\n"
                              "    messages = robot.messages('log')\n"
                              "    print('ready', flush=True)\n"
                              "    for message in messages: pass\n")
        for last in (False, False, True):
            self.assertEqual(process.stdout.readline(), "ready\n", process.stderr)
            process.send_signal(signal.SIGINT)
            if not last:
                self.assertEqual(process.stdout.readline(), "interrupted\n", process.stderr)
        out, err, code = self.finish(process)
        self.assertEqual((out, code), ("", -signal.SIGINT), err)
        self.assertIn("KeyboardInterrupt", err)

    def test_interrupted_callback_leaves_the_rest_for_the_next_spin(self):
        robot = self.session()
        heard = []

        def on_log(message, info):
            heard.append(message.line)
            if message.line == 1:
                raise KeyboardInterrupt

        robot.subscribe("log", Log, on_log)
        publisher = robot.advertise("log", Log)
        for i in range(4):
            publisher.publish(Log(line=i))
        with self.assertRaises(KeyboardInterrupt):
            robot.spin()
        self.spin_until(robot, lambda: len(heard) == 4)
        self.assertEqual(heard, [0, 1, 2, 3])

    def run_to_end(self, code):
        out, err, exit_code = self.finish(self.python("import hgros, os, sys, threading\n"
                                                      "from foxglove.Log_pb2 import Log\n" + code))
        return out, err, exit_code

    def test_interpreter_ends_without_close(self):
        out, err, code = self.run_to_end("robot = hgros.Session()\n"
                                         "other = hgros.Session()\n"
                                         "robot.subscribe('log', Log, print, queue=hgros.KeepAll(1))\n"
                                         "publisher = robot.advertise('log', Log)\n"
                                         "try:\n"
                                         "    for _ in range(100): publisher.publish(Log())\n"
                                         "except hgros.QueueFull: print('full')\n"
                                         "other.start()\n")
        self.assertEqual((out, err, code), ("full\n", "", 0))

    def test_interpreter_ends_while_daemon_threads_use_the_session(self):
        for close in ("", "robot.close()\n"):
            with self.subTest(close):
                process = self.python("import sys, threading, time\n"
                                      "import hgros\n"
                                      "robot = hgros.Session()\n"
                                      "used = threading.Semaphore(0)\n"
                                      "def use(function):\n"
                                      "    while True:\n"
                                      "        try: function()\n"
                                      "        except hgros.Error: pass\n"
                                      "        used.release()\n"
                                      "for function in (lambda: robot.transforms.lookup('map', 'base', timeout=0.02),\n"
                                      "                 lambda: robot.transforms.lookup('map', 'base', timeout=5),\n"
                                      "                 lambda: robot.snapshot(), lambda: robot.channels(),\n"
                                      "                 lambda: list(robot.messages('log', timeout=0.01))):\n"
                                      "    threading.Thread(target=use, args=(function,), daemon=True).start()\n"
                                      "for _ in range(100): used.acquire()\n" + close + "sys.exit(3)\n")
                out, err, code = self.finish(process)
                self.assertEqual((out, err, code), ("", "", 3))

    def test_os_exit_ends_the_process(self):
        out, err, code = self.run_to_end("robot = hgros.Session()\n"
                                         "robot.subscribe('log', Log, print)\n"
                                         "robot.start()\n"
                                         "os._exit(7)\n")
        self.assertEqual((err, code), ("", 7))

    def test_exit_inside_a_callback_ends_the_program(self):
        out, err, code = self.run_to_end("robot = hgros.Session()\n"
                                         "robot.subscribe('log', Log, lambda message, info: sys.exit(3))\n"
                                         "robot.advertise('log', Log).publish(Log())\n"
                                         "robot.spin()\n")
        self.assertEqual((err, code), ("", 3))

    def test_exit_inside_a_callback_of_start_is_said(self):
        out, err, code = self.run_to_end("import asyncio\n"
                                         "def heard(message, info):\n"
                                         "    if message.message == 'end': sys.exit(3)\n"
                                         "    if message.message == 'cancel': raise asyncio.CancelledError\n"
                                         "    print(message.message, flush=True)\n"
                                         "    again.set()\n"
                                         "again = threading.Event()\n"
                                         "robot = hgros.Session()\n"
                                         "robot.subscribe('log', Log, heard)\n"
                                         "publisher = robot.advertise('log', Log)\n"
                                         "robot.start()\n"
                                         "for word in ('end', 'cancel'):\n"
                                         "    publisher.publish(Log(message=word))\n"
                                         "    robot._thread.join()\n"
                                         "    robot.start()\n"
                                         "publisher.publish(Log(message='again'))\n"
                                         "again.wait(40)\n")
        self.assertEqual((out, code), ("again\n", 0), err)
        self.assertIn("A callback called sys.exit() on the thread of start(), which has ended.", err)
        self.assertIn("A callback raised CancelledError on the thread of start(), which has ended.", err)

    def test_spin_ends_in_a_child_that_a_callback_forks(self):
        self.assertEqual(("3 6\n", "", 0), self.run_to_end(
            "robot = hgros.Session()\n"
            "publisher = robot.advertise('log', Log)\n"
            "seen = []\n"
            "child = -1\n"
            "@robot.subscribe('log', Log)\n"
            "def on_log(message, info):\n"
            "    global child\n"
            "    seen.append(message)\n"
            "    if len(seen) == 3: child = os.fork()\n"
            "    if len(seen) == 6: robot.stop()\n"
            "for _ in range(6): publisher.publish(Log())\n"
            "robot.spin()\n"
            "if child == 0: os._exit(len(seen))\n"
            "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), len(seen), flush=True)\n"))

    def test_ctrl_c_ends_spin_in_a_child_that_is_forked_after_a_wait_and_in_a_callback(self):
        out, err, _ = self.run_to_end(
            "import signal\n"
            "def child():\n"
            "    with hgros.Session() as own:\n"
            "        own.subscribe('log', callback=lambda message, info: None)\n"
            "        own.timer(0.1, lambda tick: os.kill(os.getpid(), signal.SIGINT))\n"
            "        try: own.spin()\n"
            "        except KeyboardInterrupt: os._exit(7)\n"
            "def fork(tick=None):\n"
            "    pid = os.fork()\n"
            "    if pid == 0: child()\n"
            "    robot.stop()\n"
            "    pids.append(pid)\n"
            "pids = []\n"
            "for in_callback in (False, True):\n"
            "    with hgros.Session() as robot:\n"
            "        if in_callback: robot.timer(0.05, fork), robot.spin()\n"
            "        else: robot.spin_once(0.05), fork()\n"
            "        print(os.waitstatus_to_exitcode(os.waitpid(pids[-1], 0)[1]), flush=True)\n")
        self.assertEqual(out, "7\n7\n", err)

    def test_every_use_in_a_forked_child_says_that_the_session_is_the_parents(self):
        self.assertEqual(("5\nalive\n", "", 0), self.run_to_end(
            "import asyncio, gc\n"
            "import numpy as np\n"
            "from foxglove.PointCloud_pb2 import PointCloud\n"
            "robot = hgros.Session()\n"
            "publisher = robot.advertise('log', Log)\n"
            "messages = robot.messages('log', timeout=40)\n"
            "subscription = robot.subscribe('log', Log, lambda message, info: None)\n"
            "service = robot.serve('add', Log, Log, lambda request: Log())\n"
            "call = robot.call('add', Log(), Log)\n"
            "timer, rate = robot.timer(1, lambda tick: None), robot.rate(1)\n"
            "params, transforms = robot.params, robot.transforms\n"
            "loan = robot.loan('points', PointCloud, 10)\n"
            "uses = dict(\n"
            "    name=lambda: robot.name, id=lambda: robot.id, now_ns=lambda: robot.now_ns,\n"
            "    advertise=lambda: robot.advertise('a', Log), publish=lambda: publisher.publish(Log()),\n"
            "    publish_and_wait=lambda: publisher.publish(Log(), timeout=1), loan=lambda: robot.loan('b', PointCloud, 10),\n"
            "    another_loan=lambda: robot.loan('points', PointCloud, 10), publish_loan=lambda: loan.__exit__(None, None, None),\n"
            "    subscribe=lambda: robot.subscribe('log', callback=lambda message, info: None),\n"
            "    received=lambda: subscription.received, dropped=lambda: messages.dropped,\n"
            "    messages=lambda: robot.messages('log'), next=lambda: next(messages), loop=lambda: list(messages),\n"
            "    asyncio=lambda: asyncio.run(messages.__anext__()),\n"
            "    wait_for_subscribers=lambda: robot.wait_for_subscribers('log'),\n"
            "    wait_for_publishers=lambda: robot.wait_for_publishers('log'),\n"
            "    wait_for_service=lambda: robot.wait_for_service('add'),\n"
            "    lookup_async=lambda: asyncio.run(transforms.lookup_async('a', 'b')),\n"
            "    serve=lambda: robot.serve('b', Log, Log, lambda request: Log()), call=lambda: robot.call('add', Log()),\n"
            "    result=call.result, done=call.done, cancel=call.cancel,\n"
            "    timer=lambda: robot.timer(1, lambda tick: None), rate=lambda: robot.rate(1), rate_sleep=rate.sleep,\n"
            "    rate_loop=lambda: list(rate), sleep=lambda: robot.sleep(1),\n"
            "    params=lambda: robot.params, param=lambda: params['a'], has=lambda: 'a' in params,\n"
            "    declare=lambda: params.declare('a', 1), set=lambda: params.set('a', 1), save=params.save,\n"
            "    on_change=lambda: params.on_change('a')(lambda paths: None),\n"
            "    transforms=lambda: robot.transforms, lookup=lambda: transforms.lookup('a', 'b', timeout=1),\n"
            "    send=lambda: transforms.send_static('a', 'b', np.eye(4)), flush=transforms.flush,\n"
            "    snapshot=robot.snapshot, channels=robot.channels, spin=robot.spin, spin_once=robot.spin_once,\n"
            "    start=robot.start, stop=robot.stop, spin_async=lambda: asyncio.run(robot.spin_async()))\n"
            "robot._lock.acquire()\n"
            "child = os.fork()\n"
            "if child == 0:\n"
            "    robot._lock = threading.RLock()\n"
            "    threading.Thread(target=robot._lock.acquire).start()  # As by a thread that only the parent has.\n"
            "    for name, use in uses.items():\n"
            "        try: use()\n"
            "        except hgros.Error as error: told = 'was forked' in str(error)\n"
            "        else: told = False\n"
            "        if not told: print(name, flush=True)\n"
            "    subscription.end(), service.end(), timer.end(), rate.close(), messages.close(), robot.close()\n"
            "    assert robot.closed\n"
            "    sys.exit(5)\n"
            "robot._lock.release()\n"
            "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)\n"
            "publisher.publish(Log(message='alive'))\n"
            "print(next(messages).message)\n"))

    def test_forked_child_does_not_give_back_memory_that_its_parent_keeps(self):
        self.assertEqual(("0 1\n{1}\n", "", 0), self.run_to_end(
            "import gc\n"
            "from foxglove.PointCloud_pb2 import PointCloud\n"
            "robot, other = hgros.Session(), hgros.Session()\n"
            "messages = other.messages('points', timeout=40, queue=hgros.KeepAll(4))\n"
            "publisher = robot.advertise('points', PointCloud)\n"
            "assert robot.wait_for_subscribers('points', timeout=40)\n"
            "def receive(value):\n"
            "    publisher.publish(PointCloud(data=bytes([value]) * 100_000))\n"
            "    return next(messages)\n"
            "kept = receive(1)\n"
            "child = os.fork()\n"
            "if child == 0:\n"
            "    assert hgros.leases() == (0, 0)\n"
            "    del kept, messages, publisher, robot, other\n"
            "    gc.collect()\n"
            "    sys.exit(0)\n"
            "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), hgros.leases()[0], flush=True)\n"
            "for value in range(2, 30): receive(value)\n"
            "print(set(kept.data))\n"))

    def test_forked_child_ends_and_drops_what_threads_of_its_parent_use(self):
        self.assertEqual(("dropped\n0\n", "", 0), self.run_to_end(
            "import gc\n"
            "robot = hgros.Session()\n"
            "publisher = robot.advertise('log', Log)\n"
            "messages = robot.messages('log', queue=hgros.KeepAll(1))\n"
            "subscription = robot.subscribe('log', Log, lambda message, info: None, queue=hgros.KeepAll(1))\n"
            "try:\n"
            "    while True: publisher.publish(Log(), timeout=0.05)\n"
            "except hgros.QueueFull: pass  # Two threads wait for room in an inbox.\n"
            "child = os.fork()\n"
            "if child == 0:\n"
            "    subscription.end(), messages.close()\n"
            "    del publisher, messages, subscription, robot\n"
            "    gc.collect()\n"
            "    print('dropped', flush=True)\n"
            "    os._exit(0)\n"
            "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)\n"))

    def test_forked_child_drops_what_threads_of_its_parent_use_all_the_time(self):
        self.assertEqual(("done\n", "", 0), self.run_to_end(
            "import gc\n"
            "robot = hgros.Session()\n"
            "publisher = robot.advertise('log', Log)\n"
            "messages = robot.messages('log', queue=hgros.KeepAll(8))\n"
            "subscription = robot.subscribe('log', Log, lambda message, info: None, queue=hgros.KeepAll(8))\n"
            "robot.start()\n"
            "done = threading.Event()\n"
            "def publish():\n"
            "    while not done.is_set():\n"
            "        try: publisher.publish(Log(), timeout=0.01)\n"
            "        except hgros.QueueFull: pass\n"
            "threading.Thread(target=publish).start()\n"
            f"for _ in range({rounds(4, 20)}):\n"
            "    next(messages)\n"
            "    child = os.fork()\n"
            "    if child == 0:\n"
            "        del publisher, messages, subscription, robot\n"
            "        gc.collect()\n"
            "        os._exit(0)\n"
            "    assert os.waitpid(child, 0)[1] == 0\n"
            "done.set()\n"
            "print('done')\n"))

    def test_session_of_a_child_of_multiprocessing(self):
        folder = os.path.join(os.path.dirname(os.path.abspath(__file__)))
        process = self.program("-Bc", f"import sys; sys.path.insert(0, {folder!r})\n"
                              "import multiprocessing, hgros, support\n"
                              "if __name__ == '__main__':\n"
                              "    robot = hgros.Session()\n"
                              "    messages = robot.messages('log', timeout=40)\n"
                              "    for method in ('fork', 'spawn'):\n"
                              "        child = multiprocessing.get_context(method).Process(target=support.say_hello)\n"
                              "        child.start()\n"
                              "        print(next(messages).message)\n"
                              "        child.join()\n"
                              "        print(child.exitcode)\n")
        out, err, code = self.finish(process)
        self.assertEqual((out, code), (2 * "hello from a child\n0\n", 0), err)


if __name__ == "__main__":
    main()
