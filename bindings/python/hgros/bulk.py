"""Messages with one large field, without copies: reading them where they arrived, and writing them in place."""

from __future__ import annotations

import weakref
from types import TracebackType
from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast

from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import DecodeError, Message

from . import _hgros
from .errors import Error, raise_unless_ok
from .log_relay import logger

if TYPE_CHECKING:
    import numpy as np

M = TypeVar("M", bound=Message)

# Publishers have 256 MiB of shared memory if the configuration does not say otherwise.
_warn_at_bytes = 128 << 20


def _warn_about_leases() -> None:
    global _warn_at_bytes
    count, size = _hgros.leases()
    if size < _warn_at_bytes:
        return
    _warn_at_bytes *= 2
    logger.warning("This program keeps %d received messages with %d MiB where they arrived. Publishers run out of "
                   "shared memory at their limit, by default 256 MiB. Copy what you keep, for example with "
                   "numpy.array(hgros.points(cloud)).", count, size >> 20)


_CHANGING = frozenset(("Clear", "ClearExtension", "ClearField", "CopyFrom", "DiscardUnknownFields", "MergeFrom",
                       "MergeFromString", "ParseFromString", "SetInParent", "__setstate__"))
# They need the large field, too.
_OF_WHOLE = frozenset(("FindInitializationErrors", "IsInitialized", "ListFields"))


def _parse(message_type: type[M], wire: bytes | _hgros.Wire) -> M:
    return message_type.FromString(cast(bytes, wire))


def _copied(part: Any) -> Any:
    """Of a value of a field: nothing that changes it changes the message."""
    if not isinstance(part, Message):
        return part
    made = type(part)()
    made.CopyFrom(part)
    return made


class BulkMessage:
    """A received message that has one large field: looks like the class of the message and is read-only.

    The large field is a memoryview of the memory in which the message arrived. That memory is kept while the message, a
    view or an array of it is kept. `hgros.message()` makes an ordinary message of it, with a copy; so do copy, deepcopy
    and pickle. Its submessages are copies, its repeated fields tuples, and its maps dicts.
    """

    __slots__ = ("_data", "_head", "_name", "_number", "_type", "_wire")

    def __init__(self, message_type: type[Message], number: int, name: str, wire: bytes | _hgros.Wire) -> None:
        split = _hgros.split_bulk(wire, number)
        if split is None:
            raise DecodeError("Error parsing message")
        head, begin, size = split
        keep = object.__setattr__
        keep(self, "_type", message_type)
        keep(self, "_number", number)
        keep(self, "_name", name)
        keep(self, "_wire", wire)
        keep(self, "_head", message_type.FromString(head))
        keep(self, "_data", memoryview(cast(bytes, wire))[begin:begin + size])
        if type(wire) is _hgros.Wire:
            _warn_about_leases()

    @property
    def __class__(self) -> Any:
        return self._type

    @__class__.setter
    def __class__(self, value: Any) -> None:
        raise AttributeError("A received message keeps its class.")

    def __getattr__(self, name: str) -> Any:
        if name == self._name:
            return self._data
        field = self._type.DESCRIPTOR.fields_by_name.get(name)
        if field is None:
            if name in _CHANGING:
                raise AttributeError(f"A received message is read-only. Call {name} of hgros.message(...), which is a copy.")
            return getattr(message(self) if name in _OF_WHOLE else self._head, name)
        value = getattr(self._head, name)
        if field.label != FieldDescriptor.LABEL_REPEATED:
            return _copied(value)
        if field.message_type is not None and field.message_type.GetOptions().map_entry:
            return {key: _copied(one) for key, one in value.items()}
        return tuple(map(_copied, value))

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"A received message is read-only. Set {name} in hgros.message(...), which is a copy.")

    def __delattr__(self, name: str) -> None:
        raise AttributeError("A received message is read-only.")

    def __copy__(self) -> Any:
        return message(self)

    def __deepcopy__(self, memo: Any) -> Any:
        return message(self)

    def __reduce_ex__(self, protocol: Any) -> Any:
        return _parse, (self._type, bytes(self._wire))

    def __reduce__(self) -> Any:
        return self.__reduce_ex__(2)

    def __eq__(self, other: object) -> bool:
        return bool(message(self) == message(other))

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"{self._head}{self._name}: {len(self._data)} bytes\n"

    def ByteSize(self) -> int:
        return len(self._wire)

    def SerializeToString(self, *, deterministic: bool = False) -> bytes:
        return cast(bytes, message(self).SerializeToString(deterministic=True)) if deterministic else bytes(self._wire)

    SerializePartialToString = SerializeToString

    def HasField(self, name: str) -> bool:
        return cast(bool, (message(self) if name == self._name else self._head).HasField(name))


class LoanedMessage(Generic[M]):
    """A message to fill in place: looks like the class of the message. Made by `Publisher.loan`.

    Its large field is a writable memoryview. `hgros.points(m)` and `hgros.image(m)` are arrays over it once the other
    fields describe them. It is published at the end of its `with` block, unless that ends with an exception.
    """

    __slots__ = ("_arrays", "_head", "_loan", "_publisher", "_timeout")

    def __init__(self, publisher: Any, size: int, timeout: float | None) -> None:
        keep = object.__setattr__
        keep(self, "_publisher", publisher)
        keep(self, "_head", publisher.message_type())
        keep(self, "_loan", publisher._raw.loan(size))
        keep(self, "_timeout", timeout)
        keep(self, "_arrays", [])

    def __enter__(self) -> M:
        return cast(M, self)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        for array in self._arrays:
            if (alive := array()) is not None:
                alive.flags.writeable = False
        if kind is not None:
            return
        publisher = self._publisher
        field = publisher.bulk_field
        if len(getattr(self._head, field.name)) > 0:
            raise Error(f"The loan for channel {publisher.channel} has its bytes twice. Leave {field.name} of the "
                        "message empty, and write into the loan.")
        status = self._loan.publish(publisher._raw, self._head.SerializeToString(), field.number, self._timeout)
        raise_unless_ok(status, publisher.channel)

    def __getattr__(self, name: str) -> Any:
        return memoryview(self._loan) if name == self._publisher.bulk_field.name else getattr(self._head, name)

    def __setattr__(self, name: str, value: Any) -> None:
        if name == self._publisher.bulk_field.name:
            whole = memoryview(self._loan)
            given = memoryview(value)
            if given.format in ("Zf", "Zd"):
                raise Error(f"What is written into {name} of the loan has complex numbers. Give its real part.")
            if given.nbytes != len(whole):
                raise Error(f"The loan has {len(whole)} bytes, and what is written into its {name} has {given.nbytes}. Give "
                            "the loan its size.")
            whole[:] = given if given.format == "B" and given.ndim == 1 and given.contiguous else given.tobytes()
        else:
            setattr(self._head, name, value)

    def __repr__(self) -> str:
        return f"{self._head}{self._publisher.bulk_field.name}: {len(memoryview(self._loan))} bytes\n"


def message(received: Any) -> Any:
    """An ordinary protobuf message of a received one: a copy if that is still where it arrived."""
    if type(received) is not BulkMessage:
        return received
    return _parse(received._type, received._wire)


def _check_type(given: Any, type_name: str) -> None:
    """Raises TypeError if it is no such message."""
    of = getattr(given._head if type(given) is LoanedMessage else given, "DESCRIPTOR", None)
    if of is None or of.full_name != type_name or isinstance(given, type):
        name = type(given).__name__ if of is None else of.full_name
        if isinstance(given, type) and of is not None:
            name = f"the class {given.__name__}"
        raise TypeError(f"This is for messages of {type_name}, not {name}.")


def data(bulk: Any) -> memoryview:
    """The large field, as `points` and `image` see it: read-only if the message was received, writable in a loan."""
    if type(bulk) is BulkMessage:
        return cast(memoryview, bulk._data)
    if type(bulk) is LoanedMessage:
        return memoryview(bulk._loan)
    return memoryview(bulk.data)


def _array_over(bulk: Any, array: Any) -> Any:
    if type(bulk) is LoanedMessage:
        bulk._arrays.append(weakref.ref(array))
    return array


# By PackedElementField.NumericType.
_FORMATS = (None, "u1", "i1", "<u2", "<i2", "<u4", "<i4", "<f4", "<f8")


def points(cloud: Any) -> np.ndarray[Any, Any]:
    """The points of a foxglove.PointCloud as a structured array over its bytes: `hgros.points(cloud)["x"]`.

    The array of a received cloud is read-only and may be kept; it keeps the memory in which the cloud arrived. In a loan
    it is writable until the loan is published.
    Raises Error if the fields do not fit the stride or the bytes.
    """
    import numpy as np

    _check_type(cloud, "foxglove.PointCloud")
    described = cloud._head if type(cloud) is BulkMessage else cloud  # Without copies.
    stride = described.point_stride
    names: list[str] = []
    formats: list[str] = []
    offsets: list[int] = []
    for field in described.fields:
        known = _FORMATS[field.type] if 0 <= field.type < len(_FORMATS) else None
        if known is None:
            raise Error(f'Field "{field.name}" of the cloud has the unknown type {field.type}.')
        if field.name in names or not field.name:
            raise Error(f'The cloud has two fields "{field.name}", or one without a name.')
        if field.offset + np.dtype(known).itemsize > stride:
            raise Error(f'Field "{field.name}" of the cloud ends after the stride of {stride} bytes.')
        names.append(field.name)
        formats.append(known)
        offsets.append(field.offset)
    if not names or stride == 0:
        raise Error("The cloud describes no points: it has no fields, or a stride of 0.")
    view = data(cloud)
    if len(view) % stride:
        raise Error(f"The {len(view)} bytes of the cloud are no multiple of its stride of {stride}.")
    dtype = np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": stride})
    return cast("np.ndarray[Any, Any]", _array_over(bulk=cloud, array=np.frombuffer(view, dtype)))


# Encoding: format and samples of a pixel.
_ENCODINGS: dict[str, tuple[str, int]] = {
    "mono8": ("u1", 1), "8UC1": ("u1", 1), "8UC2": ("u1", 2), "8UC3": ("u1", 3), "8UC4": ("u1", 4),
    "mono16": ("<u2", 1), "16UC1": ("<u2", 1), "16UC3": ("<u2", 3), "32FC1": ("<f4", 1), "64FC1": ("<f8", 1),
    "rgb8": ("u1", 3), "bgr8": ("u1", 3), "rgba8": ("u1", 4), "bgra8": ("u1", 4), "yuyv": ("u1", 2), "yuv422": ("u1", 2),
    "uyvy": ("u1", 2), "yuv422_yuy2": ("u1", 2),
    "bayer_rggb8": ("u1", 1), "bayer_bggr8": ("u1", 1), "bayer_gbrg8": ("u1", 1), "bayer_grbg8": ("u1", 1),
    "bayer_rggb16": ("<u2", 1), "bayer_bggr16": ("<u2", 1), "bayer_gbrg16": ("<u2", 1), "bayer_grbg16": ("<u2", 1),
    "rgb16": ("<u2", 3), "nv12": ("u1", 1),
}


def image(raw: Any) -> np.ndarray[Any, Any]:
    """The pixels of a foxglove.RawImage as an array over its bytes: rows, columns and, if there are several, samples.

    Of nv12, the rows of brightness are followed by half as many of color (U and V in turns), as OpenCV has it. It may be
    kept, as that of `points`. Raises Error if the encoding is unknown or the bytes do not fit.
    """
    import numpy as np

    _check_type(raw, "foxglove.RawImage")
    if raw.encoding not in _ENCODINGS:
        raise Error(f'The encoding "{raw.encoding}" of the image is unknown. Known are {", ".join(_ENCODINGS)}.')
    format_, samples = _ENCODINGS[raw.encoding]
    item = np.dtype(format_).itemsize
    width, height, step = raw.width, raw.height, raw.step
    if raw.encoding == "nv12":
        if width % 2:
            raise Error(f"An nv12 image has an even width, not {width}: U and V belong to two pixels.")
        height += (height + 1) // 2
    view = data(raw)
    if step < width * samples * item:
        raise Error(f"A row of the image has {width * samples * item} bytes, more than its step of {step}.")
    if step * height > len(view):
        raise Error(f"The image has {len(view)} bytes, fewer than {height} rows of {step}.")
    flat = np.frombuffer(view, np.uint8, step * height)
    dimensions = 2 if samples == 1 else 3
    found: Any = np.ndarray((height, width, samples)[:dimensions], np.dtype(format_), buffer=flat,
                            strides=(step, samples * item, item)[:dimensions])
    return cast("np.ndarray[Any, Any]", _array_over(raw, found))
