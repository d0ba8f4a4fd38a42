"""From the schemas of channels to classes of Python, and back."""

from __future__ import annotations

import functools
import importlib
import sys
from typing import Any, Callable

from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor import Descriptor, FieldDescriptor, FileDescriptor
from google.protobuf.message import DecodeError, Message

from . import _hgros
from .bulk import BulkMessage
from .errors import Error, TypeMismatch

Decode = Callable[[Any], Any]


def _with_imports(file: FileDescriptor, seen: dict[str, FileDescriptor]) -> None:
    if file.name not in seen:
        for dependency in file.dependencies:
            _with_imports(dependency, seen)
        seen[file.name] = file


def _varint(value: int) -> bytes:
    out = bytearray()
    while value >= 0x80:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


_schemas: dict[type[Message], _hgros.Schema] = {}


def schema_of(message_type: type[Message]) -> _hgros.Schema:
    """The schema with which other sessions know a class that protoc generated."""
    known = _schemas.get(message_type) if isinstance(message_type, type) else None
    if known is None:
        known = _schemas[message_type] = _describe(message_type)
    return known


def _describe(message_type: type[Message]) -> _hgros.Schema:
    descriptor = getattr(message_type, "DESCRIPTOR", None)
    if not isinstance(message_type, type) and isinstance(descriptor, Descriptor):
        raise TypeError(f"The type of the messages is a class, not a message. Give {type(message_type).__name__} "
                        "without brackets.")
    if not isinstance(descriptor, Descriptor):
        raise TypeError(f"{message_type!r} is not a class of messages. Give one that protoc generated, such as "
                        "foxglove.LaserScan_pb2.LaserScan.")
    files: dict[str, FileDescriptor] = {}
    _with_imports(descriptor.file, files)
    # A FileDescriptorSet: each file as field 1.
    parts = [b"\x0a" + _varint(len(file.serialized_pb)) + file.serialized_pb for file in files.values()]
    return _hgros.Schema(descriptor.full_name, b"".join(parts))


def bulk_field(descriptor: Descriptor) -> FieldDescriptor | None:
    """The only singular field of type bytes, which holds the large part of a message."""
    found = [field for field in descriptor.fields
             if field.type == FieldDescriptor.TYPE_BYTES and field.label != FieldDescriptor.LABEL_REPEATED
             and field.containing_oneof is None]
    return found[0] if len(found) == 1 else None


def _known_class(descriptor: Descriptor) -> type[Message] | None:
    """The class that a module of protoc has for it, so that `isinstance` holds."""
    name = descriptor.file.name.removesuffix(".proto").replace("/", ".") + "_pb2"
    if name not in sys.modules and not name.startswith(("foxglove.", "hgros.")):
        return None
    try:
        found: Any = importlib.import_module(name)
        for part in descriptor.full_name.removeprefix(descriptor.file.package + ".").split("."):
            found = getattr(found, part)
    except (ImportError, AttributeError):
        return None
    return found if getattr(found, "DESCRIPTOR", None) is descriptor else None


_built: dict[tuple[str, int], type[Message]] = {}


def class_of(schema: _hgros.Schema) -> type[Message]:
    """The class for a schema: that of this program if it has the same type, or else one that is built from the schema.

    Raises Error if the schema does not describe a protobuf message.
    """
    key = (schema.type_name, schema.fingerprint)
    if key in _built:
        return _built[key]
    made: type[Message] | None = None
    try:
        descriptor = descriptor_pool.Default().FindMessageTypeByName(schema.type_name)
        made = _known_class(descriptor) or message_factory.MessageFactory(
            descriptor_pool.Default()).GetPrototype(descriptor)
        if schema.fingerprint and schema_of(made).fingerprint != schema.fingerprint:
            made = None
    except KeyError:
        pass
    if made is None:
        made = _build(schema)
    _built[key] = made
    return made


def _build(schema: _hgros.Schema) -> type[Message]:
    fault = schema.fault()
    if fault:
        raise Error(f"The messages of type {schema.type_name} cannot be read: {fault} Give the type when subscribing.")
    from google.protobuf import descriptor_pb2

    pool = descriptor_pool.DescriptorPool()
    try:
        for file in descriptor_pb2.FileDescriptorSet.FromString(schema.descriptor_set).file:
            pool.Add(file)
        descriptor = pool.FindMessageTypeByName(schema.type_name)
        return message_factory.MessageFactory(pool).GetPrototype(descriptor)
    except (TypeError, KeyError, DecodeError) as fault_of_pool:
        raise Error(f"The messages of type {schema.type_name} cannot be read: {fault_of_pool}") from fault_of_pool


def made_by(decode: Decode) -> type[Message] | None:
    """The class whose `FromString` it is."""
    owner = getattr(decode, "__self__", None)
    return owner if isinstance(owner, type) and issubclass(owner, Message) else None


def decoder(schema: _hgros.Schema, wanted: type[Message] | None, channel: str) -> Decode:
    """A function from the bytes of one message to the message.

    Raises TypeMismatch if the publisher's type cannot be read as `wanted`.
    """
    if wanted is not None:
        misfit = schema.misfit(schema_of(wanted))
        if misfit:
            raise TypeMismatch(f'Messages on channel "{channel}" are not read: {misfit}. Subscribe with the '
                               "publisher's type, or without one.")
    elif not schema.is_protobuf:
        return memoryview  # The bytes, as they are.
    message_type = wanted if wanted is not None else class_of(schema)
    field = bulk_field(message_type.DESCRIPTOR)
    if field is None:
        return message_type.FromString
    return functools.partial(BulkMessage, message_type, field.number, field.name)
