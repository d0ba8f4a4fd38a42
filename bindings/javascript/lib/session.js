'use strict';

const { invalid, told } = require('./errors');
const { native } = require('./native');
const { formOf } = require('./types');
const { Params, RemoteParams } = require('./params');
const { Publisher } = require('./publisher');
const { Schema, ENCODINGS } = require('./schema');
const { Service, call } = require('./services');
const { Subscription } = require('./subscription');
const { Transforms } = require('./transforms');
const { Watch } = require('./watch');
const check = require('./arguments');

const LEVELS = ['debug', 'info', 'warning', 'error'];
const EVENTS = ['came', 'gone', 'typeMismatch', 'servedTwice'];

function levelOf(level) {
  const number = LEVELS.indexOf(level);
  if (number < 0) throw invalid(`The level is ${String(level)}, but must be one of ${LEVELS.join(', ')}.`);
  return number;
}

function channelOf(name) {
  return check.text(name, "The channel's name");
}

/** One participant of the hypergraph, until it is closed. */
class Session {
  #external;
  #closing;
  #subscriptions = new Set();
  #failures = 0;

  constructor(yaml, files, options) {
    const { name, log } = check.options(options, ['name', 'log']);
    this.#external = native.openSession(yaml, files, check.optionalText(name, "The session's name"),
      log === undefined ? undefined : this.#logger(check.callback(log, 'The function of the log')));
  }

  // What the function of the log throws goes to standard error: the log is where it would be reported.
  #logger(log) {
    return (level, line) => {
      try {
        log(LEVELS[level] ?? 'error', line);  // A newer library may have more.
      } catch (error) {
        ++this.#failures;
        console.error('hgros: The function of the log failed:', error, 'The line was:', line);
      }
    };
  }

  /** Runs a callback of the program. What it throws is logged and counted. */
  async guard(what, callback) {
    try {
      await callback();
    } catch (error) {
      ++this.#failures;
      const text = `${what} failed: ${told(error, 'stack')}`.replace(/\s+/g, ' ');
      if (this.#closing === undefined) native.log(this.#external, levelOf('error'), text, what);
    }
  }

  /** The number of exceptions of callbacks. The log has lines about them: ten of a callback, then fewer and fewer. */
  get failures() {
    return this.#failures;
  }

  /** As info.publisher of its messages has it. */
  get id() {
    return native.sessionId(this.#external);
  }

  get name() {
    return native.sessionName(this.#external);
  }

  /** The time of the session's clock in ns. */
  now() {
    return native.sessionNow(this.#external);
  }

  /** Writes a line into the session's log. */
  log(level, line) {
    native.log(this.#external, levelOf(level), check.text(line, 'The line'));
  }

  setLogLevel(level) {
    native.setLogLevel(this.#external, levelOf(level));
  }

  /** Announces a channel of a type. options.latched: the number of recent messages kept for late subscribers. */
  advertise(channel, type, options) {
    const { latched } = check.options(options, ['latched']);
    return new Publisher(this.#external, channelOf(channel), formOf(type), check.count(latched, 'latched'));
  }

  /**
   * Receives a channel of a type, or of any type if that is undefined. The result is to be iterated, unless there is a
   * callback, which gets one message after the other; if it returns a promise, the next one waits for it.
   */
  subscribe(channel, type, options, callback) {
    const chosen = check.options(options, ['name', 'keepLast', 'keepAll', 'keepAllBytes']);
    if (callback !== undefined) check.callback(callback, 'The callback');
    const form = type === undefined || type === null ? undefined : formOf(type);
    const subscription = new Subscription(this.#external, channelOf(channel), form, {
      name: check.optionalText(chosen.name, "The subscription's name"),
      schema: form && Schema.externalOf(form.schema),
      keepLast: check.count(chosen.keepLast, 'keepLast'),
      keepAll: check.count(chosen.keepAll, 'keepAll'),
      keepAllBytes: check.count(chosen.keepAllBytes, 'keepAllBytes'),
    }, (closed) => this.#subscriptions.delete(closed));
    this.#subscriptions.add(subscription);
    if (callback !== undefined) this.#callWithEach(subscription, channel, callback);
    return subscription;
  }

  async #callWithEach(subscription, channel, callback) {
    for await (const received of subscription) {
      await this.guard(`The callback for channel "${channel}"`, () => callback(received));
    }
  }

  /** Waits until a channel that this session publishes has at least `count` subscribers. */
  async waitForSubscribers(channel, count = 1, options) {
    const { timeout } = check.options(options, ['timeout']);
    return native.waitForSubscribers(this.#external, channelOf(channel), check.count(count, 'count'),
      check.timeout(timeout));
  }

  /** Waits until at least `count` other sessions that publish on a channel are connected. */
  async waitForPublishers(channel, count = 1, options) {
    const { timeout } = check.options(options, ['timeout']);
    return native.waitForPublishers(this.#external, channelOf(channel), check.count(count, 'count'),
      check.timeout(timeout));
  }

  /**
   * Offers a service. The handler gets a request and returns the reply, or a promise of it. What it throws becomes the
   * caller's HGROS_HANDLER_FAILED with the same sentence. One request is handled after the other.
   * options.mostWaiting: requests that may wait, 16384 if it is not given; further ones fail with HGROS_FULL.
   */
  serve(name, requestType, replyType, handler, options) {
    const { mostWaiting } = check.options(options, ['mostWaiting']);
    return new Service(this.#external, check.text(name, "The service's name"), formOf(requestType), formOf(replyType),
      check.count(mostWaiting, 'mostWaiting'), check.callback(handler, 'The handler'));
  }

  /** Calls a service. options.timeout is in ms; options.signal cancels the call. */
  async call(name, requestType, replyType, request, options) {
    const { timeout, signal } = check.options(options, ['timeout', 'signal']);
    return call(this.#external, check.text(name, "The service's name"), formOf(requestType), formOf(replyType), request,
      check.timeout(timeout), signal);
  }

  /** The parameters of this program, from YAML files, later ones over earlier ones. */
  params(...files) {
    for (const file of files) check.text(file, "The file's name");
    return new Params(this, native.openParams(this.#external, files));
  }

  /** The parameters that another session offers under its name. Each function waits at most the timeout in ms. */
  paramsOf(name, options) {
    const { timeout = 5000 } = check.options(options, ['timeout']);
    return new RemoteParams(this, native.openParamsOf(this.#external, check.text(name, "The session's name"),
      check.timeout(timeout)));
  }

  /** A session has one at a time. */
  transforms() {
    return new Transforms(this.#external);
  }

  /** The sessions that are connected with this one, at this moment. */
  peers() {
    return native.peers(this.#external);
  }

  /** The channels of all sessions that are known, sorted by name, at this moment. */
  channels() {
    return native.channels(this.#external).map((channel) => ({ ...channel, encoding: ENCODINGS[channel.encoding] }));
  }

  /** Calls a function with each event of other sessions: { event, peer, channel, reason }. */
  watchPeers(happened) {
    check.callback(happened, 'The function for events');
    return new Watch(this, 'The callback for peers', (told) => native.watchPeers(this.#external, told),
      (event, peer, channel, reason) => happened({ event: EVENTS[event] ?? 'unknown', peer, channel, reason }));
  }

  /**
   * Ends all that was made from the session, waits for it, and says goodbye to the other sessions. Inside a handler
   * do not wait for it.
   */
  close() {
    if (this.#closing === undefined) {
      for (const subscription of this.#subscriptions) subscription.close();
      this.#closing = Promise.resolve(native.closeSession(this.#external));
    }
    return this.#closing;
  }
}

/** Opens a session with YAML text. Without any, it finds the sessions of this user on this host. */
function open(yaml, options) {
  return new Session(check.optionalText(yaml, 'The configuration'), undefined, options);
}

/** Opens a session with configuration files, which are merged. */
function openFiles(files, options) {
  if (!Array.isArray(files)) throw invalid('The files must be an array of their names.');
  for (const file of files) check.text(file, "The file's name");
  return new Session(undefined, files, options);
}

module.exports = { open, openFiles, Session };
