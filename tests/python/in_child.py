"""What a process of multiprocessing runs in a test."""

import hgros
from foxglove.Log_pb2 import Log


def say_hello():
    with hgros.Session() as robot:
        publisher = robot.advertise("log", Log)
        assert robot.wait_for_subscribers("log", timeout=40)
        publisher.publish(Log(message="hello from a child"))
