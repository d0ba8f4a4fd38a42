// Publishes five greetings as soon as somebody subscribes.
'use strict';

const hgros = require('hgros');

async function main() {
  const session = hgros.open();
  const publisher = session.advertise('greetings', 'foxglove.Log', { latched: 5 });
  await session.waitForSubscribers('greetings', 1, { timeout: 60000 });
  for (let i = 1; i <= 5; ++i) await publisher.publishWait({ message: `Hello ${i}` });
  console.log('published');
  await session.close();
}

main();
