"""Messages of several channels whose stamps match."""

from support import RobotTest, main

import hgros
from foxglove.LaserScan_pb2 import LaserScan
from foxglove.Log_pb2 import Log
from foxglove.Vector2_pb2 import Vector2

MS = 1_000_000


class Synchronizing(RobotTest):
    def test_matcher_gives_the_items_of_a_set_and_counts_the_others(self):
        matcher = hgros.StampMatcher(3, tolerance=0.01)
        pushed = [matcher.push(channel, stamp * MS, item)
                  for channel, stamp, item in ((0, 0, "a"), (0, 100, "b"), (1, 104, "c"), (2, 95, "d"))]
        self.assertEqual(pushed, [None, None, None, ("b", "c", "d")])
        self.assertEqual((matcher.counts(0).matched, matcher.counts(0).unmatched), (1, 1))
        for wrong in ({"channels": 1}, {"channels": 2, "tolerance": -1.0}, {"channels": 2, "depth": 0}):
            with self.assertRaises(hgros.Error):
                hgros.StampMatcher(**wrong)

    def test_callback_gets_messages_of_each_channel_whose_stamps_match(self):
        robot, got = self.session(), []
        logs, scans = robot.advertise("log", Log), robot.advertise("scan", LaserScan)
        both = hgros.Synchronizer(robot, {"log": Log, "scan": None}, lambda log, scan: got.append((log, scan)),
                                  tolerance=0.01)
        for message, publisher, stamp in ((Log(message="early"), logs, 1), (Log(message="near"), logs, 50),
                                          (LaserScan(ranges=[2.0]), scans, 45)):
            message.timestamp.FromNanoseconds(stamp * MS)
            publisher.publish(message)
        self.spin_until(robot, lambda: got)
        self.assertEqual([(log.message, list(scan.ranges)) for log, scan in got], [("near", [2.0])])
        self.assertEqual((both.counts("log").unmatched, both.counts("scan").matched), (1, 1))
        both.end()
        self.assertEqual(robot.subscriptions(), [])

    def test_message_without_a_timestamp_needs_a_function(self):
        robot, got = self.session(), []
        left, right = robot.advertise("left", Vector2), robot.advertise("right", Vector2)
        hgros.Synchronizer(robot, ("left", "right"), lambda *both: got.append([one.x for one in both]),
                           stamp=lambda message: int(message.x))
        left.publish(Vector2(x=7))
        right.publish(Vector2(x=7))
        self.spin_until(robot, lambda: got)
        self.assertEqual(got, [[7, 7]])
        with self.assertRaisesRegex(TypeError, "stamp="):
            hgros.synchronizer.stamp_ns(Vector2())
        with self.assertRaisesRegex(TypeError, "2 arguments"):
            hgros.Synchronizer(robot, ("left", "right"), lambda left: None)


if __name__ == "__main__":
    main()
