'use strict';

// protobufjs writes what it is given: it leaves out fields and names of enums that it does not know, cuts numbers, and
// writes 0 for a text that is no number. The functions here find such values first.

const BOUNDS = new Map();
for (const kind of ['int32', 'sint32', 'sfixed32']) BOUNDS.set(kind, [-(2n ** 31n), 2n ** 31n - 1n]);
for (const kind of ['uint32', 'fixed32']) BOUNDS.set(kind, [0n, 2n ** 32n - 1n]);
for (const kind of ['int64', 'sint64', 'sfixed64']) BOUNDS.set(kind, [-(2n ** 63n), 2n ** 63n - 1n]);
for (const kind of ['uint64', 'fixed64']) BOUNDS.set(kind, [0n, 2n ** 64n - 1n]);

function shown(value) {
  const text = typeof value === 'string' ? JSON.stringify(value) : String(value);
  return text.length > 60 ? `${text.slice(0, 60)}...` : text;
}

/** Whether it is a Long of protobufjs. */
function isLong(value) {
  return typeof value === 'object' && typeof value.low === 'number' && typeof value.high === 'number';
}

function integerFault(kind, value) {
  const [least, most] = BOUNDS.get(kind);
  if (isLong(value) && kind.endsWith('64')) return undefined;
  const whole = typeof value === 'bigint' || Number.isInteger(value) ||
    (typeof value === 'string' && /^\s*[-+]?\d+\s*$/.test(value));
  if (whole && BigInt(value) >= least && BigInt(value) <= most) return undefined;
  return `is ${shown(value)}, but must be a whole number from ${least} to ${most}`;
}

function numberFault(value) {
  if (typeof value === 'number') return undefined;
  const written = typeof value === 'string' && value.trim() !== '';
  if (written && (value === 'NaN' || !Number.isNaN(Number(value)))) return undefined;
  return `is ${shown(value)}, but must be a number`;
}

function textFault(value) {
  if (typeof value === 'object' || typeof value === 'function') return `is ${shown(value)}, but must be a text`;
  if (typeof value !== 'string' || !/\p{Surrogate}/u.test(value)) return undefined;
  return 'is not well-formed: a half of a surrogate pair has no other half';
}

function enumFault(type, value) {
  if (typeof value === 'number') return integerFault('int32', value);
  if (typeof value === 'string' && Object.hasOwn(type.values, value)) return undefined;
  return `is ${shown(value)}, but must be a number or one of ${Object.keys(type.values).join(', ')}`;
}

function bytesFault(value) {
  const byte = (number) => Number.isInteger(number) && number >= 0 && number < 256;
  return Array.isArray(value) && !value.every(byte) ? 'has an element that is no byte' : undefined;
}

function scalarFault(kind, value) {
  if (BOUNDS.has(kind)) return integerFault(kind, value);
  switch (kind) {
    case 'double':
    case 'float': return numberFault(value);
    case 'bool': return typeof value === 'boolean' || value === 0 || value === 1 ? undefined
      : `is ${shown(value)}, but must be true or false`;
    case 'string': return textFault(value);
    case 'bytes': return bytesFault(value);
    default: return undefined;
  }
}

function valueFault(field, value, path) {
  const type = field.resolvedType;
  if (type?.fieldsArray !== undefined) {
    if (value === null || typeof value !== 'object') return undefined;  // protobufjs says so.
    if (value instanceof Date) return `cannot be written: "${path}" is a Date, but must be an object of its fields`;
    return messageFault(type, value, path);
  }
  const fault = type?.values !== undefined ? enumFault(type, value) : scalarFault(field.type, value);
  return fault === undefined ? undefined : `cannot be written: "${path}" ${fault}`;
}

function fieldFault(field, value, path) {
  if (value === undefined || value === null) return undefined;
  if (!field.repeated && !field.map) return valueFault(field, value, path);
  if (typeof value !== 'object' || (field.repeated && !Array.isArray(value))) return undefined;  // protobufjs says so.
  // The usual long list; a path for each number would cost more than writing it.
  const real = field.type === 'double' || field.type === 'float';
  if (real && field.repeated && value.every((element) => typeof element === 'number')) return undefined;
  for (const key of Object.keys(value)) {
    const fault = valueFault(field, value[key], field.map ? `${path}.${key}` : `${path}[${key}]`);
    if (fault !== undefined) return fault;
  }
  return undefined;
}

/** Says what would not be written as it is, as in 'has no field "a.b"; the fields are c'; undefined if all would be. */
function messageFault(type, message, path) {
  if (type.fullName === '.google.protobuf.Any') return undefined;  // May be written with its content.
  const made = message instanceof type.ctor;
  for (const name of Object.keys(message)) {
    const inside = path === undefined ? name : `${path}.${name}`;
    const field = Object.hasOwn(type.fields, name) ? type.fields[name].resolve() : undefined;
    if (field === undefined && !made) {
      return `has no field "${inside}"; the fields are ${Object.keys(type.fields).join(', ')}`;
    }
    const fault = field === undefined ? undefined : fieldFault(field, message[name], inside);
    if (fault !== undefined) return fault;
  }
  return undefined;
}

module.exports = { messageFault };
