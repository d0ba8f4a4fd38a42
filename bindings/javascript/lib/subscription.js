'use strict';

const { HgrosError } = require('./errors');
const { native, scratch } = require('./native');
const { formOfSchema, schemaOfQueue } = require('./types');
const check = require('./arguments');

const LONGEST_TIMER = 2 ** 31 - 1;

// Messages that are taken in one turn of the event loop. Then all else in the program has its turn.
const MOST_PER_TURN = 64;

// The places of native.take().
const [REMOTE, PUBLISHER, INCARNATION, SEQUENCE, KEY, PUBLISH_MONOTONIC, PUBLISH_TIME, NEW_SCHEMA] = Array(8).keys();

/** A received message. */
class Received {
  #data;
  #form;
  #numbers;
  #message;
  #schema;

  constructor(data, form, schema, numbers) {
    this.#data = data;
    this.#form = form;
    this.#schema = schema;
    this.#numbers = numbers;
  }

  /**
   * The message's bytes, which nobody may write. More than 16 KiB are the sender's memory, without a copy, which is
   * held until nothing refers to them any more, or until close().
   */
  get data() {
    return this.#data;
  }

  /** The message, decoded with the type of the subscription or that of the channel; bytes if that is raw. */
  get message() {
    this.#message ??= (this.#form ?? formOfSchema(this.#schema)).decode(this.#data);
    return this.#message;
  }

  /** The type that came with the channel. */
  get schema() {
    return this.#schema;
  }

  get info() {
    const numbers = this.#numbers;
    return {
      remote: numbers[REMOTE] !== 0n,
      publisher: BigInt.asUintN(64, numbers[PUBLISHER]),
      incarnation: BigInt.asUintN(64, numbers[INCARNATION]),
      sequence: BigInt.asUintN(64, numbers[SEQUENCE]),
      key: BigInt.asUintN(64, numbers[KEY]),
      publishMonotonic: numbers[PUBLISH_MONOTONIC],
      publishTime: numbers[PUBLISH_TIME],
    };
  }

  /** Gives the memory back now: bytes of a large message are empty then, also those inside the decoded one. */
  close() {
    if (this.#data.length > 0) native.detach(this.#data);
  }
}

/** A queue of received messages: `for await (const { message } of subscription)`. */
class Subscription {
  #external;
  #form;
  #schema;
  #turns = [];  // Of those that wait, in their order: each gets a message, or undefined once the queue has ended.
  #taken = 0;  // In this turn of the event loop.
  #closed = false;
  #forget;

  constructor(session, channel, form, chosen, forget) {
    this.#form = form;
    this.#forget = forget;
    this.#external = native.openQueue(session, channel, chosen, () => this.#readable());
  }

  #take() {
    let data;
    try {
      data = native.take(this.#external);
    } catch (error) {
      if (error.code !== 'HGROS_CLOSED') throw error;
      this.close();
    }
    if (data === undefined) return undefined;
    ++this.#taken;
    if (scratch[NEW_SCHEMA] !== 0n) this.#schema = schemaOfQueue(this.#external);
    return new Received(data, this.#form, this.#schema, scratch.slice());
  }

  #readable() {
    this.#taken = 0;
    while (this.#turns.length > 0) {
      const received = this.#take();
      if (received === undefined) return;
      this.#turns.shift()(received);
    }
    native.watchQueue(this.#external, false);
  }

  /** Calls `turn` with the oldest message as soon as there is one, or with undefined once the queue has ended. */
  #wait(turn) {
    if (!this.#closed && this.#turns.length === 0 && this.#taken < MOST_PER_TURN) {
      const received = this.#take();
      if (received !== undefined) return turn(received);
    }
    if (this.#closed) return turn(undefined);
    this.#turns.push(turn);
    if (this.#turns.length === 1) native.watchQueue(this.#external, true);
    return undefined;
  }

  /** Waits for the oldest message. Throws HGROS_CLOSED once the subscription has ended, or HGROS_TIMED_OUT. */
  async take(options) {
    const timeout = check.timeout(check.options(options, ['timeout']).timeout);
    const received = await new Promise((resolve, reject) => {
      let timer;
      const turn = (got) => {
        clearTimeout(timer);
        resolve(got);
      };
      this.#wait(turn);
      if (timeout === undefined || !this.#turns.includes(turn)) return;
      const end = () => {
        this.#turns.splice(this.#turns.indexOf(turn), 1);
        if (this.#turns.length === 0) native.watchQueue(this.#external, false);
        reject(new HgrosError('HGROS_TIMED_OUT', `No message came in ${timeout} ms.`));
      };
      // setTimeout() takes longer times for none.
      const waitFor = (left) => {
        const first = Math.min(left, LONGEST_TIMER);
        timer = setTimeout(() => (left > first ? waitFor(left - first) : end()), first);
      };
      waitFor(timeout);
    });
    if (received === undefined) throw new HgrosError('HGROS_CLOSED', 'The subscription is closed.');
    return received;
  }

  next() {
    return new Promise((resolve) => {
      this.#wait((received) => resolve({ value: received, done: received === undefined }));
    });
  }

  return(value) {
    this.close();
    return Promise.resolve({ value, done: true });
  }

  [Symbol.asyncIterator]() {
    return this;
  }

  /** Counters since the subscription began. */
  stats() {
    return native.queueStats(this.#external);
  }

  /** Ends the subscription, and with it the loops over it. */
  close() {
    if (this.#closed) return;
    this.#closed = true;
    this.#forget(this);
    native.closeQueue(this.#external);
    for (const turn of this.#turns.splice(0)) turn(undefined);
  }
}

module.exports = { Subscription };
