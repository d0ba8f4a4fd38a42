'use strict';

const { invalid } = require('./errors');
const { native } = require('./native');
const { Watch } = require('./watch');
const check = require('./arguments');

const KINDS = ['bool', 'integer', 'number', 'text', 'numbers'];

// The numbers of operations in src/params.c.
const [BOOL, INTEGER, NUMBER, TEXT, YAML, SET, REMOVE, SAVE] = Array(8).keys();

/** A value as YAML, of which JSON is a part. JSON would write null for a number that is not finite. */
function yamlOf(value, path) {
  const yaml = typeof value === 'bigint' ? String(value) : JSON.stringify(value, (key, part) => {
    if (typeof part !== 'number' || Number.isFinite(part)) return part;
    throw invalid(`The value for "${path}" has ${part}, but its numbers must be finite.`);
  });
  if (yaml === undefined) throw invalid(`The value for "${path}" is ${String(value)}, which no parameter can have.`);
  return yaml;
}

function kindOf(value) {
  if (typeof value === 'boolean') return 'bool';
  if (typeof value === 'bigint') return 'integer';
  if (typeof value === 'number') return 'number';
  if (typeof value === 'string') return 'text';
  return 'numbers';
}

/** A tree of parameters. A path is written like `slam.matcher.gains[2]`. */
class ParamTree {
  #session;
  #external;
  #closing;
  #run;

  constructor(session, external, run) {
    this.#session = session;
    this.#external = external;
    this.#run = run;
  }

  get external() {
    return this.#external;
  }

  #at(operation, path, yaml) {
    return this.#run(this.#external, operation, check.text(path, 'The path'), yaml);
  }

  bool(path) {
    return this.#at(BOOL, path);
  }

  integer(path) {
    return this.#at(INTEGER, path);
  }

  number(path) {
    return this.#at(NUMBER, path);
  }

  text(path) {
    return this.#at(TEXT, path);
  }

  /** Any value, as YAML; an empty path is the whole tree. */
  yaml(path) {
    return this.#at(YAML, path);
  }

  /** Sets a value: a boolean, number, bigint, string, array or object. */
  set(path, value) {
    return this.#at(SET, path, yamlOf(value, path));
  }

  setYaml(path, yaml) {
    return this.#at(SET, path, check.text(yaml, 'The YAML'));
  }

  /** Removes a value; a declared parameter returns to its fallback. */
  remove(path) {
    return this.#at(REMOVE, path);
  }

  /**
   * Calls a function for each changed value at, below or above a path, with its YAML, or undefined if it was removed.
   * For parameters of another session first with all current values.
   */
  watch(path, changed) {
    check.callback(changed, 'The function for changes');
    return new Watch(this.#session, (told) => native.watchParams(this.#external, check.text(path, 'The path'), told),
      changed);
  }

  close() {
    this.#closing ??= Promise.resolve(native.closeParams(this.#external));
    return this.#closing;
  }
}

/** The parameters of this program, which other sessions may read, watch and set under the session's name. */
class Params extends ParamTree {
  constructor(session, external) {
    super(session, external, native.param);
  }

  /**
   * Gives a parameter its kind, bounds, and the value that it has if it was never set. The kind is that of the value;
   * numbers are 'number' unless options.kind is 'integer'.
   */
  declare(path, fallback, options) {
    const known = ['kind', 'description', 'unit', 'readOnly', 'least', 'most', 'choices'];
    const chosen = check.options(options, known);
    const kind = chosen.kind ?? kindOf(fallback);
    if (!KINDS.includes(kind)) throw invalid(`The kind is ${String(kind)}, but must be one of ${KINDS.join(', ')}.`);
    native.declareParam(this.external, check.text(path, 'The path'), KINDS.indexOf(kind), yamlOf(fallback, path),
      chosen);
  }

  /** Writes what was set at run time into the files. */
  save() {
    native.param(this.external, SAVE, '', undefined);
  }
}

/** The parameters of another session. Each function asks it, and returns a promise. */
class RemoteParams extends ParamTree {
  constructor(session, external) {
    super(session, external, async (...request) => native.paramLater(...request));
  }
}

module.exports = { Params, RemoteParams };
