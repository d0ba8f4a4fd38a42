'use strict';

const assert = require('assert');
const test = require('node:test');
const { Worker } = require('worker_threads');

const hgros = require('hgros');
const { open, patient, until, Program } = require('./support');

const LOG = 'foxglove.Log';

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
  for (const ending of ['end', 'terminate', 'end']) {
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
