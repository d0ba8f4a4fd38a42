'use strict';

const { native } = require('./native');

/** Something that is watched until it or its session is closed. */
class Watch {
  #external;
  #closed = false;
  #forget;

  /**
   * `what` begins the line about an exception of the callback. `open` gets a function for the library, and returns the
   * watch. `forget` is called when it is closed.
   */
  constructor(session, what, open, callback, forget = () => {}) {
    this.#forget = forget;
    this.#external = open((...told) => {
      if (!this.#closed) session.guard(what, () => callback(...told));
    });
  }

  close() {
    this.#closed = true;
    this.#forget();
    native.closeWatch(this.#external);
  }
}

module.exports = { Watch };
