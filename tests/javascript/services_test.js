'use strict';

const assert = require('assert');
const test = require('node:test');

const hgros = require('hgros');
const { open, patient, until } = require('./support');

const LOG = 'foxglove.Log';

const say = (session, name, message, options = patient) => session.call(name, LOG, LOG, { message }, options);

/** Waits until another session's service is known. */
function known(session, name) {
  return until('the service is known',
    () => say(session, name, 'hello').then(() => true, (error) => error.code !== 'HGROS_NO_SERVER'));
}

test('ServicesReplyAndFail', async (t) => {
  const server = open(t);
  const client = open(t);
  const missing = assert.rejects(say(client, 'nobody', ''), { code: 'HGROS_NO_SERVER', message: /nobody/ });
  server.serve('shout', LOG, LOG, async ({ message }) => {
    if (message === 'throw') throw new Error('I have no voice');
    if (message === 'text') throw 'only a text';
    if (message === 'wrong') return { volume: 5 };
    await new Promise(setImmediate);
    return { message: message.toUpperCase() };
  });
  await known(client, 'shout');
  assert.strictEqual((await say(client, 'shout', 'hello')).message, 'HELLO');
  assert.strictEqual((await say(server, 'shout', 'here')).message, 'HERE');
  for (const [word, sentence] of [['throw', /I have no voice/], ['text', /only a text/], ['wrong', /"volume"/]]) {
    await assert.rejects(say(client, 'shout', word), { code: 'HGROS_HANDLER_FAILED', message: sentence });
  }
  await missing;
});

test('CallsTimeOutAndAreCancelled', async (t) => {
  const server = open(t);
  const client = open(t);
  let goOn;
  const gate = new Promise((resolve) => { goOn = resolve; });
  server.serve('sleep', LOG, LOG, ({ message }) => (message === 'hello' ? {} : gate.then(() => ({ message }))));
  await known(client, 'sleep');
  await assert.rejects(say(client, 'sleep', 'long', { timeout: 30 }), { code: 'HGROS_TIMED_OUT' });
  const abort = new AbortController();
  const called = say(client, 'sleep', 'longer', { signal: abort.signal });
  const waits = say(client, 'sleep', 'last');
  abort.abort(new Error('enough'));
  await assert.rejects(called, (error) => error.code === 'HGROS_CANCELLED' && error.cause.message === 'enough');
  await assert.rejects(say(client, 'sleep', '', { signal: abort.signal }), { code: 'HGROS_CANCELLED' });
  await assert.rejects(say(client, 'sleep', '', { signal: abort }), { code: 'HGROS_INVALID_ARGUMENT' });
  goOn();
  assert.strictEqual((await waits).message, 'last');
});

test('AHandlerMayCallAnotherService', async (t) => {
  const session = open(t);
  session.serve('inner', LOG, LOG, ({ message }) => ({ message: `inner ${message}` }));
  session.serve('outer', LOG, LOG, async ({ message }) => say(session, 'inner', message));
  assert.strictEqual((await say(session, 'outer', 'x')).message, 'inner x');
});

test('ClosingDoesNotWaitForAHandlerThatNeverReplies', async (t) => {
  const server = hgros.open();
  const client = open(t);
  let entered;
  const inHandler = new Promise((resolve) => { entered = resolve; });
  server.serve('sleep', LOG, LOG, ({ message }) => {
    if (message === 'hello') return {};
    entered();
    return new Promise(() => {});
  });
  await known(client, 'sleep');
  const failed = assert.rejects(say(client, 'sleep', 'long'),
    (error) => ['HGROS_HANDLER_FAILED', 'HGROS_SERVER_GONE'].includes(error.code));
  await inHandler;
  await server.close();
  await failed;
});

test('AServiceClosesWithARequestThatJavaScriptHasNotSeen', async (t) => {
  const server = open(t);
  const client = open(t);
  let closed;
  const service = server.serve('two', LOG, LOG, ({ message }) => {
    if (message === 'hello') return {};
    setImmediate(() => {  // The reply is on its way, and the next request comes while the event loop is blocked.
      for (const end = Date.now() + 100; Date.now() < end;);
      closed = service.close();
    });
    return {};
  });
  await known(client, 'two');
  const calls = [say(client, 'two', '1'), say(client, 'two', '2')];
  await calls[0];
  await assert.rejects(calls[1], /closed|ended/);
  await closed;
});

test('AClosedServiceIsGone', async (t) => {
  const session = open(t);
  const service = session.serve('once', LOG, LOG, () => ({ message: 'yes' }));
  assert.strictEqual((await say(session, 'once', '')).message, 'yes');
  await Promise.all([service.close(), service.close()]);
  await assert.rejects(say(session, 'once', ''), { code: 'HGROS_NO_SERVER' });
  session.serve('once', LOG, LOG, () => ({ message: 'again' }));
  assert.strictEqual((await say(session, 'once', '')).message, 'again');
  assert.throws(() => session.serve('once', LOG, LOG, () => ({})), { code: 'HGROS_ERROR' });
});

test('RawServicesCarryBytes', async (t) => {
  const session = open(t);
  const bytes = new hgros.Schema('my.bytes');
  session.serve('reverse', bytes, bytes, (data) => Buffer.from(data).reverse());
  const large = Buffer.alloc(1 << 20, 1);
  large[0] = 2;
  const reply = await session.call('reverse', bytes, bytes, large, patient);
  assert.ok(reply.length === 1 << 20 && reply[0] === 1 && reply.at(-1) === 2);
});
