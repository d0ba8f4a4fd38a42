'use strict';

const path = require('path');

const { HgrosError, invalid } = require('./errors');
const { describe, addJsonNames } = require('./descriptors');
const { Schema } = require('./schema');
const { native } = require('./native');
const { messageFault } = require('./values');

let library;

/** protobufjs, from beside this package or from where the program is. Raw messages do without it. */
function protobuf() {
  if (library !== undefined) return library;
  const paths = [__dirname, path.dirname(process.argv[1] ?? process.cwd())];
  let folder;
  try {
    folder = path.dirname(require.resolve('protobufjs/package.json', { paths }));
  } catch {
    throw new HgrosError('HGROS_NOT_FOUND',
      'Typed messages need the package protobufjs. Run `npm install protobufjs` in the folder of the program.');
  }
  library = require(folder);
  require(path.join(folder, 'ext/descriptor'));
  return library;
}

const schemas = new WeakMap();  // Of types.
const types = new Map();  // By fingerprint and name.

/** The protobufjs type of a schema. */
function typeOf(schema) {
  const key = `${schema.fingerprint} ${schema.typeName}`;
  let type = types.get(key);
  if (type !== undefined) return type;
  if (schema.encoding !== 'protobuf' || schema.descriptorSet === undefined) {
    throw new HgrosError('HGROS_NOT_FOUND', `The type "${schema.typeName}" has no protobuf description.`);
  }
  const { descriptor, Root } = protobuf();
  const set = descriptor.FileDescriptorSet.decode(schema.descriptorSet);
  for (const file of set.file) addJsonNames(file.messageType);
  type = Root.fromDescriptor(set).lookupType(schema.typeName);
  types.set(key, type);
  schemas.set(type, schema);
  return type;
}

/** A type that comes with the library, such as 'foxglove.Log'. */
function type(typeName) {
  return typeOf(Schema.known(typeName));
}

/** The schema of a type of protobufjs: its name, and its file with all imports. */
function schemaOf(given) {
  let schema = schemas.get(given);
  if (schema !== undefined) return schema;
  given.root.resolveAll();
  schema = new Schema(given.fullName.slice(1), {
    encoding: 'protobuf', descriptorSet: describe(given, protobuf().descriptor.FileDescriptorSet),
  });
  schemas.set(given, schema);
  return schema;
}

function bytesOf(message, what) {
  if (!ArrayBuffer.isView(message)) throw invalid(`${what} must be a Buffer or a typed array, as its type is raw.`);
  return Buffer.from(message.buffer, message.byteOffset, message.byteLength);
}

class RawForm {
  constructor(schema) {
    this.schema = schema;
  }

  encode(message) {
    return bytesOf(message, 'The message');
  }

  decode(buffer) {
    return buffer;
  }
}

class ProtobufForm {
  #type;

  constructor(given) {
    this.#type = given;
    this.schema = schemaOf(given);
  }

  encode(message) {
    if (message === null || typeof message !== 'object') throw this.#refuse(`is ${String(message)}`);
    let fault;
    try {
      fault = messageFault(this.#type, message);
      if (fault === undefined) return this.#type.encode(this.#type.fromObject(message)).finish(true);
    } catch (error) {
      throw this.#refuse(`cannot be written: ${error.message}`);
    }
    throw this.#refuse(fault);
  }

  decode(buffer) {
    try {
      return this.#type.decode(buffer);
    } catch (error) {
      throw this.#refuse(`cannot be read: ${error.message}`);
    }
  }

  #refuse(reason) {
    return new HgrosError('HGROS_NOT_WRITABLE', `The message of type ${this.schema.typeName} ${reason}.`);
  }
}

const forms = new WeakMap();

/**
 * How the messages of a type become bytes and back. A type is one of protobufjs, the name of one that comes with the
 * library, or a Schema, whose messages are bytes.
 */
function formOf(given) {
  if (typeof given === 'string') given = type(given);
  const form = given !== null && typeof given === 'object' ? forms.get(given) : undefined;
  if (form !== undefined) return form;
  let made;
  if (given instanceof Schema) {
    made = new RawForm(given);
  } else if (Array.isArray(given?.fieldsArray) && typeof given.encode === 'function') {
    made = new ProtobufForm(given);
  } else {
    throw invalid('The type must be one of protobufjs (such as root.lookupType("my.Type")), the name of a type of the ' +
      'library, or a Schema. Classes that pbjs made with "static" have no description: use the target "json-module".');
  }
  forms.set(given, made);
  return made;
}

/** The form of a received schema: that of its protobuf type, or else bytes. */
function formOfSchema(schema) {
  if (schema === undefined) return new RawForm(undefined);
  const described = schema.encoding === 'protobuf' && schema.descriptorSet !== undefined;
  return formOf(described ? typeOf(schema) : schema);
}

/** A copy of the type of the message that was taken last. */
function schemaOfQueue(queue) {
  const schema = native.schemaOfQueue(queue);
  return schema === undefined ? undefined : new Schema(Schema, schema);
}

module.exports = { protobuf, type, formOf, formOfSchema, schemaOfQueue };
