"""Packets of the wire protocol, written after docs/wire-protocol.md alone: the names are those of the page."""

import struct

SEPARATOR = 0x2424
VERSION = 1 * 65536 + 3
PROTOBUF, CUSTOM, PLAIN = 1, 2, 3
MASK = (1 << 64) - 1

VARINT, FIXED64, BYTES, GROUP, END_OF_GROUP, FIXED32 = range(6)

# hgros.wire.Head: number to name and type.
HEAD = {1: ("version", "fixed32"), 2: ("channel", "string"), 4: ("type", "string"), 5: ("encoding", "enum"),
        6: ("fingerprint", "fixed64"), 7: ("publisher_id", "fixed64"), 8: ("incarnation", "fixed64"),
        9: ("sequence", "uint64"), 10: ("publish_time_ns", "sfixed64"), 11: ("publish_monotonic_ns", "sfixed64"),
        12: ("latched", "uint32"), 13: ("cause", "fixed64"), 14: ("chain_age_ns", "uint64"),
        15: ("chain_origin", "fixed32"), 16: ("unsent", "sint64")}
WIRE_TYPES = {"fixed32": FIXED32, "fixed64": FIXED64, "sfixed64": FIXED64, "double": FIXED64, "string": BYTES,
              "bytes": BYTES, "enum": VARINT, "uint32": VARINT, "uint64": VARINT, "sint64": VARINT}

# The readers of the vectors and of the robot's messages: number to name and type.
TYPES = {"foxglove.Vector3": {1: ("x", "double"), 2: ("y", "double"), 3: ("z", "double")},
         "foxglove.Quaternion": {1: ("x", "double"), 2: ("y", "double"), 3: ("z", "double"), 4: ("w", "double")},
         "foxglove.Log": {3: ("message", "string")},
         "foxglove.PointCloud": {2: ("frame_id", "string"), 4: ("point_stride", "fixed32"), 6: ("data", "bytes")},
         "hgros.SimulatedTime": {}, "hgros.ParamsState": {}, "hgros.Snapshot": {}, "hgros.Trace": {}}


class Fault(Exception):
    """A packet that a receiver drops; the text is the fault's name."""


class Malformed(Exception):
    """Bytes that are not protobuf."""


# Protobuf.


def read_varint(data, at):
    value = 0
    for shift in range(0, 70, 7):
        if at >= len(data):
            raise Malformed
        byte = data[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value & MASK, at
    raise Malformed


def write_varint(value):
    out = bytearray()
    while value >= 0x80:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def read_fields(data):
    """Yields (number, wire type, value) of each field; the value of a group is its bytes with the end."""
    at = 0
    while at < len(data):
        number, wire_type, value, at = read_field(data, at)
        if wire_type == END_OF_GROUP:
            raise Malformed
        yield number, wire_type, value


def read_field(data, at):
    tag, at = read_varint(data, at)
    number, wire_type = tag >> 3, tag & 7
    if number == 0 or tag >= 1 << 32:
        raise Malformed
    begin = at
    if wire_type == VARINT:
        value, at = read_varint(data, at)
    elif wire_type == GROUP:
        inner = None
        while inner != END_OF_GROUP:
            inner_number, inner, _, at = read_field(data, at)
        if inner_number != number:
            raise Malformed
        value = data[begin:at]
    elif wire_type == END_OF_GROUP:
        value = b""
    elif wire_type in (FIXED64, BYTES, FIXED32):
        size = {FIXED64: 8, FIXED32: 4}.get(wire_type)
        if size is None:
            size, at = read_varint(data, at)
        if size > len(data) - at:
            raise Malformed
        value = data[at:at + size]
        at += size
    else:
        raise Malformed
    return number, wire_type, value, at


def write_fields(fields):
    out = bytearray()
    for number, wire_type, value in fields:
        out += write_varint(number << 3 | wire_type)
        if wire_type == VARINT:
            out += write_varint(value)
        elif wire_type == BYTES:
            out += write_varint(len(value)) + value
        else:
            out += value
    return bytes(out)


FORMATS = {"fixed32": "<I", "fixed64": "<Q", "sfixed64": "<q", "double": "<d"}


def value_of(kind, raw):
    if kind in FORMATS:
        return struct.unpack(FORMATS[kind], raw)[0]
    if kind == "string":
        try:
            return raw.decode()
        except UnicodeDecodeError:
            raise Malformed from None
    if kind == "uint32":
        return raw & 0xFFFFFFFF
    if kind == "sint64":
        return raw >> 1 ^ -(raw & 1)
    return raw


def raw_of(kind, value):
    if kind in FORMATS:
        return struct.pack(FORMATS[kind], value)
    if kind == "string":
        return value.encode()
    if kind == "sint64":
        return (value << 1 ^ value >> 63) & MASK
    return value


def read_message(table, data):
    """The fields of a table by name. A field that is unknown or has another wire type is skipped."""
    found = {name: {"string": "", "bytes": b""}.get(kind, 0) for name, kind in table.values()}
    for number, wire_type, raw in read_fields(data):
        name, kind = table.get(number, (None, None))
        if name and wire_type == WIRE_TYPES[kind]:
            found[name] = value_of(kind, raw)
    return found


def write_message(table, values):
    """Ascending, without default values."""
    return write_fields((number, WIRE_TYPES[kind], raw_of(kind, values[name]))
                        for number, (name, kind) in sorted(table.items()) if values.get(name))


# The packet.


def is_channel(name):
    size = len(name.encode())
    return (1 <= size <= 200 and all(ord(one) > 0x20 and not 0x7F <= ord(one) <= 0x9F and
                                     not 0x2028 <= ord(one) <= 0x202E and not 0x2066 <= ord(one) <= 0x2069
                                     for one in name))


def read_topic(topic):
    """The channel and the session, 0 for the plain form."""
    channel, session = topic[:-1], 0
    if not topic.endswith(b"\0"):
        channel, mark, digits = topic[:-17], topic[-17:-16], topic[-16:]
        if mark != b"\1" or not all(digit in b"0123456789abcdef" for digit in digits) or int(digits, 16) == 0:
            raise Fault("topic")
        session = int(digits, 16)
    try:
        if is_channel(channel.decode()):
            return channel.decode(), session
    except UnicodeDecodeError:
        pass
    raise Fault("topic")


def write_topic(channel, session=0):
    return channel.encode() + (b"\1%016x" % session if session else b"\0")


def read_head_frame(frame):
    """The bytes of head_str."""
    if len(frame) < 6:
        raise Fault("truncated")
    length, separator = struct.unpack_from("<IH", frame)
    if separator != SEPARATOR:
        raise Fault("separator")
    if len(frame) - 6 < length:
        raise Fault("truncated")
    if len(frame) - 6 > length:
        raise Fault("length")
    return frame[6:]


def write_head_frame(head_str):
    return struct.pack("<IH", len(head_str), SEPARATOR) + head_str


def read_head(head_str):
    version, head = 0, None
    try:  # The version counts as far as the head can be read.
        for number, wire_type, raw in read_fields(head_str):
            if number == 1 and wire_type == FIXED32:
                version = value_of("fixed32", raw)
        head = read_message(HEAD, head_str)
    except Malformed:
        pass
    if (version or 65536) >> 16 != VERSION >> 16:
        raise Fault("version")
    if head is None or not is_channel(head["channel"]):
        raise Fault("head")
    if head["encoding"] not in (0, PROTOBUF, CUSTOM, PLAIN):
        raise Fault("type")
    return head


def read_packet(frames, type_name, encoding=PROTOBUF):
    """(head, session, message) for a reader of a type; raises Fault. The message is the data if it is not protobuf."""
    if len(frames) < 3:
        raise Fault("truncated")
    channel, session = read_topic(frames[0])
    if len(frames) > 3:
        raise Fault("length")
    head = read_head(read_head_frame(frames[1]))
    if channel != head["channel"]:
        raise Fault("topic")
    if head["type"] not in ("", type_name) or head["encoding"] not in (0, encoding):
        raise Fault("type")
    if encoding != PROTOBUF:
        return head, session, frames[2]
    try:
        return head, session, read_message(TYPES[type_name], frames[2])
    except Malformed:
        raise Fault("data") from None


def write_packet(head, data, session=0):
    return [write_topic(head["channel"], session), write_head_frame(write_message(HEAD, head)), data]


# Hashes.


def fnv1a(data, bits):
    start, prime = {32: (0x811C9DC5, 0x01000193), 64: (0xCBF29CE484222325, 0x100000001B3)}[bits]
    for byte in data:
        start = (start ^ byte) * prime & (1 << bits) - 1
    return start or 1


def fingerprint(lines):
    return fnv1a("".join(f"{line}\n" for line in lines).encode(), 64)


def origin_of(channel):
    return fnv1a(channel.encode(), 32)


def key_of(head):
    mixed = (head["publisher_id"] ^ head["incarnation"] * 0x9E3779B97F4A7C15 & MASK) + origin_of(head["channel"]) & MASK
    seed = (mixed ^ mixed >> 32) * 0xD6E8FEB86659FD93 & MASK
    mixed = seed + head["sequence"] + head["unsent"] & MASK
    return (mixed ^ mixed >> 32) * 0xD6E8FEB86659FD93 & MASK or 1
