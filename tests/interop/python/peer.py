"""The peer in Python. ../README.md says what each role does."""

import os
import select
import sys
import time
from typing import Callable

import numpy as np

import hgros
from foxglove.Log_pb2 import Log
from foxglove.PointCloud_pb2 import PointCloud
from foxglove.PoseInFrame_pb2 import PoseInFrame

PATIENCE_S = 30.0
SLICE_S = 0.1
ROOM = hgros.KeepAll(100)


class Fault(Exception):
    """Something that is not part of the role."""


def say(line: str) -> None:
    print(line, flush=True)


class Input:
    """The lines of standard input."""

    def __init__(self) -> None:
        self._text = b""
        self._ended = False

    def waits(self, timeout_s: float | None = None) -> bool:
        """Whether there is a next line, or the end, within the timeout; without one it waits for that."""
        while not self._ended and b"\n" not in self._text:
            if not select.select([0], [], [], timeout_s)[0]:
                return False
            part = os.read(0, 4096)
            self._text += part
            self._ended = not part
        return True

    def next(self) -> str | None:
        self.waits()
        line, end, rest = self._text.partition(b"\n")
        if not end:
            return None
        self._text = rest
        return line.decode()


def pattern(size: int) -> np.ndarray:
    return ((np.arange(size, dtype=np.uint64) * 7 + 3) & 255).astype(np.uint8)


class Peer:
    def __init__(self, robot: hgros.Session) -> None:
        self.robot = robot
        self.input = Input()
        robot.start()  # For services.

    def run(self, role: str, *arguments: str) -> None:
        roles: dict[str, Callable[..., None]] = {
            "talk": self.talk, "publish": self.publish, "subscribe": self.subscribe, "latch": self.latch,
            "bulk-publish": self.bulk_publish, "bulk-subscribe": self.bulk_subscribe, "serve": self.serve,
            "call": self.call, "misfit": self.misfit}
        if role not in roles:
            raise Fault(f"There is no role {role}.")
        roles[role](*arguments)

    def talk(self) -> None:
        say("ready")
        while (line := self.input.next()) is not None:
            if words := line.split():
                self.run(*words)

    def await_subscriber(self, channel: str) -> None:
        if not self.robot.wait_for_subscribers(channel, timeout=PATIENCE_S):
            raise Fault(f"No subscriber came to {channel}.")

    def publish(self, channel: str, count: str) -> None:
        publisher = self.robot.advertise(channel, Log)
        self.await_subscriber(channel)
        sent = 0
        while sent < int(count) and not self.input.waits(0):
            try:
                publisher.publish(Log(message=str(sent + 1)), timeout=SLICE_S)
            except hgros.QueueFull:
                continue
            sent += 1
            if sent == 1:
                say("publishing")
        say(f"published {sent}")
        self.input.waits()

    def subscribe(self, channel: str, count: str) -> None:
        received, first, last = 0, "", ""
        with self.robot.messages(channel, Log, timeout=SLICE_S, queue=ROOM) as messages:
            while received < int(count) and not self.input.waits(0):
                if (log := next(messages, None)) is None:
                    continue
                received, last = received + 1, log.message
                if received == 1:
                    first = last
                    say(f"receiving {last}")
                if first == "1" and last != str(received):
                    raise Fault(f'"{last}" came, not {received}.')
        say(f"received {received} {last}")

    def latch(self, channel: str, text: str) -> None:
        publisher = self.robot.advertise(channel, Log, latched=2)
        for one in ("old", text, "new"):
            publisher.publish(Log(message=one))
        say("latched")
        self.input.waits()

    def bulk_publish(self, channel: str, size: str) -> None:
        publisher = self.robot.advertise(channel, PointCloud)
        self.await_subscriber(channel)
        with publisher.loan(int(size), timeout=PATIENCE_S) as cloud:
            cloud.point_stride = 1
            np.frombuffer(hgros.data(cloud), np.uint8)[:] = pattern(int(size))
        say(f"published {size}")
        self.input.waits()

    def bulk_subscribe(self, channel: str, size: str) -> None:
        with self.robot.messages(channel, PointCloud, timeout=PATIENCE_S, queue=ROOM) as messages:
            say("subscribed")
            if (cloud := next(messages, None)) is None:
                raise Fault(f"Nothing came on {channel}.")
            if not np.array_equal(np.frombuffer(cloud.data, np.uint8), pattern(int(size))):
                raise Fault(f"The cloud has {len(cloud.data)} bytes, or other ones.")
            say(f"received {size}")

    def serve(self, name: str) -> None:
        def answer(request: Log) -> Log:
            if request.message == "fail":
                raise Fault("asked to fail")
            return Log(message=f"re: {request.message}")

        service = self.robot.serve(name, Log, Log, answer)
        say("serving")
        self.input.waits()
        service.end()

    def call(self, name: str, text: str) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while True:
            try:
                say(f"answer {self.robot.call(name, Log(message=text), Log, timeout=PATIENCE_S).result().message}")
                return
            except hgros.CallError as error:
                if error.kind != "no server" or time.monotonic() > deadline:
                    say(f"failed {error}")
                    return
            if self.input.waits(0.01):
                raise Fault(f"Nobody serves {name}.")

    def misfit(self, channel: str) -> None:
        subscription = self.robot.subscribe(channel, PoseInFrame, lambda pose, info: None)
        say("subscribed")
        self.input.waits()
        subscription.end()


def main() -> int:
    try:
        with hgros.Session(text=os.environ.get("HGROS_INTEROP_YAML", "")) as robot:
            Peer(robot).run(*sys.argv[1:])
        return 0
    except (Fault, hgros.Error, TypeError) as error:
        print(f"peer: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
