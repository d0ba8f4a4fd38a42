"""Where the frames of the robot are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import _hgros
from .arguments import check_seconds
from .errors import Error
from .stream import until_woken

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt


class TransformError(Error):
    """Why there is no transform, or why one was refused.

    `fault` is "unknown frame", "not connected", "too old", "too new", or "refused".
    """

    def __init__(self, fault: str, text: str) -> None:
        super().__init__(text)
        self.fault = fault


def _ns(stamp: Any) -> int | None:
    """A stamp in ns, from an int, a google.protobuf.Timestamp, or None."""
    if stamp is None or isinstance(stamp, int):
        return stamp
    try:
        nanoseconds: int = stamp.ToNanoseconds()
    except AttributeError:
        raise TypeError(f"A stamp is a number of ns or a google.protobuf.Timestamp, not {stamp!r}.") from None
    return nanoseconds


def _fault(matrix: npt.NDArray[np.float64]) -> str:
    """Why it is no rotation and translation; empty if it is one."""
    import numpy as np

    if matrix.shape != (4, 4):
        return f"its shape is {matrix.shape}"
    if not np.all(np.isfinite(matrix)):
        return f"not all its numbers are finite: {matrix.tolist()}"
    if not np.allclose(matrix[3], (0, 0, 0, 1), atol=1e-9):
        return f"its last row is {matrix[3].tolist()}, not [0, 0, 0, 1]"
    turn = matrix[:3, :3]
    if not np.allclose(turn @ turn.T, np.eye(3), atol=1e-3) or np.linalg.det(turn) <= 0:
        return f"its upper left 3x3 is no rotation: {turn.tolist()}"
    return ""


class Transforms:
    """The transforms of all sessions; `Session.transforms`. The first use subscribes to them.

    A transform from `source` to `target` is a 4x4 matrix: it maps points of `source` to `target`, and is the pose of
    `source` in `target`.
    """

    def __init__(self, raw: _hgros.Transforms) -> None:
        self._raw = raw
        self._waits: set[_hgros.ReadyList] = set()

    def lookup(self, target: str, source: str, stamp: Any = None, *, timeout: float = 0.0) -> npt.NDArray[np.float64]:
        """The transform at a time, interpolated, or the latest one without a stamp.

        Waits at most `timeout` seconds until there is one. Raises TransformError with the reason if there is none.
        """
        return self.lookup_stamped(target, source, stamp, timeout=timeout)[0]

    def lookup_stamped(self, target: str, source: str, stamp: Any = None, *,
                       timeout: float = 0.0) -> tuple[npt.NDArray[np.float64], int]:
        """The same, and the time in ns at which it holds; 0 if all edges on the way are static."""
        import numpy as np

        check_seconds(timeout, "timeout")
        rows, at, fault, text = self._raw.lookup(target, source, _ns(stamp), timeout)
        if rows is None:
            raise TransformError(fault, text)
        return np.array(rows).reshape(4, 4), at

    async def lookup_async(self, target: str, source: str, stamp: Any = None, *,
                           timeout: float | None = None) -> npt.NDArray[np.float64]:
        """As `lookup` in asyncio: other tasks run while it waits. Without `timeout` it waits until the session closes.

        Give it a timeout in a callback of a component, which could not end meanwhile.
        """
        import asyncio

        if timeout is not None:
            check_seconds(timeout, "timeout")
        ready = _hgros.ReadyList()
        self._waits.add(ready)
        pending: _hgros.PendingTransform | None = None
        try:
            pending = self._raw.when_available(target, source, _ns(stamp), ready)
            await asyncio.wait_for(until_woken(ready), timeout)
        except asyncio.TimeoutError:
            pass  # The lookup has the reason.
        finally:
            pending = None
            self._waits.discard(ready)
        return self.lookup(target, source, stamp)

    def send(self, parent: str, child: str, transform: npt.ArrayLike, stamp: Any) -> None:
        """Sets and sends the pose of `child` in `parent` at a time. Raises TransformError if it is refused."""
        if stamp is None:
            raise TypeError("A transform that moves needs a stamp. For one that does not, use send_static.")
        self._send(parent, child, transform, _ns(stamp))

    def send_static(self, parent: str, child: str, transform: npt.ArrayLike) -> None:
        """The same for a pose that never changes; sessions that join later receive it, too."""
        self._send(parent, child, transform, None)

    def _send(self, parent: str, child: str, transform: npt.ArrayLike, stamp_ns: int | None) -> None:
        import numpy as np

        try:
            given = np.asarray(transform)
            fault = "its numbers are complex" if given.dtype.kind == "c" else ""
            matrix = given.real.astype(np.float64)
        except (TypeError, ValueError) as error:
            fault = str(error).rstrip(".")
        fault = fault or _fault(matrix)
        if fault:
            raise TransformError("refused", f'The transform from "{child}" to "{parent}" is no 4x4 matrix of a rotation '
                                 f"and a translation: {fault}.")
        refusal = self._raw.send(parent, child, matrix.flatten().tolist(), stamp_ns)
        if refusal:
            raise TransformError("refused", refusal)

    def restart_edge(self, child: str, latest: Any) -> bool:
        """Call it when the clock that stamped the edge above `child` was set back, and gives no stamp after `latest` now.

        If the edge has later stamps, its next transform that is too old replaces all of them. Returns whether it has.
        An edge that gets only old stamps for 2 s, as when a recording is played again, begins again without it.
        """
        latest_ns = _ns(latest)
        if latest_ns is None:
            raise TypeError("Pass the latest stamp that is possible now.")
        return self._raw.restart_edge(child, latest_ns)

    def flush(self) -> None:
        """Sends transforms that wait to be sent together now."""
        self._raw.flush()

    def _end(self) -> None:
        self._raw.end()
        for ready in list(self._waits):
            ready.end()
