// In a process of its own: other tests leave memory behind.
'use strict';

const assert = require('assert');
const test = require('node:test');

const hgros = require('hgros');
const { pair, patient } = require('./support');

test('MemoryOfMessagesWithoutRoomIsGivenBackAtOnce', async (t) => {
  const { publisher } = await pair(t, new hgros.Schema('my.bytes'), { subscribe: { keepAll: 1 } });
  const large = Buffer.alloc(4 << 20, 1);
  publisher.publish(large);
  const before = process.memoryUsage().rss;
  for (let i = 0; i < 100; ++i) {
    assert.throws(() => publisher.publish(large), { code: 'HGROS_FULL' });
    const loan = publisher.loan(large.length);
    loan.data.set(large);
    loan.close();
    assert.strictEqual(loan.data, undefined);
    assert.throws(() => loan.publish(), { code: 'HGROS_INVALID_ARGUMENT' });
  }
  const grown = (process.memoryUsage().rss - before) / (1 << 20);
  assert.ok(grown < 100, `The process has grown by ${grown} MiB.`);
});

test('MemoryDoesNotGrow', async (t) => {
  const { subscription, publisher } = await pair(t, 'foxglove.Log', { subscribe: { keepAll: 100 } });
  const text = 'x'.repeat(1000);
  const used = () => {
    global.gc();
    return process.memoryUsage().rss;
  };
  let before;
  const publish = async () => {
    for (let i = 0; i < 60000; ++i) await publisher.publishWait({ message: text }, patient);
  };
  const published = publish();
  for (let i = 0; i < 60000; ++i) {
    if (i === 10000) before = used();
    assert.strictEqual((await subscription.take(patient)).message.message.length, 1000);
  }
  await published;
  const grown = (used() - before) / (1 << 20);
  assert.ok(grown < 20, `The process has grown by ${grown} MiB.`);
  assert.strictEqual(hgros.leases(), 0);
});
