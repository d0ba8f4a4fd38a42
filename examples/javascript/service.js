// Serves the square root of a number, and calls it twice: once with a number that has none.
'use strict';

const hgros = require('hgros');

const { root } = hgros.protobuf.parse('syntax = "proto3"; package example; message Number { double value = 1; }');
const Num = root.lookupType('example.Number');

async function main() {
  const session = hgros.open();
  session.serve('root', Num, Num, async ({ value }) => {
    if (value < 0) throw new Error('there is no root of a number below zero');
    return { value: Math.sqrt(value) };
  });
  for (const value of [16, -1]) {
    try {
      const reply = await session.call('root', Num, Num, { value }, { timeout: 60000 });
      console.log(`The root of ${value} is ${reply.value}`);
    } catch (error) {
      if (error.code !== 'HGROS_HANDLER_FAILED') throw error;
      console.log(error.message);
    }
  }
  await session.close();
}

main();
