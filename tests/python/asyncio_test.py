"""asyncio: Ctrl-C and ends, in programs of their own."""

import asyncio
import signal

import numpy as np
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

async def main(waits):
    with hgros.Session() as robot:
        await first(robot, *waits(robot))

for waits in (lambda robot: [listen(robot)], lambda robot: [listen(robot, timeout=100)], lambda robot: [ask(robot)],
              lambda robot: [robot.spin_async()]):
    try:
        asyncio.run(main(waits))
    except KeyboardInterrupt:
        print("interrupted")
asyncio.run(main(lambda robot: [listen(robot), ask(robot), robot.spin_async()]))
"""


class Asyncio(RobotTest):
    def test_ctrl_c_ends_loops_calls_callbacks_and_several_waits_at_once(self):
        process = self.python("import functools; print = functools.partial(print, flush=True)" + PROGRAM)
        for ended in range(5):
            self.assertEqual(process.stdout.readline(), "waits\n")
            process.send_signal(signal.SIGINT)
            if ended < 4:
                self.assertEqual(process.stdout.readline(), "interrupted\n")
        out, err, code = self.finish(process)
        self.assertEqual((out, code), ("", -signal.SIGINT), err)
        self.assertEqual(err.splitlines()[-1], "KeyboardInterrupt")
        for noise in ("destroyed", "never", "ignored", "Warning", "hgros:"):
            self.assertNotIn(noise, err)

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

    def test_transform_is_awaited_until_it_comes_its_time_is_up_or_the_session_closes(self):
        robot, other = self.session(), self.session()
        pose = np.eye(4)
        pose[0, 3] = 2

        async def run():
            lookup = asyncio.ensure_future(robot.transforms.lookup_async("map", "base", timeout=DEADLINE_S))
            await asyncio.sleep(0)  # It waits now.
            other.transforms.send_static("map", "base", pose)
            np.testing.assert_allclose(await lookup, pose)
            np.testing.assert_allclose(await robot.transforms.lookup_async("map", "base"), pose)
            with self.assertRaisesRegex(hgros.TransformError, "nowhere"):
                await robot.transforms.lookup_async("map", "nowhere", timeout=0.01)
            lookup = asyncio.ensure_future(robot.transforms.lookup_async("map", "nowhere"))
            await asyncio.sleep(0)
            robot.close()
            with self.assertRaisesRegex(hgros.Error, "closed"):
                await lookup

        asyncio.run(run())

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
