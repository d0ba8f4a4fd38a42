// Plain ZeroMQ in Node with docs/wire-protocol.md alone: the test vectors, and a robot (robot.cpp).
//
//     node_test.mjs ROBOT VECTORS MODULES
//
// MODULES is the folder `node_modules` that has zeromq.
import assert from "node:assert/strict";
import {spawn} from "node:child_process";
import {readFileSync, readdirSync} from "node:fs";
import {createRequire} from "node:module";
import {join, resolve} from "node:path";
import {createInterface} from "node:readline";
import {after, before, test} from "node:test";

import * as wire from "./wire.mjs";

const [robotProgram, vectorFolder, modules] = process.argv.slice(2);
const PATIENCE_MS = 30000;

let zmq;
try {
  zmq = createRequire(join(resolve(modules), "x"))("zeromq");
} catch (error) {
  console.log(`skipped: it needs zeromq of npm (./dev interop installs it): ${error.message.split("\n")[0]}`);
  process.exit(77);
}

function* vectors() {
  const names = readdirSync(vectorFolder).filter((name) => name.endsWith(".hex")).sort();
  assert(names.length > 30);
  for (const name of names) {
    const frames = [], expected = {};
    let reader;
    for (const line of readFileSync(join(vectorFolder, name), "utf8").split("\n")) {
      if (line === "" || line.startsWith("#")) continue;
      const colon = line.indexOf(":"), key = line.slice(0, colon), value = line.slice(colon + 1).trim();
      if (["topic", "head", "data"].includes(key)) frames.push(Buffer.from(value, "hex"));
      else if (key === "reader") reader = value;
      else expected[key.replace(/^expect /, "")] = value;
    }
    yield {name, frames, reader, expected};
  }
}

test("vectors are read as expected", () => {
  for (const {name, frames, reader, expected} of vectors()) {
    let packet;
    try {
      packet = wire.readPacket(frames, reader);
    } catch (error) {
      if (!(error instanceof wire.Fault)) throw error;
      assert.deepEqual(expected, {fault: error.message}, name);
      continue;
    }
    const {head, session, message} = packet;
    const found = {...head, ...message, fault: "none", session, key: wire.keyOf(head)};
    for (const [key, value] of Object.entries(expected)) {
      if (["fingerprint", "publisher_id", "cause", "session", "key"].includes(key)) {
        assert.equal(wire.hex(found[key]), value, `${name} ${key}`);
      } else if (["x", "y", "z"].includes(key)) {
        assert.equal(found[key], Number(value), `${name} ${key}`);
      } else {
        assert.equal(key === "data" ? found[key].toString("hex") : String(found[key]), value, `${name} ${key}`);
      }
    }
  }
});

test("vectors are written byte for byte", () => {
  let written = 0;
  for (const {name, frames, reader, expected} of vectors()) {
    if (expected.fault !== "none") continue;
    // Field by field, in the order of the vector.
    const raw = wire.readFields(wire.readHeadFrame(frames[1]));
    assert.deepEqual(wire.writeHeadFrame(wire.writeFields(raw)), frames[1], name);
    assert.deepEqual(wire.writeFields(wire.readFields(frames[2])), frames[2], name);
    // From its values, as the library writes a head.
    const {head, session, message} = wire.readPacket(frames, reader);
    if (!["good_fields_reordered.hex", "good_unknown_fields.hex", "good_release_head.hex"].includes(name)) {
      assert.deepEqual(wire.writePacket(head, frames[2], session), frames, name);
      ++written;
    }
    if (reader !== "foxglove.Vector3") continue;
    assert.deepEqual(wire.writeMessage(wire.TYPES[reader], message), frames[2], name);
  }
  assert(written > 10);
});

const WHEEL = {
  type: "hgros_test::Wheel", encoding: wire.PLAIN,
  fingerprint: wire.fingerprint(["plain 1", "hgros_test::Wheel", "little", "12 4", "{12/4:f4,[4*s2]}"]),
};
const LOG = {
  type: "foxglove.Log", encoding: wire.PROTOBUF,
  fingerprint: wire.fingerprint([
    "protobuf 1 foxglove.Log",
    "message foxglove.Log", "1 optional message google.protobuf.Timestamp timestamp",
    "2 optional enum foxglove.Log.Level level", "3 optional string message", "4 optional string name",
    "5 optional string file", "6 optional fixed32 line",
    "enum foxglove.Log.Level", "0 UNKNOWN", "1 DEBUG", "2 INFO", "3 WARNING", "4 ERROR", "5 FATAL",
    "message google.protobuf.Timestamp", "1 optional int64 seconds", "2 optional int32 nanos"]),
};

const logData = (message) => wire.writeMessage(wire.TYPES["foxglove.Log"], {message});

function wheelData(speed, ticks) {
  const data = Buffer.alloc(12);
  data.writeFloatLE(speed);
  ticks.forEach((tick, i) => data.writeInt16LE(tick, 4 + 2 * i));
  return data;
}

// A robot that knows of this program only its ZeroMQ endpoint.
let robot, robotLines, endpoint, publisher, watch;

before(async () => {
  publisher = new zmq.XPublisher();
  await publisher.bind("tcp://127.0.0.1:*");
  robot = spawn(robotProgram, [publisher.lastEndpoint], {stdio: ["pipe", "pipe", "inherit"]});
  watch = setTimeout(() => robot.kill("SIGKILL"), PATIENCE_MS); // Then no more lines come, and the tests fail.
  robotLines = createInterface({input: robot.stdout})[Symbol.asyncIterator]();
  endpoint = (await nextLine()).split(" ")[1];
});

after(async () => {
  clearTimeout(watch);
  robot.stdin.end();
  const code = robot.exitCode ?? await new Promise((resolved) => robot.on("exit", resolved));
  publisher.close();
  assert.equal(code, 0);
});

async function nextLine() {
  const {value, done} = await robotLines.next();
  assert(!done, "the robot has ended");
  return value;
}

// The packets of each channel, until there are two. The robot publishes again and again: the first messages go out
// before it has read the subscriptions.
async function receive(channels) {
  const subscriber = new zmq.Subscriber({receiveTimeout: PATIENCE_MS});
  subscriber.connect(endpoint);
  for (const channel of channels) subscriber.subscribe(channel + "\0");
  const packets = Object.fromEntries(channels.map((channel) => [channel, []]));
  const again = setInterval(() => robot.stdin.write("\n"), 100);
  try {
    while (Object.values(packets).some((some) => some.length < 2)) {
      assert(robot.exitCode === null && robot.signalCode === null, "the robot has ended");
      const frames = await subscriber.receive();
      packets[wire.readTopic(frames[0])[0]].push(frames);
    }
  } finally {
    clearInterval(again);
    subscriber.close();
  }
  return packets;
}

test("subscribes to every kind of message", async () => {
  const kinds = { // type, encoding, fingerprint if it is known here
    "text": ["foxglove.Log", wire.PROTOBUF, LOG.fingerprint],
    "echo": ["foxglove.Log", wire.PROTOBUF, LOG.fingerprint],
    "cloud": ["foxglove.PointCloud", wire.PROTOBUF],
    "wheel": ["hgros_test::Wheel", wire.PLAIN, WHEEL.fingerprint],
    "mark": ["test.Mark", wire.CUSTOM, 0n],
    "block": ["hgros.Block", wire.CUSTOM, 0n],
    "clock": ["hgros.SimulatedTime", wire.PROTOBUF],
    "params/robot/state": ["hgros.ParamsState", wire.PROTOBUF],
    "hgros/snapshots": ["hgros.Snapshot", wire.PROTOBUF, 0n],
    "hgros/trace": ["hgros.Trace", wire.PROTOBUF, 0n],
  };
  const packets = await receive(Object.keys(kinds));
  const heads = {}, last = {};
  for (const [channel, [type, encoding, fingerprint]] of Object.entries(kinds)) {
    const read = packets[channel].map((frames) => wire.readPacket(frames, type, encoding));
    heads[channel] = read.map(({head}) => head);
    last[channel] = read.at(-1).message;
    for (const {head, session} of read) {
      assert.deepEqual([head.version, head.type, head.encoding, session], [wire.VERSION, type, encoding, 0n]);
      if (fingerprint !== undefined) assert.equal(head.fingerprint, fingerprint, channel);
      assert.notEqual(head.publisher_id, 0n);
      assert(Math.abs(Number(head.publish_time_ns / 1000000n) - Date.now()) < 60000);
    }
    heads[channel].forEach((head, i) => assert.equal(head.sequence, heads[channel][0].sequence + BigInt(i), channel));
  }
  assert.deepEqual(last.text, {message: "hello"});
  assert.deepEqual(last.echo, {message: "echo of hello"});
  assert.deepEqual(last.cloud, {
    frame_id: "lidar", point_stride: 4, data: Buffer.from(Array.from({length: 1000}, (_, i) => i & 255)),
  });
  assert.deepEqual(last.wheel, wheelData(1.5, [1, -2, 3, -4]));
  assert.equal(last.mark.toString(), "a mark");
  assert.deepEqual(last.block, Buffer.from([0, 1, 254, 255]));
  assert(heads.text.every((head) => head.latched === 2));
  // The text caused the echo.
  assert(heads.text.map(wire.keyOf).includes(heads.echo.at(-1).cause));
  assert.equal(heads.echo.at(-1).chain_origin, wire.originOf("text"));
  assert.equal(heads.text.at(-1).cause, 0n);
});

test("publishes every kind of message", async () => {
  const waiting = new Set(["text", "cloud", "wheel", "mark", "block"].map((kind) => `\x01in/${kind}\0`));
  publisher.receiveTimeout = PATIENCE_MS;
  while (waiting.size > 0) waiting.delete((await publisher.receive())[0].toString("latin1"));

  const send = (channel, data, head) =>
    publisher.send(wire.writePacket({version: wire.VERSION, channel, ...head}, data));
  const numbered = {publisher_id: 0xabn, incarnation: 1n, publish_time_ns: BigInt(Date.now()) * 1000000n};
  const channelOnly = wire.writeHeadFrame(Buffer.from("\x12\x07in/text"));
  const topic = Buffer.from("in/text\0");
  await send("in/text", logData("one"), {...LOG, ...numbered, sequence: 1n});
  await send("in/text", logData("a repeat"), {...LOG, ...numbered, sequence: 1n});
  await send("in/text", logData("of another type"), {...LOG, ...numbered, type: "foxglove.Pose", sequence: 2n});
  await publisher.send([topic, channelOnly, logData("two")]);
  await publisher.send([topic, Buffer.from("no head"), logData("faulty")]);
  await publisher.send([topic, channelOnly, logData("faulty"), Buffer.alloc(0)]);
  await send("in/text", logData("three"), {...numbered, sequence: 3n});
  // The large field first: readers rely on no order.
  const cloud = wire.writeFields([
    {number: 6, wireType: 2, value: Buffer.alloc(500)}, {number: 2, wireType: 2, value: Buffer.from("lidar")}]);
  await send("in/cloud", cloud, {type: "foxglove.PointCloud", encoding: wire.PROTOBUF});
  await send("in/wheel", wheelData(9.5, [1, 2, 3, 4]), {...WHEEL, fingerprint: 1n});
  await send("in/wheel", wheelData(2.5, [1, 2, 3, -7]), WHEEL);
  await send("in/mark", Buffer.from("a mark"), {type: "test.Mark", encoding: wire.CUSTOM});
  await send("in/block", Buffer.alloc(7), {type: "hgros.Block", encoding: wire.CUSTOM});
  // Each channel has an order of its own.
  const took = [];
  while (took.length < 7) took.push(await nextLine());
  assert.deepEqual(took.filter((line) => line.includes("in/text")),
    ["took in/text one", "took in/text two", "took in/text three"]);
  assert.deepEqual(took.filter((line) => !line.includes("in/text")).sort(),
    ["took in/block 7 bytes", "took in/cloud 500 bytes", "took in/mark a mark", "took in/wheel 2.500000 -7"]);
});
