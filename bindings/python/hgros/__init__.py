"""HyperGraph ROS for Python: sessions, channels, large data without copies.

    import hgros
    from foxglove.LaserScan_pb2 import LaserScan

    with hgros.Session() as robot:
        nearest = robot.advertise("nearest", LaserScan)

        @robot.subscribe("scan")
        def on_scan(scan, info):
            ...

        robot.spin()
"""

from . import requirements  # First: it says why the next line may fail.
from ._hgros import MessageInfo, StampMatcher
from .bulk import data, image, message, points
from .component import Client, Context
from .errors import ConfigError, Error, PublishError, QueueFull, SessionClosed, TypeMismatch
from .parameters import ParamError, Parameters
from .publisher import Publisher
from .queues import KeepAll, KeepLast
from .services import Call, CallError, Service
from .session import Session
from .snapshot import ChannelSnapshot, ChannelTraffic, KnownChannel, NodeSnapshot, Peer, SessionSnapshot, Times
from .stream import Messages
from .subscription import Subscription
from .synchronizer import Synchronizer
from .timers import Rate, Tick, Timer
from .transforms import TransformError, Transforms

__all__ = ["Call", "CallError", "ChannelSnapshot", "ChannelTraffic", "Client", "ConfigError", "Context", "Error",
           "KeepAll", "KeepLast", "KnownChannel", "MessageInfo", "Messages", "NodeSnapshot", "ParamError",
           "Parameters", "Peer", "PublishError", "Publisher", "QueueFull", "Rate", "Service", "Session",
           "SessionClosed", "SessionSnapshot", "StampMatcher", "Subscription", "Synchronizer", "Tick", "Timer", "Times",
           "TransformError", "Transforms", "TypeMismatch", "data", "image", "leases", "message", "points"]


def leases() -> tuple[int, int]:
    """How many received messages this program keeps in the memory where they arrived, and their bytes."""
    from ._hgros import leases as count

    return count()
