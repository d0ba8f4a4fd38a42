// Compiled only: uses what hgros.d.ts declares as a program does.
import hgros, { open, HgrosError, Received, Schema, Subscription } from 'hgros';

interface Log {
  message: string;
}

export async function use(): Promise<string> {
  const session = open('time: {simulated: false}', { name: 'robot', log: (level, line) => console.error(level, line) });
  const publisher = session.advertise<Log>('words', 'foxglove.Log', { latched: 1 });
  publisher.publish({ message: 'a' });
  await publisher.publishWait({ message: 'b' }, { timeout: 5 });
  // @ts-expect-error
  publisher.publish({ mesage: 'a' });
  const loan = session.advertise('bytes', new Schema('my.bytes')).loan(5);
  loan.data?.fill(1);
  loan.publish();
  const subscription: Subscription<Log> = session.subscribe<Log>('words', hgros.type('foxglove.Log'), { keepAll: 1 });
  for await (const { message, info } of subscription) console.log(message.message.length, info.sequence + 1n);
  session.subscribe('words', undefined, {}, async ({ data }: Received) => console.log(data.length));
  session.serve<Log, Log>('shout', 'foxglove.Log', 'foxglove.Log', ({ message }) => ({ message }));
  const reply = await session.call<Log, Log>('shout', 'foxglove.Log', 'foxglove.Log', { message: 'x' }, {
    signal: new AbortController().signal,
  });
  session.params('a.yaml').declare('speed', 1, { kind: 'integer', least: 0 });
  const speed = Number(await session.paramsOf('robot').integer('speed'));
  session.transforms().set('a', 'b', { translation: [1, 2, speed], stamp: session.now() });
  session.watchPeers(({ event, peer }) => console.log(event === 'came', peer.id)).close();
  try {
    await session.close();
  } catch (error) {
    if (error instanceof HgrosError && error.code === 'HGROS_CLOSED') return error.message;
  }
  return reply.message;
}
