'use strict';

const { invalid } = require('./errors');
const { native } = require('./native');
const check = require('./arguments');

const ENCODINGS = ['none', 'protobuf', 'custom', 'plain'];

/** The type of messages: a name, an encoding and, for protobuf, a description. Never changes. */
class Schema {
  #external;
  #parts;

  /**
   * A type of your own. Bytes with the encoding 'custom' have a format that both sides agreed on by the type's name.
   * Without a fingerprint, types are compared by name and encoding alone.
   */
  constructor(typeName, options) {
    if (typeName === Schema) {  // From the library.
      this.#external = options;
      return;
    }
    const known = ['encoding', 'fingerprint', 'descriptorSet'];
    const { encoding = 'custom', fingerprint = 0n, descriptorSet } = check.options(options, known);
    const number = ENCODINGS.indexOf(encoding);
    if (number < 0) throw invalid(`The encoding is ${String(encoding)}, but must be one of ${ENCODINGS.join(', ')}.`);
    if (typeof fingerprint !== 'bigint') throw invalid('The fingerprint must be a bigint.');
    const set = descriptorSet === undefined ? undefined : Buffer.from(descriptorSet);
    this.#external = native.createSchema(check.text(typeName, "The type's name"), number, fingerprint, set);
  }

  /** The schema of a protobuf type that comes with the library, such as 'foxglove.Log'. */
  static known(typeName) {
    return new Schema(Schema, native.knownSchema(check.text(typeName, "The type's name")));
  }

  get #described() {
    this.#parts ??= native.describeSchema(this.#external);
    return this.#parts;
  }

  get typeName() {
    return this.#described.typeName;
  }

  /** 'protobuf', 'custom', 'plain', or 'none' if it is not known. */
  get encoding() {
    return ENCODINGS[this.#described.encoding];
  }

  /** Equal for equal types; 0n: not known. */
  get fingerprint() {
    return this.#described.fingerprint;
  }

  /** For protobuf: a google.protobuf.FileDescriptorSet, or undefined. */
  get descriptorSet() {
    return this.#described.descriptorSet;
  }

  /** For native functions. */
  static externalOf(schema) {
    return schema.#external;
  }
}

module.exports = { Schema, ENCODINGS };
