'use strict';

const { HgrosError, invalid } = require('./errors');
const { native } = require('./native');
const check = require('./arguments');

// Messages of at least so many bytes are written where receivers read them. For fewer, a copy costs less than a loan.
const LEAST_LOANED = 64 * 1024;

// Messages of publishWait() in one turn of the event loop. Then all else in the program has its turn.
const MOST_PER_TURN = 64;

/** Memory to fill and publish. It is where receivers on this host read, so publishing it copies nothing. */
class Loan {
  #publisher;
  #external;
  #view;
  #publishing = false;  // A thread publishes it.

  constructor(publisher, size) {
    this.#publisher = publisher;
    this.#external = native.openLoan(publisher, size);
  }

  /** The bytes to fill, which have arbitrary values at first; undefined once they are published. */
  get data() {
    if (this.#publishing) return undefined;
    this.#view ??= native.viewLoan(this.#external);
    return this.#view;
  }

  // A published message is never written again: its memory disappears from all views of it.
  #detach() {
    if (this.#publishing) throw invalid('The loan is being published.');
    if (this.#view !== undefined) native.detach(this.#view);
    this.#view = undefined;
  }

  publish() {
    this.#detach();
    native.publishLoan(this.#publisher, this.#external);
  }

  async publishWait(options) {
    const { timeout } = check.options(options, ['timeout']);
    const nanoseconds = check.timeout(timeout);
    this.#detach();
    this.#publishing = true;
    try {
      await native.publishLoanWait(this.#publisher, this.#external, nanoseconds);
    } finally {
      this.#publishing = false;
    }
  }
}

/** Publishes messages of one type on one channel, until it or its session is closed. */
class Publisher {
  #external;
  #form;
  #waiting;  // The last publishWait(), while there is one.
  #inTurn = 0;

  constructor(session, channel, form, latched) {
    this.#external = native.openPublisher(session, channel, form.schema.constructor.externalOf(form.schema), latched);
    this.#form = form;
  }

  /** Publishes a message and never waits. Throws HGROS_FULL if a lossless subscriber has no room: nobody got it. */
  publish(message) {
    const bytes = this.#form.encode(message);
    if (this.#waiting !== undefined) {
      throw new HgrosError('HGROS_FULL', 'Messages of publishWait() are waiting for room, and must be first.');
    }
    if (bytes.length < LEAST_LOANED) native.publish(this.#external, bytes, false);
    else this.#inLoan(bytes).publish();
  }

  /** Publishes a message after those that wait already, as soon as every lossless subscriber has room. */
  publishWait(message, options) {
    let bytes;
    let timeout;
    try {
      timeout = check.timeout(check.options(options, ['timeout']).timeout);
      bytes = this.#form.encode(message);
      if (this.#waiting === undefined && bytes.length < LEAST_LOANED && native.publish(this.#external, bytes, true)) {
        return this.#turn();
      }
    } catch (error) {
      return Promise.reject(error);
    }
    const published = this.#afterOthers(bytes, timeout);
    this.#waiting = published;
    const forget = () => {
      if (this.#waiting === published) this.#waiting = undefined;
    };
    published.then(forget, forget);
    return published;
  }

  #turn() {
    if (++this.#inTurn < MOST_PER_TURN) return Promise.resolve();
    this.#inTurn = 0;
    return new Promise(setImmediate);
  }

  async #afterOthers(bytes, timeout) {
    if (bytes.length >= LEAST_LOANED) {
      const loan = this.#inLoan(bytes);
      await this.#waiting?.catch(() => {});
      return loan.publishWait({ timeout });
    }
    const before = this.#waiting;
    if (before === undefined) return native.publishWait(this.#external, bytes, timeout);
    const copy = Buffer.from(bytes);  // The writer of messages uses its memory again.
    await before.catch(() => {});
    return native.publishWait(this.#external, copy, timeout);
  }

  #inLoan(bytes) {
    const loan = new Loan(this.#external, bytes.length);
    loan.data.set(bytes);
    return loan;
  }

  /** Memory for a message of `size` bytes, to fill and publish in place. */
  loan(size) {
    return new Loan(this.#external, check.count(size, 'The size of the loan'));
  }

  close() {
    native.closePublisher(this.#external);
  }
}

module.exports = { Publisher };
