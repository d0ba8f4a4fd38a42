#!/usr/bin/env python3
"""Runs the roles of tests/interop/csharp/Peer.cs against each other.

    peer_test.py PAIR COMMAND...
"""

import os
import subprocess
import sys

COMMAND = sys.argv[2:]


class Peer:
    """A process of the peer; ctest ends what takes too long."""

    def __init__(self, *words, **pipes):
        environment = dict(os.environ, HGROS_DOMAIN=f"csharp-peer-{os.getpid()}", HGROS_INTEROP_YAML="")
        self.process = subprocess.Popen([*COMMAND, *map(str, words)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True, env=environment, **pipes)

    def says(self, line):
        said = self.process.stdout.readline()
        if said != line + "\n":
            sys.exit(f"{self.process.args[len(COMMAND):]} printed {said!r} instead of {line!r}")

    def ends(self):
        said = self.process.communicate()[0]
        if self.process.returncode != 0:
            sys.exit(f"{self.process.args[len(COMMAND):]} ended with {self.process.returncode}")
        return said

    def dies(self):
        self.process.kill()
        self.process.communicate()


def lossless():
    publisher, subscriber = Peer("publish", "words", 1000), Peer("subscribe", "words", 1000)
    subscriber.says("subscribed")
    subscriber.says("received 1000")
    subscriber.ends()
    publisher.says("published 1000")
    publisher.ends()


def latched():
    first = Peer("latch", "words", "a wörd")
    first.says("latched")
    late = Peer("late", "words")
    late.says("late a wörd")
    late.ends()
    first.ends()


def bulk():
    publisher, subscriber = Peer("bulk-publish", "cloud", 4000001), Peer("bulk-subscribe", "cloud", 4000001)
    subscriber.says("subscribed")
    subscriber.says("received 4000001")
    subscriber.ends()
    publisher.says("published 4000001")
    publisher.ends()


def service():
    server = Peer("serve", "ask")
    server.says("serving")
    for text, line in (("hello", "answer re: hello"), ("fail", "failed asked to fail")):
        caller = Peer("call", "ask", text)
        caller.says(line)
        caller.ends()
    server.ends()


def misfit():
    publisher = Peer("latch", "words", "hello")
    publisher.says("latched")
    subscriber = Peer("misfit", "words", stderr=subprocess.PIPE)
    subscriber.says("subscribed")
    while True:
        line = subscriber.process.stderr.readline()
        if "foxglove.PoseInFrame" in line and "foxglove.Log" in line:
            break
        if not line:
            sys.exit("the log does not name both types")
    subscriber.ends()
    publisher.ends()


def dying_subscriber():
    publisher, first = Peer("stream", "words"), Peer("follow", "words")
    publisher.says("streaming")
    first.says("following")
    first.dies()
    second = Peer("follow", "words")
    second.says("following")
    publisher.process.stdin.close()
    publisher.process.stdin = None
    publisher.process.wait()
    second.ends()


def dying_publisher():
    first, subscriber = Peer("stream", "words"), Peer("follow", "words")
    first.says("streaming")
    subscriber.says("following")
    first.dies()
    second = Peer("stream", "words")
    second.says("streaming")
    streamed = int(second.ends().removeprefix("streamed "))
    followed = int(subscriber.ends().removeprefix("followed "))
    if followed <= streamed - 200:
        sys.exit(f"of {streamed} messages of the second publisher {followed} came")


if __name__ == "__main__":
    globals()[sys.argv[1]]()
