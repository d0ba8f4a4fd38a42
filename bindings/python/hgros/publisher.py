"""Publishing on one channel."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

from google.protobuf.message import Message

from . import _hgros
from .arguments import check_seconds, check_size
from .bulk import LoanedMessage
from .errors import Error, raise_unless_ok
from .message_types import bulk_field

M = TypeVar("M", bound=Message)


class Publisher(Generic[M]):
    """Publishes messages of one type; made by `Session.advertise`. Any thread may use it."""

    def __init__(self, raw: _hgros.Publisher, channel: str, message_type: type[M]) -> None:
        self.channel = channel
        self.message_type = message_type
        self.bulk_field = bulk_field(message_type.DESCRIPTOR)
        self._raw = raw
        self._publish = raw.publish

    def publish(self, message: M, timeout: float | None = None) -> None:
        """Publishes a message; it may be changed afterwards.

        Without a timeout it never waits. With one it waits that long for room in the queues of lossless subscribers.
        Raises QueueFull if there is none, and PublishError if the message cannot be published for another reason.
        Nobody has got it then.
        """
        if timeout is not None:
            check_seconds(timeout, "timeout")
        received: Any = message
        if type(message) is self.message_type:
            status = self._publish(message.SerializeToString(), timeout)
        elif isinstance(message, self.message_type):
            wire = received._wire  # A BulkMessage, whose bytes are published as they are.
            status = (self._raw.publish_wire(wire, timeout) if type(wire) is _hgros.Wire else
                      self._publish(wire, timeout))
        else:
            given = f"the class {received.__name__}" if isinstance(received, type) else type(message).__name__
            raise TypeError(f'Channel "{self.channel}" carries {self.message_type.DESCRIPTOR.full_name}, '
                            f"not {given}.")
        if status:
            raise_unless_ok(status, self.channel)

    __call__ = publish

    def loan(self, size: int, timeout: float | None = None) -> LoanedMessage[M]:
        """A message whose large field has `size` bytes of memory that receivers read in place, for a `with` block.

        It is published at the end of the block, as by `publish`.
        """
        if self.bulk_field is None:
            raise Error(f"{self.message_type.DESCRIPTOR.full_name} has no field for a loan: that is the only `bytes` "
                        "field of a message. Publish an ordinary message.")
        return LoanedMessage(self, check_size(size), timeout)

    def __repr__(self) -> str:
        return f"Publisher({self.channel!r}, {self.message_type.DESCRIPTOR.full_name})"


AnyPublisher = Publisher[Any]
