"""Plain ZeroMQ in Python with docs/wire-protocol.md alone: the test vectors, and a robot (robot.cpp).

    python_test.py ROBOT VECTORS [ARGUMENTS OF UNITTEST]
"""

import pathlib
import struct
import subprocess
import sys
import time
import unittest

import wire

try:
    import zmq
except ImportError:
    print("skipped: it needs python3-zmq (./dev setup test)")
    sys.exit(77)

PATIENCE_S = 30


class VectorsTest(unittest.TestCase):
    def load(self, path):
        frames, reader, expected = [], None, {}
        for line in path.read_text(encoding="utf-8").splitlines():
            if not line or line.startswith("#"):
                continue
            key, _, value = line.partition(":")
            value = value.strip()
            if key in ("topic", "head", "data"):
                frames.append(bytes.fromhex(value))
            elif key == "reader":
                reader = value
            else:
                expected[key.removeprefix("expect ")] = value
        return frames, reader, expected

    def vectors(self):
        paths = sorted(VECTORS.glob("*.hex"))
        self.assertGreater(len(paths), 30)
        for path in paths:
            with self.subTest(path.name):
                yield path.name, *self.load(path)

    def test_read_as_expected(self):
        for _, frames, reader, expected in self.vectors():
            try:
                head, session, message = wire.read_packet(frames, reader)
            except wire.Fault as fault:
                self.assertEqual(expected, {"fault": str(fault)})
                continue
            found = {**head, **message, "fault": "none", "session": session, "key": wire.key_of(head)}
            for key, value in expected.items():
                if key in ("fingerprint", "publisher_id", "cause", "session", "key"):
                    self.assertEqual(f"{found[key]:016x}", value, key)
                elif key in ("x", "y", "z"):
                    self.assertEqual(found[key], float(value), key)
                elif key == "data":
                    self.assertEqual(found[key].hex(), value)
                else:
                    self.assertEqual(str(found[key]), value, key)

    def test_written_byte_for_byte(self):
        written = 0
        for name, frames, reader, expected in self.vectors():
            if expected["fault"] != "none":
                continue
            # Field by field, in the order of the vector.
            raw = list(wire.read_fields(wire.read_head_frame(frames[1])))
            self.assertEqual(wire.write_head_frame(wire.write_fields(raw)), frames[1])
            self.assertEqual(wire.write_fields(wire.read_fields(frames[2])), frames[2])
            # From its values, as the library writes a head.
            head, session, message = wire.read_packet(frames, reader)
            if name not in ("good_fields_reordered.hex", "good_unknown_fields.hex", "good_release_head.hex"):
                self.assertEqual(wire.write_packet(head, frames[2], session), frames)
                written += 1
            if reader == "foxglove.Vector3":
                self.assertEqual(wire.write_message(wire.TYPES[reader], message), frames[2])
        self.assertGreater(written, 10)


WHEEL = {"type": "hgros_test::Wheel", "encoding": wire.PLAIN,
         "fingerprint": wire.fingerprint(["plain 1", "hgros_test::Wheel", "little", "12 4", "{12/4:f4,[4*s2]}"])}
LOG = {"type": "foxglove.Log", "encoding": wire.PROTOBUF, "fingerprint": wire.fingerprint([
    "protobuf 1 foxglove.Log",
    "message foxglove.Log", "1 optional message google.protobuf.Timestamp timestamp",
    "2 optional enum foxglove.Log.Level level", "3 optional string message", "4 optional string name",
    "5 optional string file", "6 optional fixed32 line",
    "enum foxglove.Log.Level", "0 UNKNOWN", "1 DEBUG", "2 INFO", "3 WARNING", "4 ERROR", "5 FATAL",
    "message google.protobuf.Timestamp", "1 optional int64 seconds", "2 optional int32 nanos"])}


def log_data(message):
    return wire.write_message(wire.TYPES["foxglove.Log"], {"message": message})


class RobotTest(unittest.TestCase):
    """A robot that knows of this program only its ZeroMQ endpoint."""

    def setUp(self):
        self.context = zmq.Context()
        self.addCleanup(self.context.destroy, linger=0)
        self.publisher = self.context.socket(zmq.XPUB)
        self.publisher.bind("tcp://127.0.0.1:*")
        self.robot = subprocess.Popen([ROBOT, self.publisher.getsockopt_string(zmq.LAST_ENDPOINT)], text=True,
                                      stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.addCleanup(self.end_robot)
        self.endpoint = self.robot.stdout.readline().split()[1]

    def end_robot(self):
        self.robot.communicate(timeout=PATIENCE_S)
        self.assertEqual(self.robot.returncode, 0)

    def receive(self, channels, enough):
        """The packets of each channel, until there are enough. The robot publishes again and again: the first
        messages go out before it has read the subscriptions."""
        subscriber = self.context.socket(zmq.SUB)
        self.addCleanup(subscriber.close)
        subscriber.connect(self.endpoint)
        for channel in channels:
            subscriber.subscribe(channel.encode() + b"\0")
        packets = {channel: [] for channel in channels}
        deadline = time.monotonic() + PATIENCE_S
        while not enough(packets):
            self.assertLess(time.monotonic(), deadline, {channel: len(some) for channel, some in packets.items()})
            self.robot.stdin.write("\n")
            self.robot.stdin.flush()
            subscriber.poll(100)
            while subscriber.poll(0):
                frames = subscriber.recv_multipart()
                packets[wire.read_topic(frames[0])[0]].append(frames)
        return packets

    def test_subscribes_to_every_kind_of_message(self):
        kinds = {  # type, encoding, fingerprint if it is known here
            "text": ("foxglove.Log", wire.PROTOBUF, LOG["fingerprint"]),
            "echo": ("foxglove.Log", wire.PROTOBUF, LOG["fingerprint"]),
            "cloud": ("foxglove.PointCloud", wire.PROTOBUF, None),
            "wheel": ("hgros_test::Wheel", wire.PLAIN, WHEEL["fingerprint"]),
            "mark": ("test.Mark", wire.CUSTOM, 0),
            "block": ("hgros.Block", wire.CUSTOM, 0),
            "clock": ("hgros.SimulatedTime", wire.PROTOBUF, None),
            "params/robot/state": ("hgros.ParamsState", wire.PROTOBUF, None),
            "hgros/snapshots": ("hgros.Snapshot", wire.PROTOBUF, 0),
            "hgros/trace": ("hgros.Trace", wire.PROTOBUF, 0)}

        def enough(some):  # Also the text that caused the last echo: it may come after it, on another channel.
            if any(len(packets) < 2 for packets in some.values()):
                return False
            texts, echoes = ([wire.read_packet(frames, *kinds["text"][:2])[0] for frames in some[channel]]
                             for channel in ("text", "echo"))
            return echoes[-1]["cause"] in [wire.key_of(head) for head in texts]

        packets = self.receive(kinds, enough)
        heads = {}
        for channel, (type_name, encoding, fingerprint) in kinds.items():
            read = [wire.read_packet(frames, type_name, encoding) for frames in packets[channel]]
            heads[channel] = [head for head, _, _ in read]
            for head, session, _ in read:
                self.assertEqual((head["version"], head["type"], head["encoding"], session),
                                 (wire.VERSION, type_name, encoding, 0))
                if fingerprint is not None:
                    self.assertEqual(head["fingerprint"], fingerprint, channel)
                self.assertNotEqual(head["publisher_id"], 0)
                self.assertLess(abs(head["publish_time_ns"] - time.time_ns()), 60e9)
            numbers = [head["sequence"] for head in heads[channel]]
            self.assertEqual(numbers, list(range(numbers[0], numbers[0] + len(numbers))))
            kinds[channel] = read[-1][2]
        self.assertEqual(kinds["text"], {"message": "hello"})
        self.assertEqual(kinds["echo"], {"message": "echo of hello"})
        self.assertEqual(kinds["cloud"],
                         {"frame_id": "lidar", "point_stride": 4, "data": bytes(i & 255 for i in range(1000))})
        self.assertEqual(struct.unpack("<f4h", kinds["wheel"]), (1.5, 1, -2, 3, -4))
        self.assertEqual(kinds["mark"], b"a mark")
        self.assertEqual(kinds["block"], bytes([0, 1, 254, 255]))
        self.assertEqual({head["latched"] for head in heads["text"]}, {2})
        self.assertEqual(heads["echo"][-1]["chain_origin"], wire.origin_of("text"))
        self.assertEqual(heads["text"][-1]["cause"], 0)

    def test_filter_that_is_no_whole_topic_ends_the_connection(self):
        subscriber = self.context.socket(zmq.SUB)
        self.addCleanup(subscriber.close)
        monitor = subscriber.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        self.addCleanup(monitor.close)
        self.addCleanup(subscriber.disable_monitor)
        subscriber.connect(self.endpoint)
        subscriber.subscribe(b"text")
        self.assertTrue(monitor.poll(PATIENCE_S * 1000))

    def test_publishes_every_kind_of_message(self):
        waiting = {f"\1in/{kind}\0".encode() for kind in ("text", "cloud", "wheel", "mark", "block")}
        while waiting:
            self.assertTrue(self.publisher.poll(PATIENCE_S * 1000), waiting)
            waiting.discard(self.publisher.recv())

        def send(channel, data, **head):
            head = {"version": wire.VERSION, "channel": channel, **head}
            self.publisher.send_multipart(wire.write_packet(head, data))

        numbered = {"publisher_id": 0xAB, "incarnation": 1, "publish_time_ns": time.time_ns()}
        send("in/text", log_data("one"), **LOG, **numbered, sequence=1)
        send("in/text", log_data("a repeat"), **LOG, **numbered, sequence=1)
        send("in/text", log_data("of another type"), **{**LOG, "type": "foxglove.Pose"}, **numbered, sequence=2)
        channel_only = wire.write_head_frame(b"\x12\x07in/text")
        self.publisher.send_multipart([b"in/text\0", channel_only, log_data("two")])
        self.publisher.send_multipart([b"in/text\0", b"no head", log_data("faulty")])
        self.publisher.send_multipart([b"in/text\0", channel_only, log_data("faulty"), b""])
        send("in/text", log_data("three"), **numbered, sequence=3)
        # The large field first: readers rely on no order.
        send("in/cloud", wire.write_fields([(6, wire.BYTES, bytes(500)), (2, wire.BYTES, b"lidar")]),
             type="foxglove.PointCloud", encoding=wire.PROTOBUF)
        send("in/wheel", struct.pack("<f4h", 9.5, 1, 2, 3, 4), **{**WHEEL, "fingerprint": 1})
        send("in/wheel", struct.pack("<f4h", 2.5, 1, 2, 3, -7), **WHEEL)
        send("in/mark", b"a mark", type="test.Mark", encoding=wire.CUSTOM)
        send("in/block", bytes(7), type="hgros.Block", encoding=wire.CUSTOM)
        # Each channel has an order of its own.
        took = [self.robot.stdout.readline().rstrip("\n") for _ in range(7)]
        self.assertEqual([line for line in took if "in/text" in line],
                         ["took in/text one", "took in/text two", "took in/text three"])
        self.assertEqual(sorted(line for line in took if "in/text" not in line), [
            "took in/block 7 bytes", "took in/cloud 500 bytes", "took in/mark a mark", "took in/wheel 2.500000 -7"])


if __name__ == "__main__":
    ROBOT, VECTORS = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
