import logging
import os
import pathlib
import tempfile
import threading

import numpy as np
from support import DEADLINE_S, RobotTest, main, wait_until

import hgros
from foxglove.Log_pb2 import Log
from foxglove.LaserScan_pb2 import LaserScan


def pose(x, angle=0.0):
    matrix = np.eye(4)
    matrix[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    matrix[0, 3] = x
    return matrix


class Params(RobotTest):
    def test_declared_parameter_has_its_default_its_bounds_and_its_choices(self):
        params = self.session().params
        self.assertEqual(params.declare("speed", 0.5, "How fast", unit="m/s", least=0, most=2), 0.5)
        params["speed"] = 1
        self.assertEqual(params["speed"], 1.0)
        self.assertIs(type(params["speed"]), float)
        self.assertEqual(params.declare("mode", "slow", choices=["slow", "fast"]), "slow")
        for name, value in (("speed", 3), ("speed", "fast"), ("mode", "faster")):
            with self.assertRaisesRegex(hgros.ParamError, name):
                params[name] = value
        self.assertEqual(params["speed"], 1.0)

    def test_parameter_of_the_environment_that_is_not_declared_is_logged(self):
        os.environ["HGROS_PARAM_sped"] = "3"
        self.addCleanup(os.environ.pop, "HGROS_PARAM_sped")
        with self.assertLogs("hgros", logging.WARNING) as logged:
            params = self.session().params
            params.declare("speed", 0.5)
            wait_until(lambda: any("HGROS_PARAM_sped (did you mean speed?)" in line for line in logged.output))

    def test_declared_text_stays_one_whatever_it_looks_like(self):
        for name, value in (("arm__serial", "0042"), ("arm__ports", "[1, 0x10]"), ("arm__gains", "[1, 2]"),
                            ("arm__joints", "6")):
            os.environ["HGROS_PARAM_" + name] = value
            self.addCleanup(os.environ.pop, "HGROS_PARAM_" + name)
        params = self.session().params
        self.assertEqual(params.declare("arm.serial", "none"), "0042")
        params.declare("arm.ports", ["0"])
        params.declare("arm.gains", [0.5])
        params.declare("arm.joints", 7)
        self.assertEqual(params["arm.serial"], "0042")
        self.assertEqual(params["arm.ports"], ["1", "0x10"])
        arm = params["arm"]
        self.assertEqual(arm, {"serial": "0042", "ports": ["1", "0x10"], "gains": [1.0, 2.0], "joints": 6})
        self.assertEqual([type(one) for one in arm["gains"]], [float, float])

    def test_every_type_comes_back_as_it_was_set(self):
        params = self.session().params
        values = {"flag": True, "whole": 3, "number": 0.25, "text": "7", "list": [1, 2], "map": {"a": [0.5, "b"]}}
        params.update({"all." + name: value for name, value in values.items()})
        self.assertEqual(params["all"], values)
        self.assertIs(type(params["all.text"]), str)
        self.assertIn("all.flag", params)
        params["all.flag"] = None
        self.assertNotIn("all.flag", params)
        self.assertIsNone(params.get("all.flag"))

    def test_a_list_of_bools_stays_one(self):
        params = self.session().params
        self.assertEqual(repr(params.declare("flags", [True, False])), "[True, False]")
        params["flags"] = [False]
        self.assertEqual(repr(params["flags"]), "[False]")

    def test_square_brackets_refuse_a_parameter_that_is_not_there(self):
        params = self.session().params
        params.declare("speed", 0.5)
        with self.assertRaisesRegex(hgros.ParamError, 'no parameter "sped"\\. Did you mean "speed"\\?'):
            params["sped"]
        with self.assertRaisesRegex(hgros.ParamError, 'no parameter "height". Declare it first'):
            params["height"] = 1
        self.assertNotIn("height", params)

    def test_a_parameter_that_no_file_could_hold_is_refused_with_the_reason(self):
        params = self.session().params
        endless = []
        endless.append(endless)
        refused = {"contains itself": endless, "at most 64 bits": [1, 2**63], "surrogate": "\ud800", "keys": {1: 2}}
        for reason, value in refused.items():
            with self.assertRaisesRegex((TypeError, ValueError), reason):
                params.set("all", value)
        self.assertNotIn("all", params)
        with self.assertRaisesRegex(ValueError, "at most 64 bits"):
            params.declare("large", 2**63)
        with self.assertRaisesRegex(TypeError, "list of one of these"):
            params.declare("mixed", [1, "a"])

    def test_file_and_environment_set_parameters_and_save_keeps_comments(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "robot.yaml")
            file.write_text("planner:  # plans\n  speed: 0.7\n  name: a\n")
            os.environ["HGROS_PARAM_planner__name"] = "b"
            self.addCleanup(os.environ.pop, "HGROS_PARAM_planner__name")
            robot = self.session(file=file, sections=["planner"])
            self.assertEqual(robot.params["planner"], {"speed": 0.7, "name": "b"})
            robot.params["planner.speed"] = 0.9
            robot.params.save()
            self.assertIn("# plans", file.read_text())
            self.assertIn("speed: 0.9", file.read_text())
            with self.assertRaisesRegex(hgros.ConfigError, "robot.yaml:1:1"):
                self.session(file=file, sections=["planer"])

    def test_change_calls_back_on_the_spinning_thread(self):
        robot = self.session()
        heard = []

        @robot.params.on_change("speed")
        def on_change(paths):
            heard.append((paths, threading.get_ident()))

        with self.beside(lambda: robot.params.set("speed", 2)):
            pass
        robot.params.set("other", 1)
        self.spin_until(robot, lambda: heard)
        self.assertEqual(heard, [(["speed"], threading.get_ident())])


class Tf(RobotTest):
    def test_lookup_interpolates_joins_edges_and_takes_the_stamp_of_a_message(self):
        robot = self.session()
        robot.transforms.send_static("base", "laser", pose(0.5))
        robot.transforms.send("map", "base", pose(1), 10**9)
        robot.transforms.send("map", "base", pose(3), 2 * 10**9)
        np.testing.assert_allclose(robot.transforms.lookup("map", "laser", 1_500_000_000), pose(2.5))
        matrix, stamp = robot.transforms.lookup_stamped("map", "laser")
        np.testing.assert_allclose(matrix, pose(3.5))
        self.assertEqual(stamp, 2 * 10**9)
        robot.transforms.send("map", "base", pose(1, 0.5), 3 * 10**9)
        scan = LaserScan()
        scan.timestamp.FromNanoseconds(3 * 10**9)
        np.testing.assert_allclose(robot.transforms.lookup("map", "base", scan.timestamp), pose(1, 0.5), atol=1e-12)

    def test_failed_lookup_says_why(self):
        robot = self.session()
        with self.assertRaisesRegex(hgros.TransformError, "No transforms received yet: .* Pass a timeout to wait."):
            robot.transforms.lookup("map", "base")
        robot.transforms.send("map", "base", pose(1), 10**9)
        for target, source, stamp, fault in (("map", "lase", None, "unknown frame"), ("map", "base", 1, "too old"),
                                             ("map", "base", 2 * 10**9, "too new")):
            with self.assertRaises(hgros.TransformError) as failed:
                robot.transforms.lookup(target, source, stamp)
            self.assertEqual(failed.exception.fault, fault)
            self.assertIn(f'"{source}"', str(failed.exception))

    def test_an_edge_begins_again_when_its_stamps_jumped_back(self):
        robot = self.session()
        robot.transforms.send("map", "base", pose(1), 60 * 10**9)
        self.assertFalse(robot.transforms.restart_edge("base", 60 * 10**9))
        self.assertTrue(robot.transforms.restart_edge("base", 5 * 10**9))
        robot.transforms.send("map", "base", pose(2), 5 * 10**9)
        self.assertEqual(robot.transforms.lookup_stamped("map", "base")[1], 5 * 10**9)
        with self.assertRaisesRegex(TypeError, "latest stamp"):
            robot.transforms.restart_edge("base", None)

    def test_lookup_waits_for_another_session(self):
        robot, other = self.session(), self.session()
        threading.Timer(0.05, lambda: other.transforms.send_static("map", "base", pose(2))).start()
        np.testing.assert_allclose(robot.transforms.lookup("map", "base", timeout=DEADLINE_S), pose(2))

    def test_what_is_no_transform_is_refused(self):
        robot = self.session()
        with self.assertRaisesRegex(TypeError, "send_static"):
            robot.transforms.send("map", "base", np.eye(4), None)
        robot.transforms.send_static("map", "base", np.eye(4))
        with self.assertRaisesRegex(hgros.TransformError, "base"):
            robot.transforms.send_static("base", "map", np.eye(4))

    def test_lookup_that_waits_ends_when_the_session_closes(self):
        for _ in range(20):
            robot = self.session()
            transforms = robot.transforms
            faults = []

            def look():
                try:
                    transforms.lookup("a", "b", timeout=DEADLINE_S)
                except hgros.Error as error:
                    faults.append(str(error))

            with self.beside(look):
                robot.close()
            self.assertIn("closed", faults[0])
        with self.assertRaisesRegex(hgros.Error, "closed"):
            transforms.lookup("a", "b")


class Counters(RobotTest):
    def test_snapshot_has_channels_nodes_and_peers_and_channels_of_all_sessions_are_known(self):
        robot, other = self.session(name="robot"), self.session(name="other")
        robot.subscribe("log", Log, lambda message, info: None, name="listener")
        publisher = other.advertise("log", Log)
        self.assertTrue(other.wait_for_subscribers("log", timeout=DEADLINE_S))
        publisher.publish(Log())
        wait_until(lambda: robot.snapshot().channel("log").received == 1)
        snapshot = robot.snapshot()
        self.assertEqual(snapshot.name, "robot")
        node = snapshot.channel("log").nodes[0]
        self.assertEqual((node.name, node.received), ("listener", 1))
        # A pair that has no shared memory within two seconds begins with ZeroMQ, and moves later.
        wait_until(lambda: [(peer.process, peer.transport) for peer in robot.snapshot().peers] ==
                   [("other", "shared memory")])
        self.assertEqual(other.snapshot().channel("log").published, 1)
        wait_until(lambda: [(one.type_name, one.publishers, one.subscribers) for one in other.channels()
                            if one.name == "log"] == [("foxglove.Log", 1, 1)])
        with self.assertRaises(KeyError):
            snapshot.channel("nothing")

    def test_loans_are_counted(self):
        from foxglove.PointCloud_pb2 import PointCloud

        robot, other = self.session(), self.session()
        clouds = other.messages("points", timeout=DEADLINE_S)
        robot.advertise("points", PointCloud)
        self.assertTrue(robot.wait_for_subscribers("points", timeout=DEADLINE_S))
        with robot.loan("points", PointCloud, 100_000):
            pass
        next(clouds)
        traffic = [one for one in robot.snapshot().traffic if one.channel == "points"][0]
        self.assertEqual((traffic.loans, traffic.heap_loans, traffic.copied), (1, 0, 0))


if __name__ == "__main__":
    main()
