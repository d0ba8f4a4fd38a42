import logging
import os

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from support import DEADLINE_S, RobotTest, main, wait_until

import hgros
from foxglove.LaserScan_pb2 import LaserScan
from foxglove.Log_pb2 import Log
from foxglove.PointCloud_pb2 import PointCloud


def own_type(full_name="robot.Gripper", fields=("width",), pool=None):
    """A class of a type that only this test knows, in a pool of its own."""
    file = descriptor_pb2.FileDescriptorProto(name="robot/gripper.proto", package="robot", syntax="proto3")
    message = file.message_type.add(name=full_name.split(".")[-1])
    for number, name in enumerate(fields, 1):
        message.field.add(name=name, number=number, label=1, type=1)
    pool = pool or descriptor_pool.DescriptorPool()
    pool.Add(file)
    return message_factory.MessageFactory(pool).GetPrototype(pool.FindMessageTypeByName(full_name))


class Types(RobotTest):
    def hear(self, publish_type, message, subscribe_type=None, channel="channel"):
        robot, other = self.session(), self.session()
        messages = other.messages(channel, subscribe_type, timeout=DEADLINE_S)
        publisher = robot.advertise(channel, publish_type)
        self.assertTrue(robot.wait_for_subscribers(channel, timeout=DEADLINE_S))
        publisher.publish(message)
        return messages

    def test_type_comes_with_the_channel(self):
        heard = next(self.hear(LaserScan, LaserScan(ranges=[1, 2])))
        self.assertIs(type(heard), LaserScan)
        self.assertEqual(list(heard.ranges), [1, 2])

    def test_type_that_this_program_does_not_have_is_built_from_its_schema(self):
        gripper = own_type()
        heard = next(self.hear(gripper, gripper(width=0.5)))
        self.assertIsNot(type(heard), gripper)
        self.assertEqual(heard.DESCRIPTOR.full_name, "robot.Gripper")
        self.assertEqual(heard.width, 0.5)

    def test_type_of_the_same_name_but_another_schema_is_not_the_programs_own(self):
        mine = own_type(fields=("width", "force"))
        theirs = own_type(fields=("force",))
        self.assertEqual(next(self.hear(mine, mine(width=1, force=2))).force, 2)
        self.assertEqual(next(self.hear(theirs, theirs(force=3))).force, 3)

    def test_repeated_fields_and_maps_beside_a_large_field_are_copies(self):
        file = descriptor_pb2.FileDescriptorProto(name="robot/tile.proto", package="robot", syntax="proto3")
        tile = file.message_type.add(name="Tile")
        tile.field.add(name="data", number=1, label=1, type=12)
        tile.field.add(name="heights", number=2, label=3, type=1)
        for number, value in enumerate(("weights", "parts"), 3):
            entry = tile.nested_type.add(name=value.title() + "Entry", options=descriptor_pb2.MessageOptions(map_entry=True))
            entry.field.add(name="key", number=1, label=1, type=9)
            entry.field.add(name="value", number=2, label=1, **(
                {"type": 1} if value == "weights" else {"type": 11, "type_name": ".robot.Tile"}))
            tile.field.add(name=value, number=number, label=3, type=11, type_name=".robot.Tile." + entry.name)
        pool = descriptor_pool.DescriptorPool()
        pool.Add(file)
        tile = message_factory.MessageFactory(pool).GetPrototype(pool.FindMessageTypeByName("robot.Tile"))
        sent = tile(data=b"x" * 5000, heights=[1, 2], weights={"a": 3})
        sent.parts["b"].heights.append(4)
        heard = next(self.hear(tile, sent))
        self.assertEqual((heard.heights, heard.weights), ((1, 2), {"a": 3}))
        heard.parts["b"].heights.append(5)
        heard.weights["a"] = 6
        self.assertEqual((list(heard.parts["b"].heights), heard.weights["a"], list(heard.parts)), ([4], 3, ["b"]))
        self.assertEqual(hgros.message(heard).SerializeToString(), sent.SerializeToString())

    def test_schema_that_grew_is_read(self):
        old, new = own_type(fields=("width",)), own_type(fields=("width", "force"))
        self.assertEqual(next(self.hear(old, old(width=2), new)).width, 2)

    def test_wrong_type_is_an_error_that_names_both(self):
        for published, subscribed in ((LaserScan, Log), (Log, PointCloud)):
            channel = subscribed.__name__
            messages = self.hear(published, published(), subscribed, channel)
            messages.timeout = 0.05

            def counted():  # As soon as it has come.
                self.assertEqual(list(messages), [])
                return messages.not_decoded == 1

            with self.assertLogs("hgros", logging.ERROR) as logged:
                wait_until(counted)
            line = next(line for line in logged.output if f":{os.getpid()} publishes them." in line)
            for text in (f'channel "{channel}"', published.DESCRIPTOR.full_name, subscribed.DESCRIPTOR.full_name):
                self.assertIn(text, line)
            self.assertEqual(messages.not_decoded, 1)

    def test_bytes_that_are_no_message_are_counted_and_logged_once_for_each_publisher(self):
        heard = []
        listener = self.session()
        subscription = listener.subscribe("channel", Log, lambda message, info: heard.append(message.message))
        robots = [self.session(name=f"robot{i}") for i in range(2)]
        publishers = [robot.advertise("channel", Log) for robot in robots]
        for robot in robots:
            self.assertTrue(robot.wait_for_subscribers("channel", timeout=DEADLINE_S))
        with self.assertLogs("hgros", logging.WARNING) as logged:
            for _ in range(3):
                for publisher in publishers:
                    publisher._raw.publish(b"\xff\xff\xff", None)
            for publisher in publishers:
                publisher.publish(Log(message="last"))
            wait_until(lambda: listener.spin_once(0.01) is not None and len(heard) == 2)
        self.assertEqual((heard, subscription.not_decoded, subscription.failed), (["last", "last"], 6, 0))
        self.assertEqual(len(logged.output), 2, logged.output)
        for robot in robots:
            named = f"from {robot.name}:{os.getpid()} cannot be read"
            self.assertEqual(sum(named in line for line in logged.output), 1, logged.output)

    def test_messages_of_the_library_and_of_python_are_one_type(self):
        from foxglove.Pose_pb2 import Pose
        from foxglove.SceneUpdate_pb2 import SceneUpdate

        update = SceneUpdate()
        update.entities.add().arrows.add().pose.CopyFrom(Pose())
        self.assertEqual(len(update.entities), 1)

    def test_schemas_work_when_the_library_is_loaded_last(self):
        process = self.python(
            "import sys, types, importlib.util, pathlib\n"
            "import importlib.machinery as machinery\n"
            "folder = next(p for p in sys.path if pathlib.Path(p, 'foxglove').is_dir())\n"
            "package = types.ModuleType('foxglove'); package.__path__ = [folder + '/foxglove']\n"
            "sys.modules['foxglove'] = package\n"  # Without the package's own import of the library.
            "from foxglove.LaserScan_pb2 import LaserScan\n"
            "import hgros\n"
            "with hgros.Session(text='discovery: {domain: none}') as robot:\n"
            "    messages = robot.messages('scan', timeout=40)\n"
            "    robot.advertise('scan', LaserScan).publish(LaserScan(ranges=[1]))\n"
            "    print(next(messages).ranges)\n")
        out, err, code = self.finish(process)
        self.assertEqual((out, code), ("[1.0]\n", 0), err)


if __name__ == "__main__":
    main()
