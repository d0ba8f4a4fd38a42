"""Errors of the package."""

from __future__ import annotations

from ._hgros import ConfigError, Error, TypeMismatch
from .readable import readable

__all__ = ["ConfigError", "Error", "PublishError", "QueueFull", "SessionClosed", "TypeMismatch"]


def _shown(fault: Error) -> str:
    return readable(RuntimeError.__str__(fault))


setattr(Error, "__str__", _shown)  # Names and texts of others may be in it.


class PublishError(Error):
    """A message was not published; nobody got it."""


class QueueFull(PublishError):
    """A lossless subscriber had no room, and the time to wait for it was over."""


class SessionClosed(PublishError):
    """The session of the publisher is closed."""


# In the order of hgros::PublishStatus.
_STATUS: dict[int, tuple[type[PublishError], str]] = {
    1: (QueueFull, "A lossless subscriber has no room. Publish again later, or give a timeout to wait for room."),
    2: (SessionClosed, "The session is closed."),
    3: (PublishError, "Waiting here would wait forever. Publish without a timeout, or on another thread."),
    4: (QueueFull, "A lossless subscriber had no room until the timeout."),
    5: (PublishError, "The message is empty."),
    6: (PublishError, "Waiting was stopped."),
    7: (PublishError, "Another session subscribes, and the message is larger than 1 GiB. Publish it in parts."),
    8: (PublishError, "There is no memory to write the message for other sessions."),
}


def raise_unless_ok(status: int, channel: str) -> None:
    """Raises what a status other than 0 means."""
    if status:
        kind, text = _STATUS.get(status, (PublishError, f"Status {status}."))
        raise kind(f'Nothing was published on channel "{channel}": {text}')
