'use strict';

const { invalid } = require('./errors');
const { native } = require('./native');
const check = require('./arguments');

function frame(name) {
  return check.text(name, "The frame's name");
}

function pose(given) {
  const { translation = [0, 0, 0], rotation = [0, 0, 0, 1], stamp = 0n } =
    check.options(given, ['translation', 'rotation', 'stamp']);
  for (const [numbers, size, what] of [[translation, 3, 'translation'], [rotation, 4, 'rotation']]) {
    if (numbers?.length !== size || !Array.from(numbers).every((number) => typeof number === 'number')) {
      throw invalid(`The ${what} must be ${size} numbers.`);
    }
  }
  check.time(stamp, 'The stamp');
  return { translation: Array.from(translation), rotation: Array.from(rotation), stamp };
}

/**
 * The transforms of a session: those it sets, which other sessions get, and those it receives. One is
 * `{ translation: [x, y, z], rotation: [x, y, z, w], stamp }`: p_target = rotation * p_source + translation.
 */
class Transforms {
  #external;
  #closing;

  constructor(session) {
    this.#external = native.openTransforms(session);
  }

  /** Sets and sends the pose of a child frame in its parent at the pose's stamp. */
  set(parent, child, transform) {
    native.setTransform(this.#external, frame(parent), frame(child), pose(transform), false);
  }

  /** The same for a pose that does not move: sessions that join later get it, too. */
  setStatic(parent, child, transform) {
    native.setTransform(this.#external, frame(parent), frame(child), pose(transform), true);
  }

  /** T_target_source at a time in ns, or at the latest time that all edges between the frames have. */
  lookup(target, source, time) {
    const at = time === undefined ? undefined : check.time(time, 'The time');
    return native.lookUp(this.#external, frame(target), frame(source), at);
  }

  /** The same, but waits until it is there. HGROS_TIMED_OUT says why it is not. */
  async wait(target, source, time, options) {
    const { timeout } = check.options(options, ['timeout']);
    return native.waitForTransform(this.#external, frame(target), frame(source), check.time(time, 'The time'),
      check.timeout(timeout));
  }

  /** Sends what still waits. */
  close() {
    this.#closing ??= Promise.resolve(native.closeTransforms(this.#external));
    return this.#closing;
  }
}

module.exports = { Transforms };
