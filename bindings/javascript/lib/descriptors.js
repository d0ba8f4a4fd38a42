'use strict';

// Protobuf descriptions of types of protobufjs. Its own Root#toDescriptor() makes one file of each package, without
// imports, and names the entries of maps differently than protoc, so no other language could read the result.

const LABEL = { optional: 1, required: 2, repeated: 3 };
const MESSAGE = 11;
const ENUM = 14;
const SCALARS = {
  double: 1, float: 2, int64: 3, uint64: 4, int32: 5, fixed64: 6, fixed32: 7, bool: 8, string: 9, bytes: 12, uint32: 13,
  sfixed32: 15, sfixed64: 16, sint32: 17, sint64: 18,
};

const isType = (object) => Array.isArray(object.fieldsArray);
const isEnum = (object) => object.valuesById !== undefined;

/** The outermost type or enum around one. */
function topOf(object) {
  while (isType(object.parent)) object = object.parent;
  return object;
}

/** The file that a top type was read from, or one for its package. */
function fileOf(top) {
  return top.filename ?? `${top.parent.fullName.slice(1) || 'main'}.proto`;
}

function reference(field) {
  const target = field.resolvedType;
  if (target === null) return { type: SCALARS[field.type] };
  return { type: isEnum(target) ? ENUM : MESSAGE, typeName: target.fullName };
}

/** As protoc names it: `wheel_speeds` has WheelSpeedsEntry. */
function entryName(field) {
  return `${protoName(field)}_entry`.replace(/(?:^|_)([a-z0-9])/g, (_, letter) => letter.toUpperCase());
}

const protoName = (field) => field.protoName || field.name;

/** One with the keyword `optional` of proto3, which has a oneof of its own. */
const isOptional = (field) => Boolean(field.options?.proto3_optional);

/** Those of optional fields must be last. */
function oneofsOf(type) {
  const own = (oneof) => oneof.fieldsArray.some(isOptional);
  return [...type.oneofsArray.filter((oneof) => !own(oneof)), ...type.oneofsArray.filter(own)];
}

function describeField(type, field) {
  const name = protoName(field);
  const described = { name, number: field.id, jsonName: field.jsonName || undefined };
  if (field.map) {
    return Object.assign(described, {
      label: LABEL.repeated, type: MESSAGE, typeName: `${type.fullName}.${entryName(field)}`,
    });
  }
  const rule = field.repeated ? 'repeated' : field.required ? 'required' : 'optional';
  Object.assign(described, { label: LABEL[rule] }, reference(field));
  if (field.repeated && described.type !== MESSAGE && !['string', 'bytes'].includes(field.type)) {
    described.options = { packed: field.packed };
  }
  if (field.partOf) {
    described.oneofIndex = oneofsOf(type).indexOf(field.partOf);
    if (isOptional(field)) described.proto3Optional = true;
  }
  return described;
}

function describeEntry(field) {
  return {
    name: entryName(field),
    field: [
      { name: 'key', number: 1, label: LABEL.optional, type: SCALARS[field.keyType] },
      { name: 'value', number: 2, label: LABEL.optional, ...reference(field) },
    ],
    options: { mapEntry: true },
  };
}

function describeEnum(object) {
  const value = Object.entries(object.values).map(([name, number]) => ({ name, number }));
  const aliases = new Set(value.map(({ number }) => number)).size < value.length;
  return { name: object.name, value, options: aliases ? { allowAlias: true } : undefined };
}

/** Whether a top type has what proto3 refuses. */
function isOlder(object) {
  if (isEnum(object)) return Object.values(object.values)[0] !== 0;
  return object.fieldsArray.some((field) => field.required) ||
    object.nestedArray.some((nested) => (isType(nested) || isEnum(nested)) && isOlder(nested));
}

/** `use` is called with each type or enum that a field has. */
function describeType(type, use) {
  for (const field of type.fieldsArray) {
    field.resolve();
    if (field.resolvedType !== null) use(field.resolvedType);
  }
  return {
    name: type.name,
    field: type.fieldsArray.map((field) => describeField(type, field)),
    nestedType: [
      ...type.fieldsArray.filter((field) => field.map).map(describeEntry),
      ...type.nestedArray.filter(isType).map((nested) => describeType(nested, use)),
    ],
    enumType: type.nestedArray.filter(isEnum).map(describeEnum),
    oneofDecl: oneofsOf(type).map(({ name }) => ({ name })),
  };
}

/** A serialized google.protobuf.FileDescriptorSet with all that a type needs, dependencies first. */
function describe(type, FileDescriptorSet) {
  const files = new Map();
  const seen = new Set();
  const add = (top) => {
    if (seen.has(top)) return;
    seen.add(top);
    const name = fileOf(top);
    if (!files.has(name)) {
      files.set(name, {
        name, package: top.parent.fullName.slice(1) || undefined, syntax: 'proto3',
        dependency: [], messageType: [], enumType: [],
      });
    }
    const file = files.get(name);
    if (isOlder(top)) file.syntax = 'proto2';
    const use = (target) => {
      const other = topOf(target);
      const dependency = fileOf(other);
      if (dependency !== name && !file.dependency.includes(dependency)) file.dependency.push(dependency);
      add(other);
    };
    if (isEnum(top)) {
      file.enumType.push(describeEnum(top));
    } else {
      file.messageType.push(describeType(top, use));
    }
  };
  add(topOf(type));

  const ordered = new Set();
  const order = (file) => {
    if (ordered.has(file)) return;
    for (const name of file.dependency) order(files.get(name));
    ordered.add(file);
  };
  for (const file of files.values()) order(file);
  return FileDescriptorSet.encode(FileDescriptorSet.fromObject({ file: [...ordered] })).finish();
}

/**
 * Gives each field the name that protobuf has for JavaScript, if a description has none: `frame_id` is frameId.
 * Descriptions of the library have none, those of protoc have them.
 */
function addJsonNames(messageTypes) {
  for (const message of messageTypes) {
    for (const field of message.field) {
      field.jsonName ||= field.name.replace(/_([a-zA-Z0-9])/g, (_, letter) => letter.toUpperCase());
    }
    addJsonNames(message.nestedType);
  }
}

module.exports = { describe, addJsonNames };
