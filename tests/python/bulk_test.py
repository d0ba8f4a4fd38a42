import copy
import gc
import json
import pickle

import numpy as np
from google.protobuf import json_format
from support import DEADLINE_S, RobotTest, main

import hgros
from foxglove.Log_pb2 import Log
from foxglove.PackedElementField_pb2 import PackedElementField
from foxglove.PointCloud_pb2 import PointCloud
from foxglove.RawImage_pb2 import RawImage


def describe(cloud):
    cloud.frame_id = "laser"
    cloud.point_stride = 16
    for at, name in enumerate("xyz"):
        cloud.fields.add(name=name, offset=4 * at, type=PackedElementField.FLOAT32)


def cloud_of(count):
    cloud = PointCloud()
    describe(cloud)
    points = np.zeros(count, hgros.points(cloud).dtype)
    points["x"] = np.arange(count)
    cloud.data = points.tobytes()
    return cloud


class Bulk(RobotTest):
    def setUp(self):
        super().setUp()
        self.robot, self.other = self.session(), self.session()
        self.messages = self.other.messages("points", timeout=DEADLINE_S, queue=hgros.KeepAll(10))
        self.publisher = self.robot.advertise("points", PointCloud)
        self.assertTrue(self.robot.wait_for_subscribers("points", timeout=DEADLINE_S))

    def received(self, sent):
        self.publisher.publish(sent)
        return next(self.messages)

    def test_received_cloud_is_an_array_over_the_memory_where_it_arrived(self):
        cloud = self.received(cloud_of(10000))
        self.assertIsInstance(cloud, PointCloud)
        self.assertEqual(cloud.frame_id, "laser")
        points = hgros.points(cloud)
        self.assertEqual(points["x"][-1], 9999)
        self.assertFalse(points.flags.writeable)
        self.assertFalse(points.flags.owndata)
        with self.assertRaises(ValueError):
            points["x"][0] = 1
        self.assertTrue(np.shares_memory(points, np.frombuffer(cloud.data, np.uint8)))

    def test_array_keeps_the_memory_as_its_only_owner(self):
        x = hgros.points(self.received(cloud_of(10000)))["x"]
        gc.collect()
        self.assertEqual(hgros.leases()[0], 1)
        self.assertGreaterEqual(hgros.leases()[1], 160000)
        for _ in range(5):
            self.received(cloud_of(10000))
        self.assertEqual(x[5000], 5000)
        del x
        gc.collect()
        self.assertEqual(hgros.leases(), (0, 0))

    def test_nothing_changes_a_received_message(self):
        sent = cloud_of(3)
        sent.timestamp.FromNanoseconds(5)
        sent.pose.position.x = 7
        received = self.received(sent)
        received.timestamp.FromNanoseconds(6)
        received.pose.position.x = 8
        received.fields[0].name = "w"
        with self.assertRaises(AttributeError):
            received.fields.add()
        for change in (lambda m: m.Clear(), lambda m: m.ClearField("frame_id"),
                       lambda m: setattr(m, "frame_id", "other"), lambda m: m.CopyFrom(sent),
                       lambda m: m.MergeFrom(sent), lambda m: m.MergeFromString(b""), lambda m: m.ParseFromString(b""),
                       lambda m: m.SetInParent(), lambda m: m.DiscardUnknownFields(), lambda m: delattr(m, "_head")):
            with self.assertRaisesRegex(AttributeError, "read-only"):
                change(received)
        self.assertEqual([field.name for field in received.fields], ["x", "y", "z"])
        self.assertEqual((received.timestamp.ToNanoseconds(), received.pose.position.x), (5, 7))
        self.assertEqual(received, sent)

    def test_copies_of_a_received_message_are_ordinary_and_whole(self):
        sent = cloud_of(10000)
        received = self.received(sent)
        for made in (copy.copy(received), copy.deepcopy(received), copy.deepcopy([received])[0],
                     pickle.loads(pickle.dumps(received)), pickle.loads(pickle.dumps(received, 0))):
            self.assertIs(type(made), PointCloud)
            self.assertEqual(made, sent)
            made.timestamp.seconds = 1
        self.assertEqual(received, sent)

    def test_methods_of_a_received_message_know_its_large_field(self):
        sent = cloud_of(3)
        received = self.received(sent)
        copy = hgros.message(received)
        self.assertIs(type(copy), PointCloud)
        self.assertEqual(copy, sent)
        self.assertEqual(received, sent)
        self.assertEqual([field.name for field, _ in received.ListFields()], [field.name for field, _ in sent.ListFields()])
        self.assertEqual(received.SerializeToString(), bytes(received._wire))
        self.assertEqual(received.SerializePartialToString(), sent.SerializeToString())
        self.assertEqual(received.SerializeToString(deterministic=True), sent.SerializeToString(deterministic=True))
        self.assertEqual(json.loads(json_format.MessageToJson(received))["frameId"], "laser")
        self.assertTrue(received.IsInitialized())
        self.assertEqual((received.HasField("timestamp"), received.HasField("pose")), (False, False))
        with self.assertRaises(ValueError):
            received.HasField("data")  # As of every message: a field of proto3 without presence.

    def test_received_message_is_published_again_without_a_copy(self):
        again = self.robot.messages("again", timeout=DEADLINE_S)
        publisher = self.other.advertise("again", PointCloud)
        self.assertTrue(self.other.wait_for_subscribers("again", timeout=DEADLINE_S))
        publisher.publish(self.received(cloud_of(10000)))
        self.assertEqual(hgros.points(next(again))["x"][-1], 9999)

    def test_loan_is_filled_and_published_in_place(self):
        with self.robot.loan("points", PointCloud, 160000) as cloud:
            describe(cloud)
            points = hgros.points(cloud)
            points["x"] = np.arange(10000)
            points["y"] = 2
        received = hgros.points(next(self.messages))
        self.assertEqual((received["x"][9999], received["y"][0]), (9999, 2))
        self.assertFalse(points.flags.writeable)

    def test_loan_needs_a_type_with_one_large_field_and_is_not_published_after_an_exception(self):
        with self.assertRaisesRegex(hgros.Error, "foxglove.Log has no field for a loan"):
            self.robot.loan("log", Log, 10)
        with self.assertRaises(KeyError), self.robot.loan("points", PointCloud, 16):
            raise KeyError
        self.messages.timeout = 0.05
        self.assertEqual(list(self.messages), [])

    def test_loan_with_large_other_fields_is_published(self):
        with self.publisher.loan(32) as cloud:
            describe(cloud)
            cloud.frame_id = "f" * 5000
            cloud.data = bytes(range(32))
        received = next(self.messages)
        self.assertEqual((received.frame_id, bytes(received.data)), ("f" * 5000, bytes(range(32))))

    def test_description_that_does_not_fit_is_an_error(self):
        for change, text in ((lambda c: setattr(c, "data", c.data[:-1]), "no multiple of its stride"),
                             (lambda c: setattr(c, "point_stride", 8), "ends after the stride"),
                             (lambda c: setattr(c, "point_stride", 0), "ends after the stride|describes no points"),
                             (lambda c: c.fields.add(name="x", type=7), 'two fields "x"'),
                             (lambda c: c.fields.add(name="w"), "unknown type 0"),
                             (lambda c: c.ClearField("fields"), "describes no points")):
            cloud = cloud_of(2)
            change(cloud)
            with self.assertRaisesRegex(hgros.Error, text):
                hgros.points(cloud)

    def test_image_is_an_array_with_the_rows_of_its_step(self):
        rows = np.arange(4 * 12, dtype=np.uint8).reshape(4, 12)
        image = RawImage(width=3, height=4, step=12, encoding="rgb8", data=rows.tobytes())
        pixels = hgros.image(image)
        self.assertEqual(pixels.shape, (4, 3, 3))
        np.testing.assert_array_equal(pixels, rows[:, :9].reshape(4, 3, 3))
        depth = RawImage(width=2, height=1, step=4, encoding="16UC1", data=b"\x01\x00\x00\x01")
        self.assertEqual(hgros.image(depth).tolist(), [[1, 256]])
        deep = RawImage(width=1, height=1, step=6, encoding="rgb16", data=b"\x01\x00\x00\x01\x02\x00")
        self.assertEqual(hgros.image(deep).tolist(), [[[1, 256, 2]]])
        video = RawImage(width=2, height=2, step=2, encoding="nv12", data=b"123456")
        self.assertEqual(hgros.image(video).tobytes(), b"123456")
        self.assertEqual(hgros.image(video).shape, (3, 2))
        bayer = RawImage(width=1, height=1, step=2, encoding="bayer_gbrg16", data=b"\x00\x01")
        self.assertEqual(hgros.image(bayer).tolist(), [[256]])
        for encoding, step, text in (("h264", 12, 'encoding "h264" of the image is unknown'),
                                     ("rgb8", 13, "fewer than 4 rows"), ("rgb8", 8, "more than its step")):
            image.encoding, image.step = encoding, step
            with self.assertRaisesRegex(hgros.Error, text):
                hgros.image(image)


if __name__ == "__main__":
    main()
