'use strict';

const assert = require('assert');
const fs = require('fs');
const os = require('os');
const path = require('path');
const test = require('node:test');

const { open, patient, Program, until } = require('./support');

function file(t, yaml) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'hgros-js-'));
  t.after(() => fs.rmSync(folder, { recursive: true }));
  const name = path.join(folder, 'params.yaml');
  fs.writeFileSync(name, yaml);
  return name;
}

test('ParametersAreDeclaredSetAndWatched', async (t) => {
  const session = open(t);
  const name = file(t, 'wheel: {radius: 0.25}\n');
  const params = session.params(name);
  params.declare('wheel.radius', 1, { unit: 'm', most: 1 });
  params.declare('wheel.count', 4, { kind: 'integer' });
  params.declare('name', 'it\'s: "mine"\n');
  params.declare('gains', [1, 2.5]);
  params.declare('on', true);
  assert.strictEqual(params.number('wheel.radius'), 0.25);
  assert.strictEqual(params.integer('wheel.count'), 4);
  assert.strictEqual(params.text('name'), 'it\'s: "mine"\n');
  assert.strictEqual(params.bool('on'), true);
  assert.strictEqual(params.yaml('gains'), '[1.0, 2.5]');
  const changes = [];
  const watch = params.watch('wheel', (at, yaml) => {
    changes.push(`${at}=${yaml}`);
    throw new Error('not so fast');
  });
  params.set('wheel.radius', 0.5);
  params.set('wheel.count', 3n);
  await until('both changes have come', () => changes.length === 2);
  assert.deepStrictEqual(changes, ['wheel.radius=0.5', 'wheel.count=3']);
  assert.strictEqual(session.failures, 2);
  assert.throws(() => params.set('wheel.radius', 2), { code: 'HGROS_REFUSED', message: /1/ });
  assert.throws(() => params.set('wheel.radius', undefined), { code: 'HGROS_INVALID_ARGUMENT' });
  for (const value of [NaN, Infinity, [1, NaN], { x: -Infinity }]) {
    assert.throws(() => params.set('gains', value), { code: 'HGROS_INVALID_ARGUMENT', message: /finite/ });
  }
  watch.close();
  params.set('wheel.radius', 1);
  assert.strictEqual(params.number('wheel.radius'), 1);
  params.remove('wheel.count');
  assert.strictEqual(params.integer('wheel.count'), 4);
  params.save();
  assert.match(fs.readFileSync(name, 'utf8'), /radius: 1/);
  await params.close();
  assert.throws(() => params.bool('on'), { code: 'HGROS_CLOSED' });
  assert.strictEqual(changes.length, 2);
});

test('IntegersKeepAllDigits', async (t) => {
  const params = open(t).params();
  const large = 2n ** 53n + 1n;
  params.declare('count', large, { least: -(2n ** 60n), most: 2n ** 62n });
  assert.strictEqual(params.integer('count'), large);
  for (const value of [-(2n ** 59n) - 1n, large, BigInt(Number.MAX_SAFE_INTEGER)]) {
    params.set('count', value);
    assert.strictEqual(BigInt(params.integer('count')), value);
  }
  assert.strictEqual(params.integer('count'), Number.MAX_SAFE_INTEGER);
  assert.throws(() => params.set('count', 2n ** 62n + 2n ** 58n), { code: 'HGROS_REFUSED' });
  assert.throws(() => params.set('count', 2n ** 63n), { code: 'HGROS_INVALID_ARGUMENT', message: /64 bits/ });
  assert.throws(() => params.declare('other', 1, { most: 'high' }), { code: 'HGROS_INVALID_ARGUMENT', message: /most/ });
  params.set('nested', { counts: [large, -large], other: undefined, 'a b': [] });
  assert.strictEqual(params.integer('nested.counts[1]'), -large);
  assert.strictEqual(params.yaml('nested.counts'), '[9007199254740993, -9007199254740993]');
  assert.throws(() => params.set('text', 'zero\0byte'), { code: 'HGROS_INVALID_ARGUMENT', message: /zero bytes/ });
});

test('ClosedParametersAreNotWatched', async (t) => {
  const program = Program.script(t, `
    const session = require('hgros').open('', { name: 'robot' });
    const params = session.params();
    params.declare('speed', 1, { kind: 'integer' });
    params.watch('speed', () => console.log('told too late'));
    const theirs = session.paramsOf('robot', { timeout: 40000 });
    theirs.watch('other', () => {});
    params.set('speed', 2);
    Promise.all([params.close(), theirs.close()]).then(() => console.log('closed'));
  `);
  assert.strictEqual(await program.line(), 'closed');
  assert.strictEqual(await program.end(), 0); // A watch would keep it running.
});

test('ParametersOfAnotherSession', async (t) => {
  const robot = open(t, { name: 'robot' });
  const tool = open(t);
  const own = robot.params();
  own.declare('speed', 1, { kind: 'integer' });
  const theirs = tool.paramsOf('robot', patient);
  const large = 2n ** 53n + 1n;
  await until('the parameter can be set', () => theirs.set('speed', large).then(() => true, () => false));
  assert.strictEqual(own.integer('speed'), large);
  const changes = [];
  theirs.watch('', (at, yaml) => changes.push(`${at}=${yaml}`));
  await until('the current value comes first', () => changes.includes(`speed=${large}`));
  assert.strictEqual(await theirs.integer('speed'), large);
  await assert.rejects(theirs.set('speed', 'fast'), { code: 'HGROS_REFUSED' });
  await theirs.close();
  await assert.rejects(theirs.integer('speed'), { code: 'HGROS_CLOSED' });
});

test('PeersAndChannelsAreSeen', async (t) => {
  const here = open(t);
  const events = [];
  const watch = here.watchPeers(({ event, peer }) => events.push([event, peer.id]));
  here.subscribe('words', 'foxglove.Log');
  const there = open(t);
  there.advertise('words', 'foxglove.Log');
  await there.waitForSubscribers('words', 1, patient);
  const { id } = there;
  await until('the session came', () => events.some(([event, peer]) => event === 'came' && peer === id));
  const [peer, ...others] = here.peers();
  assert.strictEqual(others.length, 0);
  assert.ok(peer.id === id && peer.pid === process.pid);
  await until('the channel is known', () => here.channels().some(({ name, typeName, publishers, encoding }) =>
    name === 'words' && typeName === 'foxglove.Log' && publishers === 1 && encoding === 'protobuf'));
  await there.close();
  await until('the session is gone', () => events.some(([event, gone]) => event === 'gone' && gone === id));
  watch.close();
});

test('TransformsAreFoundByName', async (t) => {
  const sent = open(t).transforms();
  const tool = open(t);
  const seen = tool.transforms();
  sent.setStatic('map', 'base', { translation: [1, 2, 3] });
  const found = await seen.wait('map', 'base', 0n, patient);
  assert.deepStrictEqual([found.translation, found.rotation], [[1, 2, 3], [0, 0, 0, 1]]);
  const stamp = BigInt(Date.now()) * 1000000n;
  sent.set('base', 'arm', { translation: [0, 0, 1], stamp });
  const arm = sent.lookup('map', 'arm', stamp);
  assert.deepStrictEqual(arm, { translation: [1, 2, 4], rotation: [0, 0, 0, 1], stamp });
  assert.deepStrictEqual(sent.lookup('map', 'base').translation, [1, 2, 3]);
  assert.throws(() => sent.lookup('map', 'moon'), { code: 'HGROS_UNKNOWN_FRAME', message: /moon/ });
  assert.throws(() => sent.set('map', 'arm', { stamp }), { code: 'HGROS_REFUSED', message: /arm/ });
  assert.throws(() => sent.set('map', 'arm', { rotation: [1] }), { code: 'HGROS_INVALID_ARGUMENT' });
  await assert.rejects(seen.wait('map', 'moon', 0n, { timeout: 20 }), { code: 'HGROS_TIMED_OUT', message: /moon/ });
  const waits = assert.rejects(seen.wait('map', 'moon', 0n), { code: 'HGROS_CLOSED' });
  await tool.close();
  await waits;
  await sent.close();
});
