'use strict';

const { invalid } = require('./errors');

// Checks of what a program gives. A mistake is found where it is made.

/** The options, whose names must be known: a mistyped one would be ignored. */
function options(given, known) {
  if (given === undefined) return {};
  if (given === null || typeof given !== 'object') throw invalid(`The options are ${given}, but must be an object.`);
  for (const name of Object.keys(given)) {
    if (!known.includes(name)) throw invalid(`There is no option "${name}". The options are ${known.join(', ')}.`);
  }
  return given;
}

function text(value, what) {
  if (typeof value !== 'string' || value.includes('\0')) {
    throw invalid(`${what} is ${String(value)}, but must be a text without zero bytes.`);
  }
  if (/\p{Surrogate}/u.test(value)) {
    throw invalid(`${what} is ${JSON.stringify(value)}, but has half a surrogate pair, which UTF-8 does not have.`);
  }
  return value;
}

function optionalText(value, what) {
  return value === undefined ? undefined : text(value, what);
}

/** A whole number of 0 or more; undefined is 0. */
function count(value, what) {
  if (value === undefined) return 0;
  if (!Number.isSafeInteger(value) || value < 0) {
    throw invalid(`${what} is ${String(value)}, but must be a whole number of 0 or more.`);
  }
  return value;
}

/** Milliseconds; undefined is for ever. */
function timeout(value) {
  if (value === undefined || value === Infinity) return undefined;
  if (typeof value !== 'number' || !(value >= 0)) {
    throw invalid(`The timeout is ${String(value)}, but must be a number of milliseconds of 0 or more.`);
  }
  return value;
}

/** Nanoseconds as a bigint. */
function time(value, what) {
  if (typeof value !== 'bigint') throw invalid(`${what} is ${String(value)}, but must be a bigint of nanoseconds.`);
  return value;
}

function callback(value, what) {
  if (typeof value !== 'function') throw invalid(`${what} is ${String(value)}, but must be a function.`);
  return value;
}

module.exports = { options, text, optionalText, count, timeout, time, callback };
