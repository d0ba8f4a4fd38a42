'use strict';

const assert = require('assert');
const test = require('node:test');

const hgros = require('hgros');
const { open, patient } = require('./support');

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
