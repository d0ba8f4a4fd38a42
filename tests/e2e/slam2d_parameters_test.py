#!/usr/bin/env python3
"""Tunes the SLAM example: at its start, and from other processes while it runs.

    HGROS=<binary> SLAM2D=<folder> SLAM2D_REFERENCE=<binary> slam2d_parameters_test.py
"""

import json
import unittest

from slam2d_programs import ROBOTS, SCANS, SLOW, Slam2dTest

SHORT = {"source.params.scans": SCANS}
# Parameters that do not affect the first scan, which is handled at once at any rate.
TUNED = {("matcher", "max_range_m"): 8, ("mapper", "min_translation_m"): 0.5}


class Slam2dParameters(Slam2dTest):
    def set_param(self, running, component, path, value):
        return self.hgros_until_it_works(running, "param", "set", component, path, value)

    def test_a_parameter_is_taken_from_the_robot_file_and_the_command_line(self):
        (self.folder / "coarse.yaml").write_text("components: {mapper: {params: {cell_size_m: 0.1}}}\n")
        (self.folder / "robot.yaml").write_text(f"include: [{ROBOTS}/one_process.yaml, coarse.yaml]\n")
        given = [self.hashes(self.start("robot.yaml", SHORT)),
                 self.hashes(self.start("three_processes.yaml", {**SHORT, "mapper.params.cell_size_m": 0.1}))]
        self.assertEqual(given[0], given[1])
        self.assertNotEqual(given[0], self.reference(SCANS))
        code, out, _ = self.end(self.start("robot.yaml", {"source.params.scans": 20, "mapper.params.cell_size_m": 0.3}))
        self.assertEqual(code, 0)
        self.assertIn("cells of 0.30 m", out)

    def test_an_invalid_parameter_is_reported_with_its_place(self):
        for path, value, sentence in (("matcher.params.max_range_m", "far", "max_range_m must be a number"),
                                      ("matcher.params.revisit.min_score", 2, "must be from 0.0 to 1.0"),
                                      ("matcher.params.max_range", 5, "max_range_m"),
                                      ("mapper.params.hit_gains", 5, "hit_gain")):
            with self.subTest(path=path):
                code, out, err = self.end(self.start("one_process.yaml", {path: value}))
                self.assertNotEqual(code, 0, out)
                self.assertIn(sentence, err)
                self.assertIn(path.split(".")[-1], err)

    def test_parameters_set_while_it_runs_act_as_if_given_at_the_start(self):
        given = {f"{component}.params.{path}": value for (component, path), value in TUNED.items()}
        tuned = self.hashes(self.start("one_process.yaml", {**SHORT, **given, "writer.params.out": "expected"}))
        self.assertNotEqual(tuned, self.reference(SCANS))
        for robot in ("one_process.yaml", "three_processes.yaml"):
            with self.subTest(robot=robot):
                running = self.start(robot, SLOW)
                for (component, path), value in TUNED.items():
                    self.set_param(running, component, path, value)
                self.set_param(running, "source", "rate", 0)
                self.assertEqual(self.hashes(running), tuned)

    def test_each_component_offers_its_parameters_and_refused_ones_change_nothing(self):
        running = self.start("three_processes.yaml", SLOW)
        described = [self.hgros_until_it_works(running, "param", "describe", name, "--json").stdout
                     for name in ("source", "matcher", "mapper", "writer")]
        listed = json.dumps([json.loads(line) for out in described for line in out.splitlines()])
        for name in ("rate", "revisit.lag_m", "cell_size_m", "relations", "edge of a cell", "rad/m"):
            self.assertIn(name, listed)
        self.hgros_until_it_works(running, "param", "get", "mapper", "hit_gain")
        for words, sentence in ((("mapper", "cell_size_m", "0.1"), "cell_size_m is read-only."),
                                (("mapper", "hit_gains", "5"), "hit_gain"),
                                (("mapper", "miss_loss", "-- -1"), "miss_loss")):
            done = self.hgros("param", "set", *(" ".join(words).split()))
            self.assertNotEqual(done.returncode, 0, done)
            self.assertIn(sentence, done.stderr)
        self.set_param(running, "source", "rate", 0)
        self.assertEqual(self.hashes(running), self.reference(SCANS))


if __name__ == "__main__":
    unittest.main()
