'use strict';

const assert = require('assert');
const path = require('path');
const test = require('node:test');
const { Worker } = require('worker_threads');

const hgros = require('hgros');
const { open, patient, until, Program } = require('./support');

const LOG = 'foxglove.Log';
const COMMAND = process.env.HGROS_COMMAND;
const PEER = [process.execPath, path.join(__dirname, '../interop/javascript/peer.js')];

/** What each program of these tests begins with. */
const BEGIN = `
  const hgros = require('hgros');
  const session = hgros.open();
  const say = (line) => console.log(line);
`;

test('AProgramEndsWhenNothingIsWaitedFor', async (t) => {
  const subscription = open(t).subscribe('words', LOG, { keepAll: 10 });
  const program = Program.script(t, `${BEGIN}
    session.subscribe('nothing');
    session.watchPeers(() => {}).close();
    const publisher = session.advertise('words', 'foxglove.Log');
    session.waitForSubscribers('words').then(() => {
      publisher.publish({ message: 'last words' });
      session.serve('s', 'foxglove.Log', 'foxglove.Log', () => ({})).close();
    });`);
  assert.strictEqual((await subscription.take(patient)).message.message, 'last words');
  assert.strictEqual((await program.ended)[0], 0);
  assert.strictEqual(program.errors, '');
});

test('AProgramStaysWhileSomethingIsWaitedFor', async (t) => {
  const session = open(t);
  const publisher = session.advertise('words', LOG);
  const waiting = `${BEGIN}
    session.subscribe('words', 'foxglove.Log').next().then(({ value }) => say(value.message.message));
    say('waits');`;
  const serving = `${BEGIN}
    session.serve('s', 'foxglove.Log', 'foxglove.Log', ({ message }) => { setImmediate(() => session.close());
      return { message: 're: ' + message }; });
    say('waits');`;
  const waits = Program.script(t, waiting);
  const serves = Program.script(t, serving);
  assert.strictEqual(await waits.line(), 'waits');
  assert.strictEqual(await serves.line(), 'waits');
  await session.waitForSubscribers('words', 1, patient);
  publisher.publish({ message: 'go' });
  assert.strictEqual(await waits.line(), 'go');
  assert.strictEqual((await waits.ended)[0], 0);
  let reply;
  await until('the service is known', async () => {
    reply = await session.call('s', LOG, LOG, { message: 'x' }, patient).catch((error) => error);
    return reply.code !== 'HGROS_NO_SERVER';
  });
  assert.strictEqual((await serves.ended)[0], 0);
});

test('ExitInTheMiddleIsClean', async (t) => {
  const session = open(t);
  const program = Program.script(t, `${BEGIN}
    const LOG = 'foxglove.Log';
    const large = session.subscribe('large', LOG, { keepAll: 1 });
    session.subscribe('words', LOG, {}, () => {});
    const publisher = session.advertise('full', LOG);
    session.subscribe('full', LOG, { keepAll: 1 });
    for (let i = 0; i < 5; ++i) publisher.publishWait({ message: String(i) });
    session.waitForPublishers('nobody');
    session.watchPeers(() => {});
    session.params().watch('', () => {});
    session.serve('exit', LOG, LOG, () => new Promise(() => { setImmediate(() => process.exit(7)); }));
    session.call('exit', LOG, LOG, {});
    session.call('exit', LOG, LOG, {});`);
  const [code, signal] = await program.ended;
  assert.deepStrictEqual([code, signal], [7, null], program.errors);
  assert.strictEqual(session.peers().length, 0);
});

test('AnUncaughtErrorEndsTheProgram', async (t) => {
  const program = Program.script(t, `${BEGIN}
    session.subscribe('words', undefined, { keepAll: 5 });
    session.advertise('words', 'foxglove.Log').publish({ message: 'x' });
    setImmediate(() => { throw new Error('on purpose'); });`);
  assert.strictEqual((await program.ended)[0], 1);
  assert.match(program.errors, /on purpose/);
});

const IN_WORKER = `
  const { parentPort } = require('worker_threads');
  const hgros = require('hgros');
  const session = hgros.open();
  const subscription = session.subscribe('to', 'foxglove.PointCloud', { keepAll: 10 });
  const publisher = session.advertise('from', 'foxglove.Log');
  session.serve('in_worker', 'foxglove.Log', 'foxglove.Log', () => new Promise(() => {}));
  (async () => {
    const kept = [];  // Leases that are not given back.
    await session.waitForSubscribers('from');
    parentPort.postMessage('ready');
    for await (const { message } of subscription) {
      if (message.data.length === 0) break;
      kept.push(message.data);
      await publisher.publishWait({ message: String(message.data.length) });
    }
    await session.close();
  })();`;

test('WorkerThreadsHaveSessionsOfTheirOwn', async (t) => {
  const session = open(t);
  const subscription = session.subscribe('from', LOG, { keepAll: 10 });
  const publisher = session.advertise('to', 'foxglove.PointCloud');
  for (const ending of ['terminate', 'end', 'terminate', 'end']) {
    const worker = new Worker(IN_WORKER, { eval: true });
    const ended = new Promise((resolve, reject) => worker.on('exit', resolve).on('error', reject));
    await new Promise((resolve) => worker.once('message', resolve));
    await session.waitForSubscribers('to', 1, patient);
    for (const size of [100, 1 << 20]) {
      await publisher.publishWait({ data: Buffer.alloc(size, 1) }, patient);
      assert.strictEqual((await subscription.take(patient)).message.message, String(size));
    }
    const called = session.call('in_worker', LOG, LOG, {}, patient).catch((error) => error.code);
    if (ending === 'terminate') await worker.terminate();
    else await publisher.publishWait({ data: Buffer.alloc(0) }, patient);
    await ended;
    assert.ok(['HGROS_HANDLER_FAILED', 'HGROS_SERVER_GONE', 'HGROS_NO_SERVER'].includes(await called));
    await until('the session of the worker is gone', () => session.peers().length === 0);
  }
});

test('TheProgramMayExitWhileAWorkerRuns', async (t) => {
  const session = open(t);
  session.subscribe('from', LOG);
  const program = Program.script(t, `
    const { Worker } = require('worker_threads');
    const worker = new Worker(${JSON.stringify(IN_WORKER)}, { eval: true });
    const session = require('hgros').open();
    worker.on('message', () => process.exit(5));`);
  const [code, signal] = await program.ended;
  assert.deepStrictEqual([code, signal], [5, null], program.errors);
  await until('its sessions are gone', () => session.peers().length === 0);
});

test('ModulesImportThePackage', async (t) => {
  const { pathToFileURL } = require('url');
  const module = pathToFileURL(require.resolve('hgros').replace(/index\.js$/, 'index.mjs'));
  const program = new Program(t, [process.execPath, '--input-type=module', '-e', `
    import hgros, { open, type, Schema } from '${module}';
    const session = open();
    console.log(hgros.open === open, type('foxglove.Log').name, Schema.known('foxglove.Log').encoding);
    await session.close();`]);
  assert.strictEqual(await program.line(), 'true Log protobuf');
  assert.strictEqual((await program.ended)[0], 0, program.errors);
});

test('TheCommandSeesAndPublishesMessages', async (t) => {
  const session = open(t);
  const publisher = session.advertise('words', LOG, { latched: 1 });
  publisher.publish({ message: 'from JavaScript', level: 'ERROR' });
  const echo = new Program(t, [COMMAND, 'echo', 'words', '--once', '--json']);
  const line = await echo.line();
  assert.match(line, /from JavaScript/);
  assert.match(line, /ERROR/);
  const subscription = session.subscribe('answers', undefined, { keepAll: 5 });
  const pub = new Program(t, [COMMAND, 'pub', 'answers', '{message: "from the command", timestamp: {seconds: 5}}',
    '--type', LOG, '--timeout', '40']);
  const { message, schema } = await subscription.take(patient);
  assert.strictEqual(message.message, 'from the command');
  assert.strictEqual(schema.typeName, LOG);
  assert.strictEqual(await pub.end(), 0, pub.errors);
});

test('TheCommandCallsAService', async (t) => {
  const session = open(t);
  session.serve('shout', LOG, LOG, ({ message }) => ({ message: message.toUpperCase() }));
  const call = new Program(t, [COMMAND, 'call', 'shout', '{message: hello}', '--json', '--timeout', '40']);
  assert.match(await call.line(), /HELLO/);
  assert.strictEqual(await call.end(), 0, call.errors);
});

/** Two peers for tests between languages: their roles with arguments, and the lines that they print. */
async function peers(t, first, second, afterFirst) {
  const one = new Program(t, [...PEER, ...first.role]);
  if (afterFirst !== undefined) assert.strictEqual(await one.line(), afterFirst);
  const two = new Program(t, [...PEER, ...second.role]);
  for (const line of second.lines) assert.strictEqual(await two.line(), line, two.errors);
  for (const line of first.lines) assert.strictEqual(await one.line(), line, one.errors);
  assert.deepStrictEqual([await one.end(), await two.end()], [0, 0]);
}

test('PeersPublishAndSubscribe', (t) => peers(t, { role: ['publish', 'c', '500'], lines: ['published 500'] },
  { role: ['subscribe', 'c', '500'], lines: ['subscribed', 'received 500'] }));

test('PeersLatch', (t) => peers(t, { role: ['latch', 'c', 'still here'], lines: [] },
  { role: ['late', 'c'], lines: ['late still here'] }, 'latched'));

test('PeersSendBulk', (t) => peers(t, { role: ['bulk-publish', 'c', '4000000'], lines: ['published 4000000'] },
  { role: ['bulk-subscribe', 'c', '4000000'], lines: ['subscribed', 'received 4000000'] }));

test('PeersServeAndCall', async (t) => {
  const server = new Program(t, [...PEER, 'serve', 's']);
  assert.strictEqual(await server.line(), 'serving');
  for (const [text, answer] of [['hi', 'answer re: hi'], ['fail', 'failed asked to fail']]) {
    const caller = new Program(t, [...PEER, 'call', 's', text]);
    assert.strictEqual(await caller.line(), answer);
    assert.strictEqual(await caller.end(), 0);
  }
  assert.strictEqual(await server.end(), 0);
});

test('APeerPlaysOneRoleAfterTheOther', async (t) => {
  const [one, two] = [new Program(t, [...PEER, 'talk']), new Program(t, [...PEER, 'talk'])];
  assert.deepStrictEqual([await one.line(), await two.line()], ['ready', 'ready']);
  for (const channel of ['a', 'b']) {
    one.child.stdin.write(`\npublish ${channel} 50\n`);
    two.child.stdin.write(`subscribe ${channel} 50\n`);
    assert.strictEqual(await two.line(), 'subscribed');
    assert.strictEqual(await two.line(), 'received 50');
    assert.strictEqual(await one.line(), 'published 50');
  }
  assert.deepStrictEqual([await one.end(), await two.end()], [0, 0]);
});

test('PeersReportAMisfit', async (t) => {
  const latch = new Program(t, [...PEER, 'latch', 'c', 'x']);
  const misfit = new Program(t, [...PEER, 'misfit', 'c']);
  assert.strictEqual(await misfit.line(), 'subscribed');
  await until('the log names both types', () => [LOG, 'foxglove.PoseInFrame'].every((name) =>
    misfit.errors.includes(name)));
  assert.deepStrictEqual([await latch.end(), await misfit.end()], [0, 0]);
});

test('PeersSurviveEachOthersDeath', async (t) => {
  const stream = new Program(t, [...PEER, 'stream', 'c']);
  const killed = new Program(t, [...PEER, 'follow', 'c']);
  assert.strictEqual(await killed.line(), 'following');
  killed.child.kill('SIGKILL');
  const follow = new Program(t, [...PEER, 'follow', 'c']);
  assert.strictEqual(await follow.line(), 'following');
  assert.strictEqual(await stream.line(), 'streaming');
  stream.child.kill('SIGKILL');
  const again = new Program(t, [...PEER, 'stream', 'c']);
  assert.strictEqual(await again.line(), 'streaming');
  assert.strictEqual(await follow.end(), 0, follow.errors);
  assert.strictEqual(await again.end(), 0, again.errors);
  assert.match(await follow.line(), /^followed \d+$/);
  assert.match(await again.line(), /^streamed \d+$/);
});
