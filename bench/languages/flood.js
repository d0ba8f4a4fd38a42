'use strict';

// Receives as many messages as its argument says in a callback, and prints how many came per second.
const hgros = require('hgros');

const flood = Number(process.argv[2]);
const session = hgros.open();
let received = 0;
let begin;
const subscription = session.subscribe('flood', 'foxglove.LaserScan', { keepAll: 1000 }, ({ message }) => {
  if (message.startAngle !== received) {
    console.error(`message ${message.startAngle} came in place of ${received}`);
    process.exit(1);
  }
  if (received++ === 0) begin = process.hrtime.bigint();
  if (received < flood) return;
  console.log(Math.round(flood / (Number(process.hrtime.bigint() - begin) / 1e9)));
  subscription.close();
});
