"""The session: what a program of Python has of the robot."""

from __future__ import annotations

import atexit
import contextlib
import os
import pathlib
import sys
import threading
import time
import weakref
from types import TracebackType
from typing import Any, Callable, Iterable, TypeVar, overload

from google.protobuf.message import Message

from . import _hgros
from .arguments import check_name, check_queue, check_request, check_seconds
from .bulk import LoanedMessage
from .callbacks import Handler, check_callback
from .errors import Error
from .log_relay import LogRelay, logger
from .message_types import schema_of
from .parameters import Parameters
from .publisher import Publisher
from .queues import KeepAll, KeepLast, Queue
from .readable import readable
from .services import Call, Service
from .snapshot import KnownChannel, SessionSnapshot, snapshot_of
from .stream import Messages
from .subscription import AnyCallback, Known, Reader, Subscription
from .timers import NamelessTimer, NamelessTimers, Rate, Tick, Timer, period_ns
from .transforms import Transforms

M = TypeVar("M", bound=Message)
Request = TypeVar("Request", bound=Message)
Reply = TypeVar("Reply", bound=Message)
Turn = TypeVar("Turn", bound=Callable[[Tick], object])
Callback = TypeVar("Callback", bound=AnyCallback)

# Of a callback at the end of the interpreter.
_LONGEST_CALLBACK_AT_EXIT_S = 5.0

_relay: LogRelay | None = None
_sessions: weakref.WeakSet[Session] = weakref.WeakSet()
_setup = threading.Lock()


def _log_inbox() -> _hgros.Inbox:
    global _relay
    with _setup:
        if _relay is None:
            _relay = LogRelay()
        return _relay.inbox


def _program() -> str:
    return pathlib.PurePath(sys.argv[0] if sys.argv else "").stem.removeprefix("-c") or "python"


class Session:
    """One participant of the robot's hypergraph.

    `file` is a configuration (docs/configuration.md), `text` the same as YAML; without either the session has that of
    the variable HGROS_CONFIG, which `hgros run` gives to programs, or the default. `sections` are top-level keys of
    the file that belong to the program. Any thread may use it.

    Callbacks run on the thread that calls `spin`, on the thread that `start` makes, or in asyncio with `spin_async`;
    never on a thread of the library. Close it, best with a `with` block; at the end of the program it is closed.
    Raises ConfigError naming file, line and column if the configuration cannot be used.
    """

    def __init__(self, file: str | os.PathLike[str] | None = None, *, text: str | None = None, name: str | None = None,
                 sections: Iterable[str] = ()) -> None:
        if file is not None and text is not None:
            raise ValueError("Give a file or a text, not both.")
        self._native = _hgros.Session(None if file is None else os.fspath(file), text, list(sections),
                                      _program() if name is None else name, _log_inbox())
        self._id, self._name = self._native.id, self._native.name
        self._ready = _hgros.ReadyList(self._native)
        self._handlers: dict[int, Handler] = {}
        self._known: dict[int, Known] = {}  # What the library calls without a line of Python in between.
        self._streams: weakref.WeakSet[Messages[Any] | Rate] = weakref.WeakSet()
        self._file = None if file is None else os.fspath(file)
        self._params: Parameters | None = None
        self._transforms: Transforms | None = None
        self._serving: set[str] = set()
        self._spinner: int | None = None
        self._loaning: dict[str, Publisher[Any]] = {}
        self._next_key = 0
        self._nameless = NamelessTimers()
        self._lock = threading.RLock()
        self._spins = threading.Lock()
        self._stops = 0
        self._thread: threading.Thread | None = None
        self._closes = threading.RLock()
        self._closing = False
        self._closed = False
        with _setup:
            _sessions.add(self)

    # Life.

    @property
    def id(self) -> str:
        self._use()
        return self._id

    @property
    def name(self) -> str:
        self._use()
        return self._name

    @property
    def closed(self) -> bool:
        return self._closing or self._native.of_parent

    def close(self) -> None:
        """Ends the session: no callback begins any more, and what was published is sent. May be called in a callback."""
        self._close(None)

    def _close(self, longest_wait_s: float | None) -> None:
        if self._native.of_parent:
            return
        self._closing = True
        self._ready.end()
        # A callback does not wait for a close() that waits for the callback.
        if not self._closes.acquire(blocking=self._spinner != threading.get_ident()):
            return
        try:
            if self._closed:
                return
            # Every step is done, also after an exception such as KeyboardInterrupt. The last one is done first.
            with contextlib.ExitStack() as steps:
                steps.callback(self._native.close)
                handlers = list(self._handlers.values())
                for service in (one for one in handlers if isinstance(one, Service)):
                    steps.callback(service.end)  # After the callback that runs: it may be about to reply.
                steps.callback(self._join, longest_wait_s)
                if self._transforms is not None:
                    steps.callback(self._transforms._end)
                if self._params is not None:
                    steps.callback(self._params._raw.end)
                for part in [*self._streams, *(one for one in handlers if not isinstance(one, Service))]:
                    steps.callback(part.close if isinstance(part, (Messages, Rate)) else part.end)
            self._closed = True
        finally:
            self._closes.release()

    def _join(self, longest_wait_s: float | None) -> None:
        # After everything but services has ended for which a callback may wait.
        with self._lock:
            thread = self._thread
        if thread is None or thread is threading.current_thread():
            return
        thread.join(longest_wait_s)
        if thread.is_alive():
            logger.warning('A callback of session "%s" still runs after %g s. The program ends without it.', self.name,
                           longest_wait_s)

    def __enter__(self) -> Session:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def __del__(self) -> None:
        if hasattr(self, "_closed"):
            self.close()

    def _use(self) -> _hgros.Session:
        # First in each function: in a forked child, locks may never be released.
        self._native.refuse_in_child()
        return self._native

    # Parameters, transforms, counters.

    @property
    def params(self) -> Parameters:
        """The parameters of the program."""
        native = self._use()
        with self._lock:
            if self._params is None:
                self._params = Parameters(self, _hgros.Params(native, self._file))
            return self._params

    @property
    def transforms(self) -> Transforms:
        """The transforms of all sessions."""
        native = self._use()
        with self._lock:
            if self._transforms is None:
                self._transforms = Transforms(_hgros.Transforms(native))
            return self._transforms

    def snapshot(self) -> SessionSnapshot:
        """All counters of the session."""
        return snapshot_of(_hgros.snapshot(self._use()))

    def channels(self) -> list[KnownChannel]:
        """All channels that this session knows, also those of other sessions, sorted by name."""
        return [KnownChannel(**one) for one in _hgros.channels(self._use())]

    # Publishing.

    def advertise(self, channel: str, message_type: type[M], *, latched: int = 0) -> Publisher[M]:
        """Announces a channel. The last `latched` messages are kept for late subscribers.

        Raises TypeMismatch if the channel has another type in this session.
        """
        check_name(channel, "channel")
        raw = self._use().advertise(channel, schema_of(message_type), int(latched))
        return Publisher(raw, channel, message_type)

    def loan(self, channel: str, message_type: type[M], size: int, timeout: float | None = None) -> LoanedMessage[M]:
        """A message to fill in place and publish; see `Publisher.loan`."""
        publisher = self._loaning.get(channel)
        if publisher is None or publisher.message_type is not message_type:
            publisher = self._loaning[channel] = self.advertise(channel, message_type)
        return publisher.loan(size, timeout)

    def wait_for_subscribers(self, channel: str, count: int = 1, timeout: float = 5.0) -> bool:
        """Waits until a channel that this session advertises has subscribers. False if the timeout came first."""
        check_name(channel, "channel")
        native = self._use()
        return self._wait_in_slices(lambda part: native.wait_for_subscribers(channel, count, part), timeout)

    def wait_for_publishers(self, channel: str, count: int = 1, timeout: float = 5.0) -> bool:
        """Waits until other sessions that publish on the channel are connected. False if the timeout came first."""
        check_name(channel, "channel")
        native = self._use()
        return self._wait_in_slices(lambda part: native.wait_for_publishers(channel, count, part), timeout)

    def wait_for_service(self, name: str, timeout: float = 5.0) -> bool:
        """Waits until this session serves `name`, or knows another one that does: a call finds it then.

        False if the timeout came first.
        """
        check_name(name, "service")
        native = self._use()
        return self._wait_in_slices(lambda part: native.wait_for_service(name, part), timeout)

    @staticmethod
    def _wait_in_slices(wait: Callable[[float], bool], timeout: float) -> bool:
        check_seconds(timeout, "timeout")
        # No signal ends the library's wait. Between two parts of it Python handles signals.
        part = 0.05
        while timeout > part:
            if wait(part):
                return True
            timeout -= part
        return wait(max(timeout, 0.0))

    # Subscribing.

    @overload
    def subscribe(self, channel: str, message_type: type[M], callback: Callable[[M, _hgros.MessageInfo], object], *,
                  queue: Queue = ..., name: str = ...) -> Subscription: ...
    @overload
    def subscribe(self, channel: str, message_type: None = None, *, callback: AnyCallback, queue: Queue = ...,
                  name: str = ...) -> Subscription: ...
    @overload
    def subscribe(self, channel: str, message_type: type[Message] | None = None, callback: None = None, *,
                  queue: Queue = ..., name: str = ...) -> Callable[[Callback], Callback]: ...
    def subscribe(self, channel: str, message_type: type[Message] | None = None, callback: Any = None, *,
                  queue: Queue = KeepLast(), name: str = "") -> Any:
        """Calls `callback(message, info)` with every message of a channel.

        Without a type, the type comes with the channel. Raises TypeMismatch if the channel has another type in this
        session. As a decorator it returns the function, and `subscriptions` has
        the subscription. An exception of the callback is logged with its traceback and counted; the next message is
        handled.
        """
        check_name(channel, "channel")
        check_queue(queue)
        if message_type is not None:
            if not isinstance(message_type, type) and callable(message_type):
                raise TypeError(f'The second argument is the type of the messages. Without one, write '
                                f'robot.subscribe("{readable(channel)}", callback=...).')
            schema_of(message_type)  # A wrong type is an error here, and not when the function is decorated.
        if callback is None:
            def decorate(function: Callback) -> Callback:
                self._subscribe(channel, message_type, function, queue, name)
                return function
            return decorate
        return self._subscribe(channel, message_type, callback, queue, name)

    def subscriptions(self, channel: str | None = None) -> list[Subscription]:
        """The subscriptions with callbacks that have not ended, of one channel or of all, the oldest first."""
        self._use()
        return [one for one in list(self._handlers.values())
                if isinstance(one, Subscription) and channel in (None, one.channel)]

    def _subscribe(self, channel: str, wanted: type[Message] | None, callback: AnyCallback, queue: Queue,
                   name: str) -> Subscription:
        check_callback(callback, 2, f'channel "{channel}"')
        key, inbox = self._new_inbox()
        raw = self._open(channel, wanted, inbox, queue, name)
        subscription = Subscription(raw, Reader(self._use(), inbox, channel, wanted), callback, lambda: self._forget(key),
                                    lambda known: self._know(key, known))
        self._add(key, subscription)
        return subscription

    def _new_key(self) -> int:
        self._use()
        with self._lock:
            key = self._next_key
            self._next_key += 1
        return key

    def _new_inbox(self) -> tuple[int, _hgros.Inbox]:
        key = self._new_key()
        return key, _hgros.Inbox(self._ready, key)

    def _add(self, key: int, handler: Handler) -> None:
        self._handlers[key] = handler
        self._ready.add(key)  # Something may have come before there was a handler.

    def _keep(self, stream: Messages[Any] | Rate) -> None:
        self._streams.add(stream)
        if self._closing:  # Another thread closes the session, and may have looked for streams before.
            stream.close()

    def _forget(self, key: int) -> None:
        self._handlers.pop(key, None)
        self._known.pop(key, None)

    def _know(self, key: int, known: Known | None) -> None:
        if known is not None:
            self._known[key] = known
        if known is None or key not in self._handlers:  # Another thread may have ended it meanwhile.
            self._known.pop(key, None)

    def _open(self, channel: str, wanted: type[Message] | None, inbox: _hgros.Inbox, queue: Queue,
              name: str) -> _hgros.Subscription:
        schema = None if wanted is None else schema_of(wanted)
        limit = (queue.limit_bytes or 0) if isinstance(queue, KeepAll) else 0
        return self._use().subscribe(channel, inbox, isinstance(queue, KeepAll), queue.depth, limit, name, schema)

    @overload
    def messages(self, channel: str, message_type: type[M], *, timeout: float | None = ..., queue: Queue = ...,
                 name: str = ...) -> Messages[M]: ...
    @overload
    def messages(self, channel: str, message_type: None = None, *, timeout: float | None = ..., queue: Queue = ...,
                 name: str = ...) -> Messages[Any]: ...
    def messages(self, channel: str, message_type: type[Message] | None = None, *, timeout: float | None = None,
                 queue: Queue = KeepLast(), name: str = "") -> Messages[Any]:
        """The messages of a channel for `for` and `async for`, from now on.

        The loop ends when no message comes for `timeout` seconds. It needs no `spin`, and calls no callbacks.
        """
        check_name(channel, "channel")
        check_queue(queue)
        if timeout is not None:
            check_seconds(timeout, "timeout")
        ready = _hgros.ReadyList(self._use())
        inbox = _hgros.Inbox(ready, 0)
        raw = self._open(channel, message_type, inbox, queue, name)
        stream: Messages[Any] = Messages(raw, ready, Reader(self._use(), inbox, channel, message_type), timeout)
        self._keep(stream)
        return stream

    # Services.

    @overload
    def call(self, name: str, request: Message, reply_type: type[Reply], *, timeout: float = ...) -> Call[Reply]: ...
    @overload
    def call(self, name: str, request: Message, reply_type: None = None, *, timeout: float = ...) -> Call[Any]: ...
    def call(self, name: str, request: Message, reply_type: type[Message] | None = None, *,
             timeout: float = 1.0) -> Call[Any]:
        """Calls a service: `robot.call(...).result()`, or `await robot.call(...)`.

        Without a type of the reply, it is that of the server. Errors are raised as CallError by result() and await.
        """
        check_name(name, "service")
        check_request(request, name)
        check_seconds(timeout, "timeout")
        deadlocks = name in self._serving and self._spinner == threading.get_ident()
        native, schema, data = self._use(), schema_of(type(request)), request.SerializeToString()
        reply = None if reply_type is None else schema_of(reply_type)
        return Call(lambda inbox: _hgros.call(native, name, schema, data, reply, timeout, inbox), name, reply_type,
                    deadlocks)

    @overload
    def serve(self, name: str, request_type: type[Request], reply_type: type[Reply],
              handler: Callable[[Request], Reply]) -> Service: ...
    @overload
    def serve(self, name: str, request_type: type[Request], reply_type: type[Reply],
              ) -> Callable[[Callable[[Request], Reply]], Callable[[Request], Reply]]: ...
    def serve(self, name: str, request_type: Any, reply_type: Any, handler: Any = None) -> Any:
        """Offers a service: `handler(request)` returns the reply, and runs as callbacks do. Also a decorator.

        If the handler raises an exception, that is logged, and the caller gets it as CallError "handler failed".
        """
        check_name(name, "service")
        if handler is None:
            def decorate(function: Any) -> Any:
                self.serve(name, request_type, reply_type, function)
                return function
            return decorate
        check_callback(handler, 1, f'service "{name}"')
        key, inbox = self._new_inbox()
        raw = _hgros.serve(self._use(), name, schema_of(request_type), schema_of(reply_type), inbox)
        self._serving.add(name)

        def forget() -> None:
            self._serving.discard(name)
            self._forget(key)

        service = Service(raw, inbox, name, request_type, reply_type, handler, forget)
        self._add(key, service)
        return service

    # Time.

    @property
    def now_ns(self) -> int:
        """The session's clock in ns: with `time: simulated` that of the simulator, else the system's."""
        return self._use().now_ns()

    @overload
    def timer(self, period: float, callback: Callable[[Tick], object], *, name: str = ...) -> Timer: ...
    @overload
    def timer(self, period: float, callback: None = None, *, name: str = ...) -> Callable[[Turn], Turn]: ...
    def timer(self, period: float, callback: Any = None, *, name: str = "") -> Any:
        """Calls `callback(tick)` every `period` seconds of the session's clock, as callbacks run. Also a decorator.

        Turns that come while callbacks run are skipped and counted in `Tick.missed`.
        """
        period_ns(period)  # A wrong one is an error here, and not when the function is decorated.
        if callback is None:
            def decorate(function: Turn) -> Turn:
                self.timer(period, function, name=name)
                return function
            return decorate
        check_callback(callback, 1, "a timer")
        key, inbox = self._new_inbox()
        inbox.keep_last(1)
        raw: _hgros.Timer | NamelessTimer
        if name:
            raw = _hgros.create_timer(self._use(), name, period_ns(period), inbox)
        else:
            raw = self._nameless.open(self._use(), period_ns(period), inbox)
            name = raw.name
        timer = Timer(raw, inbox, name, callback, lambda: self._forget(key))
        self._add(key, timer)
        return timer

    def rate(self, period: float) -> Rate:
        """For a loop that runs every `period` seconds of the session's clock: `for tick in robot.rate(0.1)`."""
        ready = _hgros.ReadyList()
        inbox = _hgros.Inbox(ready, 0)
        inbox.keep_last(1)
        rate = Rate(self._nameless.open(self._use(), period_ns(period), inbox), inbox, ready)
        self._keep(rate)
        return rate

    def sleep(self, seconds: float) -> None:
        """Sleeps on the session's clock. Raises Error if the session is closed meanwhile."""
        check_seconds(seconds, "sleep")
        if seconds > 0:
            rate = self.rate(seconds)
            try:
                rate.sleep()
            finally:
                rate.close()

    # Running callbacks.

    def spin(self) -> None:
        """Runs callbacks on this thread until `stop` or `close` is called, or Ctrl-C is pressed (KeyboardInterrupt)."""
        self._spin(self._stops)

    def _spin(self, stops: int) -> None:
        with self._Spinning(self):
            self._run(stops)

    def _run(self, stops: int) -> None:
        self._ready.prepare()
        try:
            self._ring_all()
            while not self.closed and self._stops == stops:
                self._handle(*self._ready.run(self._known, -1.0, False))
        finally:
            self._ready.relax()

    def _spin_beside(self, spinning: _Spinning, stops: int) -> None:
        try:
            self._spinner = threading.get_ident()
            try:
                self._run(stops)
            finally:
                spinning.__exit__()
        except BaseException as fault:  # Python lets sys.exit() end this thread alone, without a word.
            if isinstance(fault, Exception):
                raise
            what = "called sys.exit()" if isinstance(fault, SystemExit) else f"raised {type(fault).__name__}"
            logger.exception('A callback %s on the thread of start(), which has ended. Callbacks of session "%s" run again '
                             "after start() or spin(). To end the program, let the callback tell its main thread.", what,
                             self.name)

    def spin_once(self, timeout: float = 0.0) -> bool:
        """Waits at most `timeout` seconds until callbacks can run, and runs those. Returns whether any callback ran.

        `stop` and `close` end the wait.
        """
        with self._Spinning(self) as stops:
            deadline = time.monotonic() + max(timeout, 0.0)
            self._ring_all()
            while not self.closed:
                if self._handle(*self._ready.run(self._known, max(deadline - time.monotonic(), 0.0), True)):
                    return True
                if self._stops != stops or time.monotonic() >= deadline:
                    break
            return False

    def start(self) -> None:
        """Runs callbacks on a thread of their own until `stop` or `close`; for notebooks and interactive use.

        Raises Error if another thread runs them.
        """
        self._use()
        with self._lock:
            if self._thread is not None and self._thread.is_alive():
                return
            spinning = self._Spinning(self)
            stops = spinning.__enter__()
            self._spinner = None  # The thread sets it to itself.
            self._thread = threading.Thread(target=self._spin_beside, args=(spinning, stops), name=f"hgros {self.name}",
                                            daemon=True)
            try:
                self._thread.start()
            except BaseException:
                if self._thread.ident is None:  # No thread has begun. Ctrl-C may also come when one has.
                    self._thread = None
                    spinning.__exit__()
                raise

    def stop(self) -> None:
        """Lets `spin`, `start` or `spin_async` end after the callback that runs. It can be called again after that.

        Waits for the thread of `start`, except in its callbacks.
        """
        self._use()
        with self._lock:
            self._stops += 1
            thread = self._thread
        self._ready.wake()
        if thread is not None and thread is not threading.current_thread():
            thread.join()

    async def spin_async(self) -> None:
        """Runs callbacks in the running event loop of asyncio until `stop` or `close`."""
        import asyncio

        with self._Spinning(self) as stops:
            loop = asyncio.get_running_loop()
            woken = asyncio.Event()
            descriptor = self._ready.fileno()
            loop.add_reader(descriptor, woken.set)
            try:
                self._ring_all()
                while not self.closed and self._stops == stops:
                    await woken.wait()
                    self._handle(0, self._ready.take(), None, None)
                    woken.clear()
            finally:
                loop.remove_reader(descriptor)

    class _Spinning:
        """One spin at a time: callbacks do not run at the same time as others."""

        def __init__(self, session: Session) -> None:
            self._session = session

        def __enter__(self) -> int:
            self._session._use()
            stops = self._session._stops  # A stop() from here on ends the spin.
            if not self._session._spins.acquire(blocking=False):
                raise Error("The session spins already. Only one of spin, spin_once, start and spin_async runs at a "
                            "time, and not inside a callback.")
            self._session._spinner = threading.get_ident()
            return stops

        def __exit__(self, *error: Any) -> None:
            self._session._spinner = None
            self._session._spins.release()

    def _ring_all(self) -> None:
        # A signal may have ended the spin before this one after it had taken keys, and before it handled them.
        for key in list(self._handlers):
            self._ready.add(key)

    def _handle(self, ran: int, keys: list[int], failed: Subscription | None, fault: BaseException | None) -> int:
        # Returns how many callbacks ran, with the `ran` before.
        keys.reverse()
        key = -1
        more = False
        try:
            if failed is not None and fault is not None:
                faults, fault = [fault], None  # A frame that keeps an exception would keep itself, and the message.
                self._take_fault(failed, faults)
            while keys and not self.closed:
                key = keys.pop()
                handler = self._handlers.get(key)
                if handler is None:
                    continue
                more = True
                before = handler.run
                more = handler.handle_some()
                ran += handler.run - before
                if more:
                    self._ready.add(key)
                    more = False
        finally:
            # After KeyboardInterrupt, what was not handled waits for the next spin.
            if more:
                keys.append(key)
            for left in reversed(keys):
                self._ready.add(left)
        return ran

    @staticmethod
    def _take_fault(failed: Subscription, faults: list[BaseException]) -> None:
        try:
            raise faults.pop()
        except BaseException:
            failed.take_fault()

    def __repr__(self) -> str:
        return f"<hgros.Session {'closed' if self.closed else self.name}>"


def _close_all() -> None:
    global _relay
    for session in list(_sessions):
        try:
            session._close(_LONGEST_CALLBACK_AT_EXIT_S)
        except BaseException:
            logger.exception("A session could not be closed.")
    with _setup:
        relay, _relay = _relay, None
    if relay is not None:
        relay.end()


def _after_fork_in_child() -> None:
    # The parent's sessions and their parts know by themselves that they are not used or destroyed here.
    global _relay, _sessions, _setup
    _relay, _sessions, _setup = None, weakref.WeakSet(), threading.Lock()


atexit.register(_close_all)
os.register_at_fork(after_in_child=_after_fork_in_child)
