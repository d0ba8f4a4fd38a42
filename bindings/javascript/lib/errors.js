'use strict';

// The numbers of hgros/c/status.h.
const CODES = {
  1: 'HGROS_INVALID_ARGUMENT',
  2: 'HGROS_ERROR',
  3: 'HGROS_TYPE_MISMATCH',
  4: 'HGROS_CONFIG_ERROR',
  5: 'HGROS_CLOSED',
  6: 'HGROS_FULL',
  7: 'HGROS_TIMED_OUT',
  8: 'HGROS_WOULD_DEADLOCK',
  9: 'HGROS_TOO_LARGE',
  10: 'HGROS_NO_MEMORY',
  11: 'HGROS_NOT_FOUND',
  12: 'HGROS_REFUSED',
  20: 'HGROS_NO_SERVER',
  21: 'HGROS_HANDLER_FAILED',
  22: 'HGROS_SERVER_GONE',
  23: 'HGROS_CANCELLED',
  24: 'HGROS_NOT_WRITABLE',
  30: 'HGROS_UNKNOWN_FRAME',
  31: 'HGROS_NOT_CONNECTED',
  32: 'HGROS_TOO_OLD',
  33: 'HGROS_TOO_NEW',
};

/** What the library refuses. The message is a sentence: what is wrong, where, and how to mend it. */
class HgrosError extends Error {
  /** @param {number|string} code A number of the C interface, or the code's name. */
  constructor(code, sentence) {
    super(sentence);
    this.name = 'HgrosError';
    /** Its name in the C interface, such as 'HGROS_FULL'. */
    this.code = CODES[code] ?? code;
  }
}

/** What a callback has thrown, which need not be an Error, and whose properties may throw in turn. */
function told(thrown, property) {
  try {
    const text = thrown instanceof Error ? thrown[property] ?? thrown.message : thrown;
    return String(text).replaceAll('\0', '');
  } catch {
    return 'It threw something that cannot be told.';
  }
}

const invalid = (sentence) => new HgrosError('HGROS_INVALID_ARGUMENT', sentence);

module.exports = { HgrosError, invalid, told };
