// The peer of JavaScript for tests between languages: peer.js ROLE [ARGUMENT...]
'use strict';

const hgros = require('hgros');

const PATIENCE = { timeout: 30000 };
const KEEP_ALL = { keepAll: 100 };

const session = hgros.open(process.env.HGROS_INTEROP_YAML);
const say = (line) => process.stdout.write(`${line}\n`);

/** Ends with the program's standard input. */
const closed = new Promise((resolve) => {
  process.stdin.on('close', resolve).on('end', resolve).resume();
});

function ensure(holds, sentence) {
  if (!holds) throw new Error(sentence);
}

const byteAt = (i) => (i * 7 + 3) & 255;

function advertise(channel, type = 'foxglove.Log', options = undefined) {
  return session.advertise(channel, type, options);
}

const ROLES = {
  async publish(channel, count) {
    const publisher = advertise(channel);
    await session.waitForSubscribers(channel, 1, PATIENCE);
    for (let i = 1; i <= Number(count); ++i) await publisher.publishWait({ message: String(i) }, PATIENCE);
    say(`published ${count}`);
    await closed;
  },

  async subscribe(channel, count) {
    const subscription = session.subscribe(channel, 'foxglove.Log', KEEP_ALL);
    say('subscribed');
    for (let i = 1; i <= Number(count); ++i) {
      const { message } = await subscription.take(PATIENCE);
      ensure(message.message === String(i), `Message ${i} is "${message.message}".`);
    }
    say(`received ${count}`);
  },

  async latch(channel, text) {
    advertise(channel, 'foxglove.Log', { latched: 1 }).publish({ message: text });
    say('latched');
    await closed;
  },

  async late(channel) {
    const { message } = await session.subscribe(channel, 'foxglove.Log', KEEP_ALL).take(PATIENCE);
    say(`late ${message.message}`);
  },

  async 'bulk-publish'(channel, size) {
    const publisher = advertise(channel, 'foxglove.PointCloud');
    const data = Buffer.alloc(Number(size));
    for (let i = 0; i < data.length; ++i) data[i] = byteAt(i);
    await session.waitForSubscribers(channel, 1, PATIENCE);
    await publisher.publishWait({ data, pointStride: 1 }, PATIENCE);
    say(`published ${size}`);
    await closed;
  },

  async 'bulk-subscribe'(channel, size) {
    const subscription = session.subscribe(channel, 'foxglove.PointCloud', KEEP_ALL);
    say('subscribed');
    const { message } = await subscription.take(PATIENCE);
    const { data } = message;
    const sum = data.reduce((total, byte) => total + byte, 0);
    let expected = 0;
    for (let i = 0; i < Number(size); ++i) expected += byteAt(i);
    ensure(data.length === Number(size), `The message has ${data.length} bytes.`);
    ensure(data[0] === byteAt(0) && data.at(-1) === byteAt(data.length - 1) && sum === expected,
      'The bytes are not those that were sent.');
    say(`received ${data.length}`);
  },

  async serve(name) {
    session.serve(name, 'foxglove.Log', 'foxglove.Log', ({ message }) => {
      if (message === 'fail') throw new Error('asked to fail');
      return { message: `re: ${message}` };
    });
    say('serving');
    await closed;
  },

  async call(name, text) {
    const end = Date.now() + PATIENCE.timeout;
    for (;;) {
      try {
        const reply = await session.call(name, 'foxglove.Log', 'foxglove.Log', { message: text }, PATIENCE);
        return say(`answer ${reply.message}`);
      } catch (error) {
        if (error.code !== 'HGROS_NO_SERVER' || Date.now() > end) return say(`failed ${error.message}`);
      }
      await new Promise((resolve) => setTimeout(resolve, 20));
    }
  },

  async misfit(channel) {
    session.subscribe(channel, 'foxglove.PoseInFrame', KEEP_ALL);
    say('subscribed');
    await closed;
  },

  async stream(channel) {
    const publisher = advertise(channel);
    let ended = false;
    closed.then(() => { ended = true; });
    await session.waitForSubscribers(channel, 1, PATIENCE);
    let count = 0;
    while (!ended) {
      try {
        await publisher.publishWait({ message: String(count + 1) }, { timeout: 50 });
      } catch (error) {
        if (error.code !== 'HGROS_TIMED_OUT') throw error;
        continue;
      }
      if (++count === 1) say('streaming');
    }
    say(`streamed ${count}`);
  },

  async follow(channel) {
    const subscription = session.subscribe(channel, 'foxglove.Log', KEEP_ALL);
    closed.then(() => subscription.close());
    let count = 0;
    for await (const { message } of subscription) {
      ensure(message.message !== '', 'A message is empty.');
      if (++count === 1) say('following');
    }
    say(`followed ${count}`);
  },
};

async function main() {
  const [role, ...rest] = process.argv.slice(2);
  ensure(Object.hasOwn(ROLES, role), `There is no role "${role}".`);
  await ROLES[role](...rest);
  await session.close();
  process.stdin.destroy();
}

main().catch((error) => {
  console.error(error.message);
  process.exit(1);
});
