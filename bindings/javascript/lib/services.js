'use strict';

const { HgrosError, invalid, told } = require('./errors');
const { native } = require('./native');
const { Schema } = require('./schema');

/** A service that is offered until it or its session is closed. */
class Service {
  #external;
  #closing;

  constructor(session, name, request, reply, mostWaiting, handler) {
    const handle = async (number, data) => {
      try {
        native.reply(number, reply.encode(await handler(request.decode(data))));
      } catch (error) {
        native.fail(number, told(error, 'message') || 'The handler failed.');
      }
    };
    this.#external = native.serve(session, name, Schema.externalOf(request.schema), Schema.externalOf(reply.schema),
      mostWaiting, handle);
  }

  /** Requests that wait fail. Waits for the running handlers. */
  close() {
    this.#closing ??= Promise.resolve(native.closeService(this.#external));
    return this.#closing;
  }
}

/** Calls a service. The promise settles with the reply, or with an HgrosError. */
function call(session, name, requestForm, replyForm, request, timeout, signal) {
  if (signal !== undefined && !(signal instanceof AbortSignal)) throw invalid('The signal must be an AbortSignal.');
  const bytes = requestForm.encode(request);
  return new Promise((resolve, reject) => {
    let pending;
    const cancel = () => native.cancelCall(pending);
    const done = (error, data) => {
      pending = undefined;  // Until now it was held here.
      signal?.removeEventListener('abort', cancel);
      if (error !== undefined) {
        reject(signal?.aborted && error.code === 'HGROS_CANCELLED' ? abortedBy(signal, error) : error);
        return;
      }
      try {
        resolve(replyForm.decode(data));
      } catch (unreadable) {
        reject(unreadable);
      }
    };
    if (signal?.aborted) throw abortedBy(signal, new HgrosError('HGROS_CANCELLED', 'The call was cancelled.'));
    pending = native.call(session, name, Schema.externalOf(requestForm.schema), bytes,
      Schema.externalOf(replyForm.schema), timeout, done);
    signal?.addEventListener('abort', cancel, { once: true });
  });
}

function abortedBy(signal, error) {
  error.cause = signal.reason;
  return error;
}

module.exports = { Service, call };
