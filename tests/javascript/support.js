'use strict';

const { spawn } = require('child_process');
const { once } = require('events');
const { beforeEach } = require('node:test');
const readline = require('readline');

const hgros = require('hgros');

const PATIENCE = 45000;
const patient = { timeout: PATIENCE };

let tests = 0;
beforeEach((t) => {
  process.env.HGROS_DOMAIN = `js-${process.pid}-${++tests}`;
  console.error(t.name);  // If it ends the process.
});

/** A session that is closed after the test. */
function open(t, options, yaml) {
  const session = hgros.open(yaml, options);
  t.after(() => session.close());
  return session;
}

/** Two sessions, and a publisher that has its subscriber. */
async function pair(t, type, options = {}) {
  const from = open(t);
  const to = open(t);
  const subscription = to.subscribe('words', options.receivedAs ?? type, options.subscribe ?? { keepAll: 10 });
  const publisher = from.advertise('words', type);
  await from.waitForSubscribers('words', 1, patient);
  return { from, to, subscription, publisher };
}

async function until(what, holds) {
  for (const end = Date.now() + PATIENCE; !(await holds());) {
    if (Date.now() > end) throw new Error(`${what} did not hold in time`);
    await new Promise((resolve) => setTimeout(resolve, 2));
  }
}

/** A running program with its lines of output; it is ended after the test. */
class Program {
  constructor(t, command, environment = {}) {
    this.child = spawn(command[0], command.slice(1), {
      env: { ...process.env, ...environment }, stdio: ['pipe', 'pipe', 'pipe'], timeout: 2 * PATIENCE,
    });
    this.errors = '';
    this.child.stderr.on('data', (data) => { this.errors += data; });
    this.ended = once(this.child, 'close');
    this.lines = readline.createInterface({ input: this.child.stdout })[Symbol.asyncIterator]();
    t.after(() => this.child.kill('SIGKILL'));
  }

  static script(t, code, environment) {
    return new Program(t, [process.execPath, '--expose-gc', '-e', code], environment);
  }

  async line() {
    const { value } = await this.lines.next();
    return value;
  }

  /** Its exit code, after its standard input has been closed. */
  async end() {
    this.child.stdin.end();
    const [code, signal] = await this.ended;
    return signal ?? code;
  }
}

module.exports = { PATIENCE, patient, open, pair, until, Program };
