'use strict';

const { HgrosError } = require('./lib/errors');
const { native } = require('./lib/native');
const { open, openFiles, Session } = require('./lib/session');
const { Schema } = require('./lib/schema');
const { protobuf, type } = require('./lib/types');

module.exports = {
  open,
  openFiles,
  type,
  Session,
  Schema,
  HgrosError,
  /** The number of messages of this process whose memory is not given back yet. */
  leases: () => native.leases(),
  /** The version of the library. */
  version: native.version(),
  /** The protobuf library whose types this package makes. */
  get protobuf() {
    return protobuf();
  },
};
