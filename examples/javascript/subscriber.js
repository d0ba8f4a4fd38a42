// Shows messages of any type with the description that comes with the channel: subscriber.js CHANNEL [COUNT].
'use strict';

const hgros = require('hgros');

async function main() {
  const [channel, count = Infinity] = process.argv.slice(2);
  if (channel === undefined) throw new Error('usage: subscriber.js CHANNEL [COUNT]');
  const session = hgros.open();
  process.once('SIGINT', () => session.close());  // Which ends the loop below.
  let left = Number(count);
  for await (const { message, schema } of session.subscribe(channel, undefined, { keepAll: 100 })) {
    console.log(`${schema.typeName}: ${JSON.stringify(message)}`);
    if (--left === 0) break;
  }
  await session.close();
}

main();
