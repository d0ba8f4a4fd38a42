// Packets of the wire protocol, written after docs/wire-protocol.md alone: the names are those of the page.
// Numbers of 64 bits are BigInt.

export const SEPARATOR = 0x2424;
export const VERSION = 1 * 65536 + 3;
export const PROTOBUF = 1, CUSTOM = 2, PLAIN = 3;

const VARINT = 0, FIXED64 = 1, BYTES = 2, GROUP = 3, END_OF_GROUP = 4, FIXED32 = 5;

// hgros.wire.Head: number to name and type.
const HEAD = {
  1: ["version", "fixed32"], 2: ["channel", "string"], 4: ["type", "string"], 5: ["encoding", "enum"],
  6: ["fingerprint", "fixed64"], 7: ["publisher_id", "fixed64"], 8: ["incarnation", "fixed64"],
  9: ["sequence", "uint64"], 10: ["publish_time_ns", "sfixed64"], 11: ["publish_monotonic_ns", "sfixed64"],
  12: ["latched", "uint32"], 13: ["cause", "fixed64"], 14: ["chain_age_ns", "uint64"], 15: ["chain_origin", "fixed32"],
  16: ["unsent", "sint64"],
};
const WIRE_TYPES = {
  fixed32: FIXED32, fixed64: FIXED64, sfixed64: FIXED64, double: FIXED64, string: BYTES, bytes: BYTES, enum: VARINT,
  uint32: VARINT, uint64: VARINT, sint64: VARINT,
};
const DEFAULTS = {
  fixed32: 0, fixed64: 0n, sfixed64: 0n, double: 0, string: "", bytes: Buffer.alloc(0), enum: 0, uint32: 0, uint64: 0n,
  sint64: 0n,
};

// The readers of the vectors and of the robot's messages: number to name and type.
export const TYPES = {
  "foxglove.Vector3": {1: ["x", "double"], 2: ["y", "double"], 3: ["z", "double"]},
  "foxglove.Quaternion": {1: ["x", "double"], 2: ["y", "double"], 3: ["z", "double"], 4: ["w", "double"]},
  "foxglove.Log": {3: ["message", "string"]},
  "foxglove.PointCloud": {2: ["frame_id", "string"], 4: ["point_stride", "fixed32"], 6: ["data", "bytes"]},
  "hgros.SimulatedTime": {}, "hgros.ParamsState": {}, "hgros.Snapshot": {}, "hgros.Trace": {},
};

// A packet that a receiver drops; the message is the fault's name.
export class Fault extends Error {}
// Bytes that are not protobuf.
class Malformed extends Error {}

// Protobuf.

function readVarint(data, at) {
  let value = 0n;
  for (let shift = 0n; shift < 70n; shift += 7n) {
    if (at >= data.length) throw new Malformed();
    const byte = data[at++];
    value |= BigInt(byte & 0x7f) << shift;
    if (byte < 0x80) return [BigInt.asUintN(64, value), at];
  }
  throw new Malformed();
}

function writeVarint(value) {
  const out = [];
  for (value = BigInt(value); value >= 0x80n; value >>= 7n) out.push(Number(value & 0x7fn) | 0x80);
  out.push(Number(value));
  return Buffer.from(out);
}

function readField(data, at) {
  let tag, value;
  [tag, at] = readVarint(data, at);
  const number = Number(tag >> 3n), wireType = Number(tag & 7n), begin = at;
  if (number === 0 || tag >= 1n << 32n) throw new Malformed();
  if (wireType === VARINT) {
    [value, at] = readVarint(data, at);
  } else if (wireType === GROUP) {
    let inner;
    do {
      inner = readField(data, at);
      at = inner.at;
    } while (inner.wireType !== END_OF_GROUP);
    if (inner.number !== number) throw new Malformed();
    value = data.subarray(begin, at);
  } else if (wireType === END_OF_GROUP) {
    value = data.subarray(at, at);
  } else if (wireType === FIXED64 || wireType === BYTES || wireType === FIXED32) {
    let size = wireType === FIXED64 ? 8n : 4n;
    if (wireType === BYTES) [size, at] = readVarint(data, at);
    if (size > BigInt(data.length - at)) throw new Malformed();
    value = data.subarray(at, at + Number(size));
    at += Number(size);
  } else {
    throw new Malformed();
  }
  return {number, wireType, value, at};
}

// The value of a group is its bytes with the end.
export function* readFields(data) {
  for (let at = 0; at < data.length;) {
    const field = readField(data, at);
    if (field.wireType === END_OF_GROUP) throw new Malformed();
    at = field.at;
    yield field;
  }
}

export function writeFields(fields) {
  const out = [];
  for (const {number, wireType, value} of fields) {
    out.push(writeVarint(number * 8 + wireType));
    if (wireType === BYTES) out.push(writeVarint(value.length));
    out.push(wireType === VARINT ? writeVarint(value) : value);
  }
  return Buffer.concat(out);
}

function valueOf(kind, raw) {
  switch (kind) {
    case "fixed32": return raw.readUInt32LE();
    case "fixed64": return raw.readBigUInt64LE();
    case "sfixed64": return raw.readBigInt64LE();
    case "double": return raw.readDoubleLE();
    case "string":
      try {
        return new TextDecoder("utf-8", {fatal: true, ignoreBOM: true}).decode(raw);
      } catch {
        throw new Malformed();
      }
    case "enum": return Number(BigInt.asIntN(32, raw));
    case "uint32": return Number(BigInt.asUintN(32, raw));
    case "sint64": return BigInt.asIntN(64, raw >> 1n ^ -(raw & 1n));
    default: return raw;
  }
}

function rawOf(kind, value) {
  const raw = Buffer.alloc(kind === "fixed32" ? 4 : 8);
  switch (kind) {
    case "fixed32": raw.writeUInt32LE(value); return raw;
    case "fixed64": raw.writeBigUInt64LE(value); return raw;
    case "sfixed64": raw.writeBigInt64LE(value); return raw;
    case "double": raw.writeDoubleLE(value); return raw;
    case "string": return Buffer.from(value);
    case "sint64": return BigInt.asUintN(64, value << 1n ^ value >> 63n);
    default: return value;
  }
}

// The fields of a table by name. A field that is unknown or has another wire type is skipped.
export function readMessage(table, data) {
  const found = {};
  for (const [name, kind] of Object.values(table)) found[name] = DEFAULTS[kind];
  for (const {number, wireType, value} of readFields(data)) {
    const [name, kind] = table[number] ?? [];
    if (name && wireType === WIRE_TYPES[kind]) found[name] = valueOf(kind, value);
  }
  return found;
}

// Ascending, without default values.
export function writeMessage(table, values) {
  const fields = [];
  for (const [number, [name, kind]] of Object.entries(table)) {
    const value = values[name];
    if (value === undefined || value === DEFAULTS[kind] || value.length === 0) continue;
    fields.push({number: Number(number), wireType: WIRE_TYPES[kind], value: rawOf(kind, value)});
  }
  return writeFields(fields);
}

// The packet.

export function isChannel(name) {
  const size = Buffer.byteLength(name);
  return size >= 1 && size <= 200 && !/[\0-\x20\x7f-\x9f\u2028-\u202e\u2066-\u2069]/u.test(name);
}

// The channel and the session, 0 for the plain form.
export function readTopic(topic) {
  let channel = topic.subarray(0, -1), session = 0n;
  if (topic.at(-1) !== 0) {
    const digits = topic.subarray(-16).toString("latin1");
    if (topic.length < 17 || topic.at(-17) !== 1 || !/^[0-9a-f]{16}$/.test(digits)) throw new Fault("topic");
    channel = topic.subarray(0, -17);
    session = BigInt("0x" + digits);
    if (session === 0n) throw new Fault("topic");
  }
  const name = channel.toString();
  if (!Buffer.from(name).equals(channel) || !isChannel(name)) throw new Fault("topic");
  return [name, session];
}

export function writeTopic(channel, session = 0n) {
  return Buffer.from(channel + (session === 0n ? "\0" : "\x01" + hex(session)));
}

// The bytes of head_str.
export function readHeadFrame(frame) {
  if (frame.length < 6) throw new Fault("truncated");
  if (frame.readUInt16LE(4) !== SEPARATOR) throw new Fault("separator");
  const length = frame.readUInt32LE();
  if (frame.length - 6 < length) throw new Fault("truncated");
  if (frame.length - 6 > length) throw new Fault("length");
  return frame.subarray(6);
}

export function writeHeadFrame(headStr) {
  const prefix = Buffer.alloc(6);
  prefix.writeUInt32LE(headStr.length);
  prefix.writeUInt16LE(SEPARATOR, 4);
  return Buffer.concat([prefix, headStr]);
}

function isMalformed(error) {
  if (!(error instanceof Malformed)) throw error;
  return true;
}

export function readHead(headStr) {
  let version = 0, head = null;
  try { // The version counts as far as the head can be read.
    for (const {number, wireType, value} of readFields(headStr)) {
      if (number === 1 && wireType === FIXED32) version = valueOf("fixed32", value);
    }
    head = readMessage(HEAD, headStr);
  } catch (error) {
    isMalformed(error);
  }
  if ((version || 65536) >>> 16 !== VERSION >>> 16) throw new Fault("version");
  if (head === null || !isChannel(head.channel)) throw new Fault("head");
  if (![0, PROTOBUF, CUSTOM, PLAIN].includes(head.encoding)) throw new Fault("type");
  return head;
}

// {head, session, message} for a reader of a type. The message is the data if it is not protobuf.
export function readPacket(frames, typeName, encoding = PROTOBUF) {
  if (frames.length < 3) throw new Fault("truncated");
  const [channel, session] = readTopic(frames[0]);
  if (frames.length > 3) throw new Fault("length");
  const head = readHead(readHeadFrame(frames[1]));
  if (channel !== head.channel) throw new Fault("topic");
  if (!["", typeName].includes(head.type) || ![0, encoding].includes(head.encoding)) throw new Fault("type");
  if (encoding !== PROTOBUF) return {head, session, message: frames[2]};
  try {
    return {head, session, message: readMessage(TYPES[typeName], frames[2])};
  } catch (error) {
    isMalformed(error);
    throw new Fault("data");
  }
}

export function writePacket(head, data, session = 0n) {
  return [writeTopic(head.channel, session), writeHeadFrame(writeMessage(HEAD, head)), data];
}

// Hashes.

export function hex(value) {
  return value.toString(16).padStart(16, "0");
}

export function fnv1a(data, bits) {
  const prime = bits === 32 ? 0x01000193n : 0x100000001b3n;
  let hash = bits === 32 ? 0x811c9dc5n : 0xcbf29ce484222325n;
  for (const byte of Buffer.from(data)) hash = BigInt.asUintN(bits, (hash ^ BigInt(byte)) * prime);
  return hash || 1n;
}

export function fingerprint(lines) {
  return fnv1a(lines.map((line) => line + "\n").join(""), 64);
}

export function originOf(channel) {
  return Number(fnv1a(channel, 32));
}

export function keyOf(head) {
  const u64 = (value) => BigInt.asUintN(64, value);
  let mixed = u64((head.publisher_id ^ u64(head.incarnation * 0x9e3779b97f4a7c15n)) + BigInt(originOf(head.channel)));
  const seed = u64((mixed ^ mixed >> 32n) * 0xd6e8feb86659fd93n);
  mixed = u64(seed + head.sequence + head.unsent);
  return u64((mixed ^ mixed >> 32n) * 0xd6e8feb86659fd93n) || 1n;
}
