// Publishes five greetings, which nobody has to wait for: the channel keeps the newest ones for late subscribers.
'use strict';

const hgros = require('hgros');

async function main() {
  const session = hgros.open();
  const publisher = session.advertise('greetings', 'foxglove.Log', { latched: 5 });
  for (let i = 1; i <= 5; ++i) await publisher.publishWait({ message: `Hello ${i}` });
  await session.waitForSubscribers('greetings', 1, { timeout: 60000 });
  console.log('published');
  await session.close();
}

main();
