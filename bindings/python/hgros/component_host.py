"""Runs components of Python in the process that `hgros run` has started. `libhgros_python_components.so` calls it."""

from __future__ import annotations

import difflib
import importlib
import sys
import threading
import traceback
import types
import typing
from typing import Any, NoReturn

from google.protobuf.message import Message

from . import _hgros
from .callbacks import Handler
from .component import Context
from .errors import Error
from .message_types import schema_of
from .readable import encodable, readable, told

_WORK = 0  # The key of the inbox with work; those of a component's parameters come after it.


class _NoType(Error):
    """There is no such class; nothing of the program has raised it."""


class _Worker(Handler):
    """Does what threads of the library wait for."""

    def __init__(self, inbox: _hgros.Inbox) -> None:
        super().__init__(inbox, lambda work: work(), lambda: None)

    def handle_some(self) -> bool:
        for work in self._raw.take(16):
            self.callback(work)
        return False


def serve(ready: _hgros.ReadyList, inbox: _hgros.Inbox) -> NoReturn:
    """Finds classes and begins components, on the thread that has started the interpreter."""
    worker = _Worker(inbox)
    while True:
        for _ in ready.wait(-1.0):
            worker.handle_some()


def _in_program(trace: types.TracebackType | None) -> types.TracebackType | None:
    """The traceback from the first function that does not belong to this package."""
    while trace is not None and (trace.tb_frame.f_globals.get("__package__") in (__package__, "importlib")
                                 or trace.tb_frame.f_code.co_filename.startswith("<frozen importlib")):
        trace = trace.tb_next
    return trace


def _lines(fault: BaseException) -> list[str]:
    trace = _in_program(fault.__traceback__)
    text = "".join(traceback.format_exception(type(fault), fault, trace))
    return [readable(line) for line in text.splitlines()]


def describe(fault: BaseException) -> str:
    """What was raised, and where, in one line."""
    if isinstance(fault, _NoType):
        return encodable(str(fault))
    text = told(fault)
    trace = _in_program(fault.__traceback__)
    if isinstance(fault, SyntaxError) or trace is None:
        return text
    # The last line of the program, not of a library that it calls.
    frames = traceback.extract_tb(trace)
    own = [frame for frame in frames if not frame.filename.startswith(("<", sys.prefix, sys.base_prefix))]
    frame = (own or frames)[-1]
    return f"{text} ({encodable(frame.filename)}:{frame.lineno})"


def _load(name: str) -> type[Any]:
    module_name, _, class_name = name.partition(":")
    if not all([*module_name.split("."), class_name]):
        raise _NoType(f'There is no component type "{name}". Write a module, a colon and the name of a class in it, such '
                      'as "tracker:Tracker".')
    try:
        module: Any = importlib.import_module(module_name)
    except ModuleNotFoundError as fault:
        if fault.name is None or not f"{module_name}.".startswith(f"{fault.name}."):
            raise
        folders = ", ".join(folder for folder in sys.path if folder)
        raise _NoType(f'There is no component type "{name}": Python has no module "{fault.name}". Start the robot in the '
                      f"module's folder, or set PYTHONPATH. Python looks in {folders}.") from None
    found = getattr(module, class_name, None)
    if not isinstance(found, type):
        classes = [one for one, value in vars(module).items() if isinstance(value, type)]
        near = difflib.get_close_matches(class_name, classes, 1)
        raise _NoType(f'There is no component type "{name}": the module {module.__file__} has no class "{class_name}".'
                      + (f' Did you mean "{near[0]}"?' if near else ""))
    return found


def _state_of(component: type[Any], name: str) -> type[Message] | None:
    """The type of messages that `save` returns."""
    saves, restores = hasattr(component, "save"), hasattr(component, "restore")
    if saves != restores:
        has, lacks = ("save", "restore") if saves else ("restore", "save")
        raise _NoType(f'The component type "{name}" has `{has}` and no `{lacks}`. Give it both, or none.')
    if not saves:
        return None
    state = typing.get_type_hints(component.save).get("return")
    if not (isinstance(state, type) and issubclass(state, Message)):
        raise _NoType(f'The component type "{name}" does not say what `save` returns. Write the class of the message '
                      "behind it: `def save(self) -> Pose:`.")
    return state


def find(name: str) -> tuple[bool, _hgros.Schema | None]:
    """Whether the class has `activate` or `deactivate`, and the type of its state."""
    try:
        component = _load(name)
        state = _state_of(component, name)
        activates = hasattr(component, "activate") or hasattr(component, "deactivate")
        return activates, None if state is None else schema_of(state)
    except _NoType:
        raise
    except BaseException as fault:
        print("\n".join(_lines(fault)) + "\n", end="", file=sys.stderr, flush=True)
        raise


class Hosted:
    """One component: its object, and the thread on which all of it runs."""

    def __init__(self, type_name: str, raw: _hgros.Context) -> None:
        self._type = _load(type_name)
        self._state = _state_of(self._type, type_name)
        self._object: Any = None
        self._raw = raw
        self._context = Context(raw)
        self._context._add(_WORK, _Worker(raw.inbox))
        self._ended = False
        threading.Thread(target=self._run, name=f"hgros {raw.name}", daemon=True).start()

    def _run(self) -> None:
        self._raw.settle()
        self._context._thread = threading.get_ident()
        while not self._ended:
            for key in self._raw.ready.wait(-1.0):
                self._context._handlers[key].handle_some()

    def construct(self) -> None:
        try:
            self._object = self._type(self._context)
        except BaseException as fault:  # Nobody has a log yet when it is only tried.
            print("\n".join(_lines(fault)) + "\n", end="", file=sys.stderr, flush=True)
            raise

    def receive(self, target: int, *arguments: Any) -> bytes | None:
        """A message, a request or a tick."""
        try:
            return self._context._targets[target](*arguments)
        except BaseException as fault:
            for line in _lines(fault):
                self._raw.log(3, line)
            raise
        finally:
            _hgros.leave_callback()

    def activate(self) -> None:
        if hasattr(self._object, "activate"):
            self._object.activate()

    def deactivate(self) -> None:
        if hasattr(self._object, "deactivate"):
            self._object.deactivate()

    def save(self) -> bytes:
        state = self._object.save()
        if self._state is None or type(state) is not self._state:
            wanted = "nothing" if self._state is None else self._state.DESCRIPTOR.full_name
            raise TypeError(f"`save` must return {wanted}, not {type(state).__name__}.")
        data: bytes = state.SerializeToString()
        return data

    def restore(self, state: bytes) -> None:
        if self._state is not None:
            self._object.restore(self._state.FromString(state))

    def end(self) -> None:
        self._ended = True
        self._context._end()
        self._object = None
