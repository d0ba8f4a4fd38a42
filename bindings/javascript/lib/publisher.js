'use strict';

const { HgrosError, invalid } = require('./errors');
const { native } = require('./native');
const check = require('./arguments');

// Messages of at least so many bytes are written where receivers read them. For fewer, a copy costs less than a loan.
const LEAST_LOANED = 64 * 1024;

// Messages of publishWait() in one turn of the event loop. Then all else in the program has its turn.
const MOST_PER_TURN = 64;

/** The messages of one publisher that wait for room, in the order of the calls. Others must not overtake them. */
class Line {
  #last;  // The last one, while there is one.

  get waits() {
    return this.#last !== undefined;
  }

  /** For what does not wait. */
  check() {
    if (!this.waits) return;
    throw new HgrosError('HGROS_FULL', 'Messages of publishWait() are waiting for room, and must be first.');
  }

  /** Calls a function, which returns a promise, after those that wait already. */
  add(publish) {
    const published = this.#last === undefined ? publish() : this.#last.then(publish, publish);
    this.#last = published;
    const forget = () => {
      if (this.#last === published) this.#last = undefined;
    };
    published.then(forget, forget);
    return published;
  }
}

/** Memory to fill and publish. It is where receivers on this host read, so publishing it copies nothing. */
class Loan {
  #publisher;
  #line;
  #external;
  #view;
  #publishing = false;  // It is in the line.

  constructor(publisher, line, size) {
    this.#publisher = publisher;
    this.#line = line;
    this.#external = native.openLoan(publisher, size);
  }

  /** The bytes to fill, which have arbitrary values at first; undefined once they are published or closed. */
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
    if (!this.#publishing) this.#line.check();
    this.#detach();
    native.publishLoan(this.#publisher, this.#external);
  }

  async publishWait(options) {
    const { timeout } = check.options(options, ['timeout']);
    const nanoseconds = check.timeout(timeout);
    this.#detach();
    this.#publishing = true;
    try {
      await this.#line.add(async () => native.publishLoanWait(this.#publisher, this.#external, nanoseconds));
    } finally {
      this.#publishing = false;
    }
  }

  /** Gives back a loan that was not published. Otherwise the garbage collector does. */
  close() {
    this.#detach();
    native.closeLoan(this.#external);
  }
}

/** Publishes messages of one type on one channel, until it or its session is closed. */
class Publisher {
  #external;
  #form;
  #line = new Line();
  #inTurn = 0;

  constructor(session, channel, form, latched) {
    this.#external = native.openPublisher(session, channel, form.schema.constructor.externalOf(form.schema), latched);
    this.#form = form;
  }

  /** Publishes a message and never waits. Throws HGROS_FULL if a lossless subscriber has no room: nobody got it. */
  publish(message) {
    const bytes = this.#form.encode(message);
    this.#line.check();
    if (bytes.length < LEAST_LOANED) {
      native.publish(this.#external, bytes, false);
      return;
    }
    const loan = this.#inLoan(bytes);
    try {
      loan.publish();
    } finally {
      loan.close();
    }
  }

  /** Publishes a message after those that wait already, as soon as every lossless subscriber has room. */
  publishWait(message, options) {
    try {
      const timeout = check.timeout(check.options(options, ['timeout']).timeout);
      const bytes = this.#form.encode(message);
      if (bytes.length >= LEAST_LOANED) return this.#publishLoan(this.#inLoan(bytes), timeout);
      if (this.#line.waits) {
        const copy = Buffer.from(bytes);  // The writer of messages uses its memory again.
        return this.#line.add(async () => native.publishWait(this.#external, copy, timeout));
      }
      if (native.publish(this.#external, bytes, true)) return this.#turn();
      return this.#line.add(async () => native.publishWait(this.#external, bytes, timeout));
    } catch (error) {
      return Promise.reject(error);
    }
  }

  async #publishLoan(loan, timeout) {
    try {
      await loan.publishWait({ timeout });
    } finally {
      loan.close();
    }
  }

  #turn() {
    if (++this.#inTurn < MOST_PER_TURN) return Promise.resolve();
    this.#inTurn = 0;
    return new Promise(setImmediate);
  }

  #inLoan(bytes) {
    const loan = new Loan(this.#external, this.#line, bytes.length);
    loan.data.set(bytes);
    return loan;
  }

  /** Memory for a message of `size` bytes, to fill and publish in place. */
  loan(size) {
    return new Loan(this.#external, this.#line, check.count(size, 'The size of the loan'));
  }

  close() {
    native.closePublisher(this.#external);
  }
}

module.exports = { Publisher };
