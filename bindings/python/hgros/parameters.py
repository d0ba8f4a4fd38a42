"""The parameters of a program."""

from __future__ import annotations

import difflib
from typing import Any, Callable, Protocol, Sequence, TypeVar

from . import _hgros
from .arguments import check_name
from .callbacks import Handler, check_callback
from .errors import Error


class _Owner(Protocol):
    """A session or a context."""

    def _new_inbox(self) -> tuple[int, _hgros.Inbox]: ...
    def _add(self, key: int, handler: Handler) -> None: ...


V = TypeVar("V", bool, int, float, str, list[int], list[float], list[str])
Changed = Callable[[list[str]], object]
AnyChanged = TypeVar("AnyChanged", bound=Changed)


def _paths_below(values: Any, above: str = "") -> list[str]:
    if not isinstance(values, dict):
        return [above]
    below = [_paths_below(value, f"{above}.{key}" if above else key) for key, value in values.items()]
    return ([above] if above else []) + [path for paths in below for path in paths]


class ParamError(Error):
    """A change of parameters that was refused; nothing has changed."""


class _Watch(Handler):
    def __init__(self, inbox: _hgros.Inbox, path: str, callback: Changed) -> None:
        super().__init__(inbox, callback, lambda: None)
        self._inbox = inbox
        self._path = path

    def handle_some(self) -> bool:
        for paths in self._inbox.take(16):
            self._run += 1
            try:
                self.callback(paths)
            except Exception:
                self._fails(f'A callback of parameter "{self._path}"')
        return False


class Parameters:
    """Parameters from the session's file and from `HGROS_PARAM_...` of the environment; `Session.params`. Those of a
    component are from the robot file; `Context.params`.

    Other sessions read and set them under the session's name, as with `hgros param`. Bounds are checked for every change,
    wherever it comes from. Made when it is first used.
    """

    def __init__(self, owner: _Owner, raw: _hgros.Params) -> None:
        self._owner = owner
        self._raw = raw

    def declare(self, path: str, default: V, description: str = "", *, unit: str = "", least: float | None = None,
                most: float | None = None, choices: Sequence[str] = (), read_only: bool = False) -> V:
        """Declares a parameter and returns its value: `default` if it was never set.

        From then on it has the default's type and is within the bounds, both included.
        Raises Error if its current value is not, naming where that was set.
        """
        value: V = self._raw.declare(path, default, description, unit, least, most, list(choices), read_only)
        return value

    def get(self, path: str) -> Any:
        """The value, or None if there is none. A map is a dict, a list is a list.

        A declared parameter has its type. Others that are not quoted in YAML are numbers or bools if they look so.
        """
        return self._raw.get(path)

    def __getitem__(self, path: str) -> Any:
        """As get(), but raises ParamError if there is no such parameter."""
        self._require(path)
        return self.get(path)

    def __contains__(self, path: str) -> bool:
        return self._raw.has(path)

    def set(self, path: str, value: Any) -> None:
        """Changes one parameter; None removes it, and a declared one returns to its default. Raises ParamError."""
        self.update({path: value})

    def __setitem__(self, path: str, value: Any) -> None:
        """As set(), but raises ParamError if there is no such parameter."""
        self._require(path)
        self.set(path, value)

    def _require(self, path: str) -> None:
        if path in self:
            return
        near = difflib.get_close_matches(path, _paths_below(self.get("")), 1)
        raise ParamError(f'There is no parameter "{path}". ' +
                         (f'Did you mean "{near[0]}"?' if near else "Declare it first, or create it with set()."))

    def update(self, values: dict[str, Any]) -> None:
        """Changes all of them at once, or none. Raises ParamError with the reason if a value is refused."""
        refusal = self._raw.set(values)
        if refusal:
            raise ParamError(refusal)

    def on_change(self, path: str = "") -> Callable[[AnyChanged], AnyChanged]:
        """A decorator: calls `callback(paths)` after changes at, below or above `path`, as callbacks run."""
        check_name(path, "parameter")

        def decorate(callback: AnyChanged) -> AnyChanged:
            check_callback(callback, 1, f'parameter "{path}"')
            key, inbox = self._owner._new_inbox()
            inbox.keep_last(1024)
            self._raw.watch(path, inbox)
            self._owner._add(key, _Watch(inbox, path, callback))
            return callback

        return decorate

    def save(self) -> None:
        """Writes values that were set at run time into the session's file, and keeps its comments."""
        self._raw.save()
