'use strict';

const { invalid } = require('./errors');
const { native } = require('./native');
const { Watch } = require('./watch');
const check = require('./arguments');

const KINDS = ['bool', 'integer', 'number', 'text', 'numbers'];

// The numbers of operations in src/params.c.
const [BOOL, INTEGER, NUMBER, TEXT, YAML, SET, REMOVE, SAVE] = Array(8).keys();

const LEAST_INTEGER = -(2n ** 63n);
const MOST_INTEGER = 2n ** 63n - 1n;

/** A value as YAML. JSON has no bigint, and writes null for what it does not have. */
function yamlOf(value, path) {
  const refused = (why) => invalid(`The value for "${path}" has ${why}`);
  const written = (part) => {
    switch (typeof part) {
      case 'boolean':
        return String(part);
      case 'bigint':
        if (part >= LEAST_INTEGER && part <= MOST_INTEGER) return String(part);
        throw refused(`${part}, but its integers must have 64 bits.`);
      case 'number':
        if (Number.isFinite(part)) return String(part);
        throw refused(`${part}, but its numbers must be finite.`);
      case 'string':
        return JSON.stringify(check.text(part, `The value for "${path}"`));
      case 'object':
        if (part === null) return 'null';
        if (Array.isArray(part)) return `[${part.map(written).join(', ')}]`;
        if (typeof part.toJSON === 'function') return written(part.toJSON());
        return `{${Object.entries(part).filter(([, field]) => field !== undefined)
          .map(([name, field]) => `${JSON.stringify(name)}: ${written(field)}`).join(', ')}}`;
      default:
        throw refused(`${String(part)}, which no parameter can have.`);
    }
  };
  return written(value);
}

/** A bound as a double; undefined: none. */
function boundOf(value, what) {
  if (value === undefined || typeof value === 'bigint') return value === undefined ? undefined : Number(value);
  if (typeof value === 'number' && !Number.isNaN(value)) return value;
  throw invalid(`${what} is ${String(value)}, but must be a number.`);
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
  #watches = new Set();

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

  /** A number, or a bigint beyond Number.MAX_SAFE_INTEGER. */
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
    const place = check.text(path, 'The path');
    const watch = new Watch(this.#session, `The callback for parameter "${place}"`,
      (told) => native.watchParams(this.#external, place, told), changed,
      () => this.#watches.delete(watch));
    this.#watches.add(watch);
    return watch;
  }

  /** Ends the parameters with their watches. */
  close() {
    for (const watch of this.#watches) watch.close();
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
    const bounds = { least: boundOf(chosen.least, 'least'), most: boundOf(chosen.most, 'most') };
    native.declareParam(this.external, check.text(path, 'The path'), KINDS.indexOf(kind), yamlOf(fallback, path),
      { ...chosen, ...bounds });
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
