'use strict';

const native = require('../hgros.node');
const { HgrosError } = require('./errors');

// What native.take() writes about the message that it returns.
const scratch = native.setUp(HgrosError);

module.exports = { native, scratch };
