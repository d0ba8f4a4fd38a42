"""asyncio: Ctrl-C and ends, in programs of their own."""

import asyncio
import signal

from support import DEADLINE_S, RobotTest, main, wait_until

import hgros
from foxglove.Log_pb2 import Log
from foxglove.Vector2_pb2 import Vector2

PROGRAM = """
import asyncio
import hgros
from foxglove.Vector2_pb2 import Vector2

async def listen(robot, **options):
    async for message in robot.messages("nothing", **options):
        pass

async def ask(robot):
    await robot.call("nobody", Vector2(), Vector2, timeout=100)

async def first(robot, *waits):
    # The waits begin in the order of their tasks, before this line is written.
    asyncio.get_running_loop().call_soon(lambda: asyncio.get_running_loop().call_soon(print, "waits"))
    await asyncio.gather(*waits)

async def main():
    with hgros.Session() as robot:
        await first(robot, WAITS)

asyncio.run(main())
"""


class Asyncio(RobotTest):
    def run_until_ctrl_c(self, waits):
        process = self.python("import functools; print = functools.partial(print, flush=True)" +
                              PROGRAM.replace("WAITS", waits))
        self.assertEqual(process.stdout.readline(), "waits\n")
        process.send_signal(signal.SIGINT)
        out, err, code = self.finish(process)
        self.assertEqual((out, code), ("", -signal.SIGINT), err)
        self.assertEqual(err.splitlines()[-1], "KeyboardInterrupt")
        for noise in ("destroyed", "never", "ignored", "Warning", "hgros:"):
            self.assertNotIn(noise, err)

    def test_ctrl_c_ends_a_loop_over_messages(self):
        self.run_until_ctrl_c("listen(robot)")

    def test_ctrl_c_ends_a_loop_with_a_timeout(self):
        self.run_until_ctrl_c("listen(robot, timeout=100)")

    def test_ctrl_c_ends_a_call(self):
        self.run_until_ctrl_c("ask(robot)")

    def test_ctrl_c_ends_callbacks(self):
        self.run_until_ctrl_c("robot.spin_async()")

    def test_ctrl_c_ends_several_waits_at_once(self):
        self.run_until_ctrl_c("listen(robot), ask(robot), robot.spin_async()")

    def test_several_tasks_wait_for_one_reply(self):
        robot, other = self.session(), self.session()
        robot.serve("double", Vector2, Vector2, lambda request: Vector2(x=2 * request.x))
        wait_until(lambda: any(one.name == "hgros/call/double" and one.subscribers for one in other.channels()))

        async def ask():
            call = other.call("double", Vector2(x=2), Vector2, timeout=DEADLINE_S)

            async def wait():
                return await call

            waits = [asyncio.ensure_future(wait()) for _ in range(3)]
            await asyncio.sleep(0)  # All of them wait now.
            robot.start()
            return await asyncio.wait_for(asyncio.gather(*waits), DEADLINE_S)

        self.assertEqual([reply.x for reply in asyncio.run(ask())], [4, 4, 4])

    def test_cancelled_loop_can_be_continued(self):
        robot = self.session()
        logs = robot.messages("log", Log)
        publisher = robot.advertise("log", Log)

        async def listen():
            task = asyncio.ensure_future(logs.__anext__())
            await asyncio.sleep(0)
            task.cancel()
            with self.assertRaises(asyncio.CancelledError):
                await task
            publisher.publish(Log(message="after"))
            return (await asyncio.wait_for(logs.__anext__(), DEADLINE_S)).message

        self.assertEqual(asyncio.run(listen()), "after")


if __name__ == "__main__":
    main()
