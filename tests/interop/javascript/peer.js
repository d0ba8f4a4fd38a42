// The peer of JavaScript for tests between languages: peer.js ROLE [ARGUMENT...], or peer.js talk.
'use strict';

const readline = require('readline');

const hgros = require('hgros');

const PATIENCE = { timeout: 30000 };
const KEEP_ALL = { keepAll: 100 };
const LOG = 'foxglove.Log';

const session = hgros.open(process.env.HGROS_INTEROP_YAML);
const say = (line) => process.stdout.write(`${line}\n`);

function ensure(holds, sentence) {
  if (!holds) throw new Error(sentence);
}

const byteAt = (i) => (i * 7 + 3) & 255;

/** The lines of standard input that no role has read. */
class Input {
  #lines = [];
  #over = false;
  #waiting = [];

  constructor() {
    const wake = () => {
      for (const resolve of this.#waiting.splice(0)) resolve();
    };
    readline.createInterface({ input: process.stdin })
      .on('line', (line) => {
        this.#lines.push(line);
        wake();
      })
      .on('close', () => {
        this.#over = true;
        wake();
      });
  }

  async end() {
    while (!this.#over) await new Promise((resolve) => this.#waiting.push(resolve));
  }

  /** A line to read, or the end. */
  async lineOrEnd() {
    while (this.#lines.length === 0 && !this.#over) await new Promise((resolve) => this.#waiting.push(resolve));
  }

  async read() {
    await this.lineOrEnd();
    return this.#lines.shift();
  }
}

/** What one role has opened, and the end of its waiting. */
class Turn {
  #opened = [];

  constructor(ended) {
    this.ended = ended;
  }

  keep(part) {
    this.#opened.push(part);
    return part;
  }

  async close() {
    for (const part of this.#opened) await part.close();
  }
}

const ROLES = {
  async publish(turn, channel, count) {
    const publisher = turn.keep(session.advertise(channel, LOG));
    let ended = false;
    turn.ended.then(() => { ended = true; });
    await session.waitForSubscribers(channel, 1, PATIENCE);
    let sent = 0;
    while (sent < Number(count) && !ended) {
      try {
        await publisher.publishWait({ message: String(sent + 1) }, { timeout: 50 });
      } catch (error) {
        if (error.code !== 'HGROS_TIMED_OUT') throw error;
        continue;
      }
      if (++sent === 1) say('publishing');
    }
    say(`published ${sent}`);
    await turn.ended;
  },

  async subscribe(turn, channel, count) {
    const subscription = turn.keep(session.subscribe(channel, LOG, KEEP_ALL));
    turn.ended.then(() => subscription.close());
    let received = 0;
    let first;
    let last;
    for await (const { message } of subscription) {
      last = message.message;
      if (++received === 1) say(`receiving ${last}`);
      first ??= last;
      ensure(first !== '1' || last === String(received), `Message ${received} is "${last}".`);
      if (received === Number(count)) break;
    }
    say(`received ${received} ${last}`);
  },

  async latch(turn, channel, text) {
    const publisher = turn.keep(session.advertise(channel, LOG, { latched: 2 }));
    for (const message of ['old', text, 'new']) publisher.publish({ message });
    say('latched');
    await turn.ended;
  },

  async 'bulk-publish'(turn, channel, size) {
    const publisher = turn.keep(session.advertise(channel, 'foxglove.PointCloud'));
    const data = Buffer.alloc(Number(size));
    for (let i = 0; i < data.length; ++i) data[i] = byteAt(i);
    await session.waitForSubscribers(channel, 1, PATIENCE);
    await publisher.publishWait({ data, pointStride: 1 }, PATIENCE);
    say(`published ${size}`);
    await turn.ended;
  },

  async 'bulk-subscribe'(turn, channel, size) {
    const subscription = turn.keep(session.subscribe(channel, 'foxglove.PointCloud', KEEP_ALL));
    say('subscribed');
    const { data } = (await subscription.take(PATIENCE)).message;
    ensure(data.length === Number(size), `The message has ${data.length} bytes.`);
    ensure(data.every((byte, i) => byte === byteAt(i)), 'The bytes are not those that were sent.');
    say(`received ${data.length}`);
  },

  async serve(turn, name) {
    turn.keep(session.serve(name, LOG, LOG, ({ message }) => {
      if (message === 'fail') throw new Error('asked to fail');
      return { message: `re: ${message}` };
    }));
    say('serving');
    await turn.ended;
  },

  async call(turn, name, text) {
    const end = Date.now() + PATIENCE.timeout;
    for (;;) {
      try {
        const reply = await session.call(name, LOG, LOG, { message: text }, PATIENCE);
        return say(`answer ${reply.message}`);
      } catch (error) {
        if (error.code !== 'HGROS_NO_SERVER' || Date.now() > end) return say(`failed ${error.message}`);
      }
      await new Promise((resolve) => setTimeout(resolve, 20));
    }
  },

  async misfit(turn, channel) {
    turn.keep(session.subscribe(channel, 'foxglove.PoseInFrame', KEEP_ALL));
    say('subscribed');
    await turn.ended;
  },
};

async function play(ended, role, ...rest) {
  ensure(Object.hasOwn(ROLES, role), `There is no role "${role}".`);
  const turn = new Turn(ended);
  await ROLES[role](turn, ...rest);
  await turn.close();
}

async function main() {
  const input = new Input();
  const [role, ...rest] = process.argv.slice(2);
  if (role === 'talk') {
    say('ready');
    for (let line = await input.read(); line !== undefined; line = await input.read()) {
      if (line !== '') await play(input.lineOrEnd(), ...line.split(' '));
    }
  } else {
    await play(input.end(), role, ...rest);
  }
  await session.close();
  process.stdin.destroy();
}

main().catch((error) => {
  console.error(error.message);
  process.exit(1);
});
