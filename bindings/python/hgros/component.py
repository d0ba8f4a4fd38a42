"""Components in Python: what the constructor of one gets."""

from __future__ import annotations

import logging
import sys
import threading
from typing import Any, Callable, Generic, TypeVar, overload

from google.protobuf.message import DecodeError, Message

from . import _hgros
from .arguments import check_name, check_queue, check_request, check_seconds
from .bulk import LoanedMessage
from .callbacks import Handler, check_callback
from .errors import Error
from .message_types import Decode, decoder, schema_of
from .parameters import Parameters
from .publisher import Publisher
from .queues import KeepAll, KeepLast, Queue
from .readable import encodable, readable
from .services import Call
from .timers import Tick, period_ns
from .transforms import Transforms

M = TypeVar("M", bound=Message)
Request = TypeVar("Request", bound=Message)
Reply = TypeVar("Reply", bound=Message)
AnyCallback = Callable[[Any, _hgros.MessageInfo], object]
Callback = TypeVar("Callback", bound=AnyCallback)
Turn = TypeVar("Turn", bound=Callable[[Tick], object])
Target = Callable[..., "bytes | None"]

_LEVELS = {logging.DEBUG: 0, logging.INFO: 1, logging.WARNING: 2}


class Client(Generic[Request, Reply]):
    """A service that a component calls; made by `Context.client`."""

    def __init__(self, context: Context, raw: _hgros.Client, reply_type: type[Reply]) -> None:
        self._context = context
        self._raw = raw
        self._name = raw.service
        self._reply_type = reply_type

    def call(self, request: Request, *, timeout: float = 1.0) -> Call[Reply]:
        """Calls the service: `client.call(...).result()`. Errors are raised as CallError by result()."""
        check_request(request, self._name)
        check_seconds(timeout, "timeout")
        data = request.SerializeToString()
        return Call(lambda inbox: self._raw.call(data, timeout, inbox), self._name, self._reply_type,
                    self._context._waits_for_itself(self._name))


class _LogHandler(logging.Handler):
    def __init__(self, raw: _hgros.Context) -> None:
        super().__init__()
        self._raw = raw

    def emit(self, record: logging.LogRecord) -> None:
        try:
            lines = self.format(record).splitlines()
            try:
                for line in lines:
                    self._raw.log(_LEVELS.get(record.levelno, 3), encodable(line))
            except Error:  # The component has ended, or this is a forked child. The process still has its output.
                text = "".join(f"{record.name}: {readable(line)}\n" for line in lines)
                print(text, end="", file=sys.stderr, flush=True)  # In one piece: other threads write, too.
        except Exception:
            self.handleError(record)


class Context:
    """What a component is constructed from: everything it exchanges with the rest of the robot (docs/python.md).

    The component does not know in which process or host it runs, nor what its channels are called there. Its constructor
    advertises, subscribes, serves and declares parameters. Callbacks begin after it, one at a time, on one thread.
    Publish from `activate` and from callbacks: in the constructor the component has no state yet.
    """

    def __init__(self, raw: _hgros.Context) -> None:
        self.name: str = raw.name
        """The component's name in the robot."""
        self.log = logging.Logger(raw.name)
        """Writes lines with the component's name."""
        self.log.addHandler(_LogHandler(raw))
        self._raw = raw
        self._targets: list[Target] = []
        self._handlers: dict[int, Handler] = {}
        self._thread = 0
        self._serving: set[str] = set()  # As the robot calls them.
        self._loaning: dict[str, Publisher[Any]] = {}
        self._params: Parameters | None = None
        self._transforms: Transforms | None = None

    # Publishing.

    def advertise(self, channel: str, message_type: type[M], *, latched: int = 0) -> Publisher[M]:
        """As `Session.advertise`. Call it in the constructor, so that the robot's channels are known before it runs."""
        check_name(channel, "channel")
        return Publisher(self._raw.advertise(channel, schema_of(message_type), int(latched)), channel, message_type)

    def loan(self, channel: str, message_type: type[M], size: int, timeout: float | None = None) -> LoanedMessage[M]:
        """As `Session.loan`, for an advertised channel."""
        publisher = self._loaning.get(channel)
        if publisher is None or publisher.message_type is not message_type:
            publisher = self._loaning[channel] = self.advertise(channel, message_type)
        return publisher.loan(size, timeout)

    # Subscribing.

    @overload
    def subscribe(self, channel: str, message_type: type[M], callback: Callable[[M, _hgros.MessageInfo], object], *,
                  queue: Queue = ..., name: str = ...) -> None: ...
    @overload
    def subscribe(self, channel: str, message_type: None = None, *, callback: AnyCallback, queue: Queue = ...,
                  name: str = ...) -> None: ...
    @overload
    def subscribe(self, channel: str, message_type: type[Message] | None = None, callback: None = None, *,
                  queue: Queue = ..., name: str = ...) -> Callable[[Callback], Callback]: ...
    def subscribe(self, channel: str, message_type: type[Message] | None = None, callback: Any = None, *,
                  queue: Queue = KeepLast(), name: str = "") -> Any:
        """Calls `callback(message, info)` with every message of a channel, until the component ends. Also a decorator.

        Without a type, the type comes with the channel. `name` is that of the node within the component; without one, it
        has the name of the channel. An exception of the callback is logged and counted.
        """
        check_name(channel, "channel")
        check_queue(queue)
        if callback is None:
            def decorate(function: Callback) -> Callback:
                self._subscribe(channel, message_type, function, queue, name)
                return function
            return decorate
        self._subscribe(channel, message_type, callback, queue, name)
        return None

    def _subscribe(self, channel: str, message_type: type[Message] | None, callback: AnyCallback, queue: Queue,
                   name: str) -> None:
        check_callback(callback, 2, f'channel "{channel}"')
        schema = None if message_type is None else schema_of(message_type)
        limit = (queue.limit_bytes or 0) if isinstance(queue, KeepAll) else 0
        last: tuple[_hgros.Schema | None, Decode | None] = (None, None)

        def receive(wire: Any, of: _hgros.Schema | None, info: _hgros.MessageInfo) -> None:
            nonlocal last
            known, decode = last
            if decode is None or of is not known:
                used = schema if of is None else of
                if used is None:
                    raise Error(f'A message on channel "{channel}" has no type.')
                decode = decoder(used, message_type, channel)
                last = of, decode
            try:
                message = decode(wire)
            except DecodeError as fault:
                raise Error(f'A message on channel "{channel}" cannot be read: {fault}') from fault
            callback(message, info)

        self._raw.subscribe(channel, schema, self._add_target(receive), isinstance(queue, KeepAll), queue.depth, limit,
                            name)

    # Services.

    @overload
    def serve(self, name: str, request_type: type[Request], reply_type: type[Reply],
              handler: Callable[[Request], Reply]) -> None: ...
    @overload
    def serve(self, name: str, request_type: type[Request], reply_type: type[Reply],
              ) -> Callable[[Callable[[Request], Reply]], Callable[[Request], Reply]]: ...
    def serve(self, name: str, request_type: Any, reply_type: Any, handler: Any = None) -> Any:
        """As `Session.serve`, until the component ends."""
        if handler is None:
            def decorate(function: Any) -> Any:
                self.serve(name, request_type, reply_type, function)
                return function
            return decorate
        check_callback(handler, 1, f'service "{name}"')
        schema = schema_of(request_type)
        decode = decoder(schema, request_type, name)

        def receive(wire: Any, of: _hgros.Schema | None) -> bytes:
            reply = handler(decode(wire))
            if type(reply) is not reply_type:
                raise TypeError(f'The handler of service "{name}" must return {reply_type.DESCRIPTOR.full_name}, not '
                                f"{type(reply).__name__}.")
            data: bytes = reply.SerializeToString()
            return data

        self._serving.add(self._raw.serve(name, schema, schema_of(reply_type), self._add_target(receive)))
        return None

    def client(self, name: str, request_type: type[Request], reply_type: type[Reply]) -> Client[Request, Reply]:
        """A service that the component calls. Ask for it in the constructor, so that it is known before the robot runs."""
        raw = _hgros.Client(self._raw, name, schema_of(request_type), schema_of(reply_type))
        return Client(self, raw, reply_type)

    # Time.

    @property
    def now_ns(self) -> int:
        """The clock of the robot in ns: that of the simulator, or the system's."""
        return self._raw.now_ns()

    @overload
    def timer(self, period: float, callback: Callable[[Tick], object], *, name: str = ...) -> None: ...
    @overload
    def timer(self, period: float, callback: None = None, *, name: str = ...) -> Callable[[Turn], Turn]: ...
    def timer(self, period: float, callback: Any = None, *, name: str = "timer") -> Any:
        """Calls `callback(tick)` every `period` seconds, from the moment when the robot is ready. Also a decorator."""
        if callback is None:
            def decorate(function: Turn) -> Turn:
                self.timer(period, function, name=name)
                return function
            return decorate
        check_callback(callback, 1, f'timer "{name}"')

        def receive(planned: int, now: int, missed: int) -> None:
            callback(Tick(planned, now, missed))

        self._raw.create_timer(name, period_ns(period), self._add_target(receive))
        return None

    # Parameters and transforms.

    @property
    def params(self) -> Parameters:
        """The parameters of the component. Declare them in the constructor."""
        if self._params is None:
            self._params = Parameters(self, _hgros.Params(self._raw))
        return self._params

    @property
    def transforms(self) -> Transforms:
        """The transforms of the robot. Use it in the constructor: a robot on several hosts passes them between the
        components that have done so."""
        if self._transforms is None:
            self._transforms = Transforms(_hgros.Transforms(self._raw))
        return self._transforms

    # The end.

    def finish(self, result: str = "") -> None:
        """The component's work is done. Only the first `finish` or `fail` counts."""
        self._raw.finish(encodable(result))

    def fail(self, sentence: str) -> None:
        """The component cannot go on, for the reason in `sentence`."""
        self._raw.fail(encodable(sentence))

    def __repr__(self) -> str:
        return f"<hgros.Context {self.name}>"

    def _add_target(self, receive: Target) -> int:
        self._targets.append(receive)
        return len(self._targets) - 1

    def _new_inbox(self) -> tuple[int, _hgros.Inbox]:
        key = len(self._handlers)
        return key, _hgros.Inbox(self._raw.ready, key)

    def _add(self, key: int, handler: Handler) -> None:
        self._handlers[key] = handler
        self._raw.ready.add(key)  # Something may have come before there was a handler.

    def _waits_for_itself(self, service: str) -> bool:
        return service in self._serving and self._thread == threading.get_ident()

    def _end(self) -> None:
        if self._params is not None:
            self._params._raw.end()
        self._targets.clear()
