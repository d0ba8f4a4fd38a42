'use strict';

const { native } = require('./native');

/** Something that is watched until it or its session is closed. */
class Watch {
  #external;
  #closed = false;
  #forget;

  /** `open` gets a function for the library, and returns the watch. `forget` is called when it is closed. */
  constructor(session, open, callback, forget = () => {}) {
    this.#forget = forget;
    this.#external = open((...told) => {
      if (!this.#closed) session.guard('The callback of a watch', () => callback(...told));
    });
  }

  close() {
    this.#closed = true;
    this.#forget();
    native.closeWatch(this.#external);
  }
}

module.exports = { Watch };
