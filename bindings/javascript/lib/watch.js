'use strict';

const { native } = require('./native');

/** Something that is watched until it or its session is closed. */
class Watch {
  #external;
  #closed = false;

  /** `open` gets a function for the library, and returns the watch. */
  constructor(session, open, callback) {
    this.#external = open((...told) => {
      if (!this.#closed) session.guard('The callback of a watch', () => callback(...told));
    });
  }

  close() {
    this.#closed = true;
    native.closeWatch(this.#external);
  }
}

module.exports = { Watch };
