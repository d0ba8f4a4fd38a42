'use strict';

const assert = require('assert');
const test = require('node:test');

const hgros = require('hgros');
const { open, pair, patient, until } = require('./support');

const LOG = 'foxglove.Log';

test('TypedMessagesGoFromSessionToSession', async (t) => {
  const { from, subscription, publisher } = await pair(t, LOG);
  for (let i = 0; i < 50; ++i) {
    await publisher.publishWait({ message: String(i), timestamp: { seconds: 7, nanos: i } }, patient);
    const { message, info, schema } = await subscription.take(patient);
    assert.strictEqual(message.message, String(i));
    assert.strictEqual(message.timestamp.nanos, i);
    assert.strictEqual(schema.typeName, LOG);
    assert.ok(info.remote && info.publisher === from.id && info.sequence === BigInt(i + 1));
    assert.ok(Math.abs(Number(info.publishTime / 1000000n) - Date.now()) < 60000);
    assert.ok(process.hrtime.bigint() - info.publishMonotonic < 60000000000n);
  }
});

test('TypesOfProtobufjsAreDescribedAsProtocDoes', async () => {
  const { root } = hgros.protobuf.parse(`syntax = "proto3"; package my.robot;
    import "google/protobuf/timestamp.proto";
    message Wheel { double radius_m = 1; repeated sint32 counts = 2; map<string, Wheel> by_name = 3; }
    message Drive {
      google.protobuf.Timestamp stamp = 1; repeated Wheel wheels = 2; optional bool is_on = 3;
      oneof way { string road = 4; bytes rail = 5; }
      enum Mode { OFF = 0; ON = 1; } Mode mode = 6; map<uint32, Mode> old_modes = 7;
    }`);
  root.addJSON(hgros.protobuf.common.get('google/protobuf/timestamp.proto').nested);
  const session = hgros.open();
  const Drive = root.lookupType('Drive');
  const schema = await roundTrip(session, Drive, { isOn: true, rail: Buffer.from('ab'), oldModes: { 3: 1 } });
  const set = hgros.protobuf.descriptor.FileDescriptorSet.decode(schema.descriptorSet);
  assert.deepStrictEqual(set.file.map((file) => file.package).sort(), ['google.protobuf', 'my.robot']);
  const drive = set.file.at(-1).messageType.find(({ name }) => name === 'Drive');
  assert.deepStrictEqual(drive.field.map(({ name }) => name),
    ['stamp', 'wheels', 'is_on', 'road', 'rail', 'mode', 'old_modes']);
  assert.deepStrictEqual(drive.nestedType.map(({ name }) => name), ['OldModesEntry']);
  await session.close();
});

/** Publishes a message and takes it as any type; the result is the schema that came. */
async function roundTrip(session, type, sent) {
  const subscription = session.subscribe(type.name);
  session.advertise(type.name, type).publish(sent);
  const received = await subscription.take(patient);
  assert.deepStrictEqual(JSON.parse(JSON.stringify(received.message)),
    JSON.parse(JSON.stringify(type.fromObject(sent))));
  subscription.close();
  return received.schema;
}

test('SchemasMadeHereAreThoseOfTheLibrary', async () => {
  const files = new hgros.protobuf.Root();
  files.resolvePath = (_, target) => `${process.env.HGROS_PROTO_DIR}/${target}`;
  files.loadSync(['foxglove/PointCloud.proto', 'foxglove/Log.proto', 'foxglove/SceneUpdate.proto']);
  const session = hgros.open();
  for (const name of ['foxglove.PointCloud', LOG, 'foxglove.SceneUpdate']) {
    const schema = await roundTrip(session, files.lookupType(name), {});
    assert.strictEqual(schema.fingerprint, hgros.Schema.known(name).fingerprint, name);
  }
  assert.throws(() => hgros.Schema.known('no.Such'), { code: 'HGROS_NOT_FOUND', message: /no\.Such/ });
  await session.close();
});

test('TheTypeComesWithTheChannel', async (t) => {
  const { root } = hgros.protobuf.parse(
    'syntax = "proto3"; message Thing { repeated string the_names = 1; int64 n = 2; }');
  const { subscription, publisher } = await pair(t, root.lookupType('Thing'), { receivedAs: null });
  publisher.publish({ theNames: ['a', 'b'], n: '9007199254740993' });
  const { message, schema } = await subscription.take(patient);
  assert.deepStrictEqual(JSON.parse(JSON.stringify(message)), { theNames: ['a', 'b'], n: '9007199254740993' });
  assert.strictEqual(schema.typeName, 'Thing');
});

test('RawBytesGoBothWays', async (t) => {
  const bytes = new hgros.Schema('my.bytes', { fingerprint: 5n });
  const { subscription, publisher } = await pair(t, bytes);
  publisher.publish(Buffer.from('abc'));
  publisher.publish(new Uint8Array(0));
  publisher.publish(new Uint16Array([1]));
  const received = [];
  for (let i = 0; i < 3; ++i) received.push(await subscription.take(patient));
  assert.deepStrictEqual(received.map(({ message }) => message.toString('hex')), ['616263', '', '0100']);
  assert.strictEqual(received[0].schema.encoding, 'custom');
  assert.strictEqual(received[0].schema.fingerprint, 5n);
  assert.throws(() => publisher.publish('text'), { code: 'HGROS_INVALID_ARGUMENT' });
});

test('LargeMessagesAreNotCopiedAndKeepALease', async (t) => {
  await collected();  // What the tests before have received.
  const { subscription, publisher } = await pair(t, 'foxglove.PointCloud');
  const data = Buffer.alloc(4 << 20, 7);
  data[data.length - 1] = 9;
  await publisher.publishWait({ data, pointStride: 1, frameId: 'map' }, patient);
  let received = await subscription.take(patient);
  assert.strictEqual(hgros.leases(), 1);
  assert.ok(received.message.data.equals(data) && received.message.frameId === 'map');
  assert.strictEqual(received.message.data.buffer, received.data.buffer);
  const { message } = received;
  received.close();
  assert.strictEqual(message.data.length, 0);
  await until('a closed message gives its lease back', () => hgros.leases() === 0);

  await publisher.publishWait({ data, pointStride: 1 }, patient);
  received = await subscription.take(patient);
  let part = received.message.data.subarray(100, 200);
  received = undefined;
  global.gc();
  await new Promise(setImmediate);
  assert.strictEqual(hgros.leases(), 1);
  assert.strictEqual(part[0], 7);
  part = undefined;
  await collected();
});

/** Waits until forgotten messages have given their leases back. */
function collected() {
  return until('forgotten messages give their leases back', () => {
    global.gc();
    return hgros.leases() === 0;
  });
}

test('TwoQueuesOfASessionShareTheMemory', async (t) => {
  const session = open(t);
  const bytes = new hgros.Schema('my.bytes');
  const queues = [session.subscribe('bytes', bytes), session.subscribe('bytes', bytes)];
  session.advertise('bytes', bytes).publish(Buffer.alloc(1 << 20, 3));
  const received = [await queues[0].take(patient), await queues[1].take(patient)];
  assert.ok(received.every(({ data }) => data.length === 1 << 20 && data[1000] === 3));
  received[0].close();
  assert.strictEqual(received[1].data[5], 3);
});

test('LoansArePublishedInPlaceAndAreNobodysThen', async (t) => {
  const { subscription, publisher } = await pair(t, new hgros.Schema('my.bytes'), { subscribe: { keepAll: 1 } });
  const loan = publisher.loan(1 << 20);
  const view = loan.data;
  view.fill(5);
  loan.publish();
  assert.strictEqual(view.length, 0);
  assert.strictEqual(loan.data, undefined);
  assert.throws(() => loan.publish(), { code: 'HGROS_INVALID_ARGUMENT' });
  const second = publisher.loan(1 << 20);
  second.data.fill(6);
  await until('the queue is full', () => subscription.stats().queued === 1);
  await assert.rejects(second.publishWait({ timeout: 20 }), { code: 'HGROS_TIMED_OUT' });
  assert.strictEqual(second.data[9], 6);
  const published = second.publishWait(patient);
  assert.strictEqual(second.data, undefined);
  assert.throws(() => second.publish(), { code: 'HGROS_INVALID_ARGUMENT' });
  await assert.rejects(second.publishWait(patient), { code: 'HGROS_INVALID_ARGUMENT' });
  assert.ok((await subscription.take(patient)).data.every((byte) => byte === 5));
  await published;
  assert.ok((await subscription.take(patient)).data.every((byte) => byte === 6));
});

test('LoansDoNotOvertakeWhatWaits', async (t) => {
  const { subscription, publisher } = await pair(t, new hgros.Schema('my.bytes'), { subscribe: { keepAll: 1 } });
  const filled = (size, byte) => {
    const loan = publisher.loan(size);
    loan.data.fill(byte);
    return loan;
  };
  publisher.publish(Buffer.from([1]));
  const waits = publisher.publishWait(Buffer.from([2]), patient);
  const loan = filled(10, 4);
  assert.throws(() => loan.publish(), { code: 'HGROS_FULL' });
  assert.strictEqual(loan.data[9], 4);
  const all = [waits, filled(5, 3).publishWait(patient), loan.publishWait(patient),
    publisher.publishWait(Buffer.alloc(1 << 20, 5), patient), publisher.publishWait(Buffer.from([6]), patient)];
  for (let wanted = 1; wanted <= 6; ++wanted) {
    assert.strictEqual((await subscription.take(patient)).data[0], wanted);
  }
  await Promise.all(all);
});

test('LosslessMessagesComeInOrder', async (t) => {
  const { subscription, publisher } = await pair(t, LOG, { subscribe: { keepAll: 7 } });
  const all = [];
  for (let i = 1; i <= 1000; ++i) all.push(publisher.publishWait({ message: String(i) }, patient));
  assert.throws(() => publisher.publish({ message: 'too early' }), { code: 'HGROS_FULL' });
  let last = 0;
  for await (const { message } of subscription) {
    assert.strictEqual(message.message, String(++last));
    if (last === 1000) break;
  }
  await Promise.all(all);
  assert.throws(() => subscription.stats(), { code: 'HGROS_CLOSED' });
});

test('QueuesDropOrHoldBack', async (t) => {
  const session = open(t);
  const newest = session.subscribe('newest', LOG, { keepLast: 2 });
  const every = session.subscribe('every', LOG, { keepAll: 2 });
  const dropping = session.advertise('newest', LOG);
  const lossless = session.advertise('every', LOG);
  for (let i = 0; i < 5; ++i) dropping.publish({ message: String(i) });
  assert.deepStrictEqual(newest.stats(), { received: 5, dropped: 3, taken: 0, queued: 2, mismatched: 0 });
  assert.strictEqual((await newest.take(patient)).message.message, '3');
  lossless.publish({ message: '1' });
  lossless.publish({ message: '2' });
  assert.throws(() => lossless.publish({ message: '3' }), { code: 'HGROS_FULL', message: /every/ });
  await assert.rejects(lossless.publishWait({ message: '3' }, { timeout: 10 }), { code: 'HGROS_TIMED_OUT' });
  const waits = lossless.publishWait({ message: '3' }, patient);
  await every.take(patient);
  await waits;
});

test('CallbacksAreCalledInOrderAndMayFail', async (t) => {
  const lines = [];
  const session = open(t, { log: (level, line) => lines.push(`${level}: ${line}`) });
  const got = [];
  let running = 0;
  const subscription = session.subscribe('words', LOG, { keepAll: 10 }, async ({ message }) => {
    assert.strictEqual(++running, 1);
    await new Promise(setImmediate);
    --running;
    got.push(message.message);
    if (message.message === '2') throw new Error('I do not like 2');
  });
  const publisher = session.advertise('words', LOG);
  for (const message of ['1', '2', '3']) publisher.publish({ message });
  await until('all have come', () => got.length === 3);
  assert.deepStrictEqual(got, ['1', '2', '3']);
  assert.strictEqual(session.failures, 1);
  await until('the failure is in the log', () => lines.some((line) => /error: .*"words".*I do not like 2/.test(line)));
  subscription.close();
});

test('AnythingMayBeThrownAndIsSoonOnlyCounted', async (t) => {
  const lines = [];
  const session = open(t, { log: (level, line) => lines.push(`${level}: ${line}`) });
  const stackless = Object.defineProperty(new Error('x'), 'stack', { get() { throw new Error('no stack'); } });
  const things = [stackless, Symbol('s'), Object.create(null), undefined, null, 7];
  session.subscribe('words', LOG, { keepAll: 100 }, ({ message }) => {
    if (session.failures < things.length) throw things[session.failures];
    throw new Error(message.message);
  });
  const publisher = session.advertise('words', LOG);
  for (let i = 0; i < 100; ++i) publisher.publish({ message: `no ${i}` });
  await until('all have failed', () => session.failures === 100);
  assert.strictEqual(lines.filter((line) => line.includes('"words"')).length, 10);
});

test('WhatWaitsIsWoken', async (t) => {
  const session = open(t);
  const [closed, ended, late] = [session.subscribe('a'), session.subscribe('b'), session.subscribe('d')];
  const first = closed.next();
  const taken = assert.rejects(closed.take(), { code: 'HGROS_CLOSED' });
  closed.close();
  closed.close();
  assert.deepStrictEqual(await first, { value: undefined, done: true });
  await taken;
  const patientTake = assert.rejects(late.take({ timeout: 2 ** 31 }), { code: 'HGROS_CLOSED' });
  await assert.rejects(ended.take({ timeout: 5 }), { code: 'HGROS_TIMED_OUT' });
  const loop = (async () => {
    for await (const received of ended) assert.fail(`${received} came`);
  })();
  session.advertise('c', LOG);
  const waits = assert.rejects(session.waitForSubscribers('c'), { code: 'HGROS_CLOSED' });
  const also = assert.rejects(session.waitForPublishers('c'), { code: 'HGROS_CLOSED' });
  await Promise.all([session.close(), session.close(), loop, waits, also, patientTake]);
});

test('WhatIsClosedSaysSo', async () => {
  const session = hgros.open();
  const publisher = session.advertise('words', LOG);
  const other = session.advertise('others', LOG);
  const transforms = session.transforms();
  other.close();
  other.close();
  assert.throws(() => other.publish({}), { code: 'HGROS_CLOSED', message: 'The publisher is closed.' });
  await session.close();
  for (const use of [() => publisher.publish({}), () => session.subscribe('words'), () => session.peers(),
    () => session.id, () => session.log('info', 'x'), () => transforms.lookup('a', 'b'), () => session.params(),
    () => publisher.loan(5), () => session.serve('s', LOG, LOG, () => ({}))]) {
    assert.throws(use, { code: 'HGROS_CLOSED' });
  }
  await assert.rejects(publisher.publishWait({}), { code: 'HGROS_CLOSED' });
  await assert.rejects(session.call('s', LOG, LOG, {}), { code: 'HGROS_CLOSED' });
  publisher.close();
  await transforms.close();
});

test('ErrorsSayWhatIsWrong', async (t) => {
  const wrong = (code, message) => ({ name: 'HgrosError', code, message });
  assert.throws(() => hgros.open('sesion: {}'), wrong('HGROS_CONFIG_ERROR', /1:1.*"sesion"/));
  assert.throws(() => hgros.openFiles(['/no/such.yaml']), wrong('HGROS_CONFIG_ERROR', /\/no\/such\.yaml/));
  const session = open(t, { name: 'robot' });
  assert.strictEqual(session.name, 'robot');
  const invalid = (message) => wrong('HGROS_INVALID_ARGUMENT', message);
  assert.throws(() => session.subscribe('x', LOG, { keepall: 1 }), invalid(/"keepall".*keepAll/));
  assert.throws(() => session.subscribe('x', LOG, { keepAll: -1 }), invalid(/keepAll is -1/));
  assert.throws(() => session.subscribe(5), invalid(/channel's name is 5/));
  assert.throws(() => session.advertise('x', class {}), invalid(/protobufjs/));
  assert.throws(() => session.advertise('', LOG), wrong('HGROS_ERROR', /name/));
  const publisher = session.advertise('x', LOG);
  assert.throws(() => session.advertise('x', 'foxglove.PoseInFrame'), wrong('HGROS_TYPE_MISMATCH', /foxglove\.Log/));
  assert.throws(() => publisher.publish({ mesage: 'a' }), wrong('HGROS_NOT_WRITABLE', /"mesage".*message/));
  assert.throws(() => publisher.publish({ timestamp: 5 }), wrong('HGROS_NOT_WRITABLE', /timestamp/));
  assert.throws(() => publisher.publish(undefined), wrong('HGROS_NOT_WRITABLE', /undefined/));
  await assert.rejects(publisher.publishWait({}, { timeout: -1 }), invalid(/timeout is -1/));
  const subscription = session.subscribe('words', LOG);
  session.advertise('words', hgros.Schema.known(LOG)).publish(Buffer.from([0xff, 0xff]));
  const received = await subscription.take(patient);
  assert.throws(() => received.message, wrong('HGROS_NOT_WRITABLE', /foxglove\.Log/));
});

test('TheLogComesToAFunction', async (t) => {
  const lines = [];
  const session = open(t, { name: 'logger', log: (level, line) => lines.push(`${level} ${line}`) });
  session.log('warning', 'It rains.');
  session.setLogLevel('error');
  session.log('warning', 'It pours.');
  session.log('error', 'It floods.');
  await until('the last line has come', () => lines.includes('error It floods.'));
  assert.ok(lines.includes('warning It rains.') && !lines.includes('warning It pours.'));
});

test('OtherWorkHasItsTurnWhileMessagesCome', async (t) => {
  const session = open(t);
  const subscription = session.subscribe('words', LOG, { keepAll: 1000 });
  const publisher = session.advertise('words', LOG);
  let turns = 0;
  const interval = setInterval(() => { ++turns; }, 0);
  const publish = async () => {
    while (turns < 20) await publisher.publishWait({ message: 'x' }, patient);
    subscription.close();
  };
  const published = publish();
  for await (const { message } of subscription) assert.strictEqual(message.message, 'x');
  await published;
  clearInterval(interval);
});

const WRONG = [
  [{ timestamp: { secs: 5 } }, /no field "timestamp\.secs"; the fields are seconds, nanos/],
  [{ timestamp: { seconds: 'soon' } }, /"timestamp\.seconds" is "soon"/],
  [{ timestamp: { seconds: 1.5 } }, /"timestamp\.seconds" is 1\.5/],
  [{ timestamp: new Date() }, /"timestamp" is a Date/],
  [{ level: 'WARNNG' }, /"level" is "WARNNG".*WARNING/],
  [{ level: 2.5 }, /"level" is 2\.5/],
  [{ line: -1 }, /"line" is -1, but must be a whole number from 0 to 4294967295/],
  [{ line: 1e20 }, /"line" is 1/],
  [{ line: NaN }, /"line" is NaN/],
  [{ line: true }, /"line" is true/],
  [{ message: {} }, /"message" is .*must be a text/],
  [{ message: '\ud800' }, /"message" is not well-formed/],
];

test('ValuesThatWouldBeWrittenAsOthersAreRefused', async (t) => {
  const publisher = open(t).advertise('values', 'foxglove.Log');
  for (const [message, sentence] of WRONG) {
    assert.throws(() => publisher.publish(message), { code: 'HGROS_NOT_WRITABLE', message: sentence });
  }
  const made = hgros.type('foxglove.Log').create({ line: -1 });
  assert.throws(() => publisher.publish(made), { code: 'HGROS_NOT_WRITABLE', message: /"line" is -1/ });
});

test('ValuesInListsAndMapsAreRefusedWithTheirPlaces', async (t) => {
  const session = open(t);
  const clouds = session.advertise('clouds', 'foxglove.PointCloud');
  const refuses = (publisher, message, sentence) =>
    assert.throws(() => publisher.publish(message), { code: 'HGROS_NOT_WRITABLE', message: sentence });
  refuses(clouds, { fields: [{ name: 'x' }, { nme: 'y' }] }, /no field "fields\[1\]\.nme"/);
  refuses(clouds, { pose: { position: { x: 'far' } } }, /"pose\.position\.x" is "far"/);
  refuses(clouds, { data: [1, 300] }, /"data" has an element that is no byte/);
  const { root } = hgros.protobuf.parse(`syntax = "proto3"; package values;
    message Sizes { map<string, uint32> by_name = 1; bool is_on = 2; }`);
  const sizes = session.advertise('sizes', root.lookupType('values.Sizes'));
  refuses(sizes, { byName: { a: 1, b: -1 } }, /"byName\.b" is -1/);
  refuses(sizes, { isOn: 'false' }, /"isOn" is "false", but must be true or false/);
});

test('ValuesInEveryFormThatFitsAreWritten', async (t) => {
  const session = open(t);
  const subscription = session.subscribe('values', 'foxglove.Log');
  const publisher = session.advertise('values', 'foxglove.Log');
  for (const seconds of [5, 5n, '5', { low: 5, high: 0, unsigned: false }]) {
    publisher.publish({ timestamp: { seconds, nanos: null }, level: 'WARNING', line: 4294967295, name: undefined });
    const { message } = await subscription.take(patient);
    assert.strictEqual(String(message.timestamp.seconds), '5');
    assert.strictEqual(message.level, 3);
    assert.strictEqual(message.line, 4294967295);
    publisher.publish(message);  // What was received may be published again.
    assert.deepStrictEqual((await subscription.take(patient)).message, message);
  }
});

test('TextsWithHalfASurrogatePairAreRefused', async (t) => {
  const session = open(t);
  for (const use of [() => session.log('info', 'a\ud83d'), () => session.subscribe('a\ud83d')]) {
    assert.throws(use, { code: 'HGROS_INVALID_ARGUMENT', message: /surrogate/ });
  }
});
