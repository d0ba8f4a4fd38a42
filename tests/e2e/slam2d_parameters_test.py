#!/usr/bin/env python3
"""Tunes the SLAM example: at its start, and from other processes while it runs.

    SLAM2D=<binary> SLAM2D_REFERENCE=<binary> slam2d_parameters_test.py [TEST...]
"""

import json
import os

from slam2d_programs import ROBOTS, SCANS, THREE, Slam2dTest, main

# Parameters that do not affect the first scan, which is handled at once at any rate.
TUNED = {"slam.matcher.max_range_m": 8, "slam.map.min_translation_m": 0.5}
# So slow that the demo ends only if the rate is set.
SLOW = ["--scans", SCANS, "--rate", 0.001]


def assignments(option, params):
    return [word for path, value in params.items() for word in (option, f"{path}={value}")]


class Slam2dParameters(Slam2dTest):
    def setUp(self):
        super().setUp()
        self.own = {**os.environ, "HGROS_DOMAIN": f"slam2d-{os.getpid()}-params"}

    def ask(self, running, *arguments):
        """Asks the running demo until it is there; returns exit code, standard output and standard error."""
        code = 1
        while code == 1 and all(one.poll() is None for one in running):
            code, out, err = self.end(self.start(*arguments, env=self.own))
        self.assertNotEqual(code, 1, [one.poll() for one in running])
        return code, out, err

    def tuned_from_the_start(self):
        return self.hashes(self.start("--json", "--scans", SCANS, "--out", "expected",
                                      *assignments("--param", TUNED)))

    def start_three(self):
        processes = {}
        for name, (nodes, *_) in THREE.items():
            config = self.folder / f"{name}.yaml"
            config.write_text(f"slam2d:\n  nodes: {nodes}\n")
            more = SLOW if name == "source" else []
            processes[name] = self.start("--json", "--config", config, *more, env=self.own)
        return processes

    def test_a_parameter_is_taken_from_file_environment_and_command_line(self):
        file = self.folder / "coarse.yaml"
        file.write_text("slam:\n  map: {cell_size_m: 0.1}\nother_program: {rate: 3}\n")
        variable = {**os.environ, "HGROS_PARAM_slam__map__cell_size_m": "0.1"}
        given = [self.hashes(self.start("--json", "--scans", SCANS, "--params", file)),
                 self.hashes(self.start("--json", "--scans", SCANS, env=variable)),
                 self.hashes(self.start("--json", "--scans", SCANS, "--param", "slam.map.cell_size_m=0.1"))]
        self.assertEqual(given, [given[0]] * 3)
        self.assertNotEqual(given[0], self.reference(SCANS))
        code, out, _ = self.end(self.start("--scans", 20, "--param=slam.map.cell_size_m=0.1"))
        self.assertEqual(code, 0)
        self.assertIn("cells of 0.10 m", out)

    def test_the_command_line_wins_over_environment_and_files(self):
        file = self.folder / "coarse.yaml"
        file.write_text("slam: {map: {cell_size_m: 0.1}}\n")
        variable = {**os.environ, "HGROS_PARAM_slam__map__cell_size_m": "0.2"}
        code, out, _ = self.end(self.start("--scans", 20, "--params", file, "--param", "slam.map.cell_size_m=0.3",
                                           env=variable))
        self.assertEqual(code, 0)
        self.assertIn("cells of 0.30 m", out)

    def test_the_mappers_parameters_define_the_map_of_all_processes(self):
        coarse = ["--param", "slam.map.cell_size_m=0.1"]
        expected = self.hashes(self.start("--json", "--scans", SCANS, *coarse))
        processes = self.start_plan(THREE, {"source": ["--scans", SCANS], "mapper": coarse})
        self.assert_all_agree(processes, expected)

    def test_an_invalid_parameter_is_reported_with_its_place(self):
        file = self.folder / "params.yaml"
        file.write_text("slam:\n  matcher:\n    max_range: 5\n")
        matcher = self.write_config("matcher", THREE["matcher"])
        for arguments, sentence in (
                (["--param", "slam.matcher.max_range_m=far"],
                 "--param slam.matcher.max_range_m: slam.matcher.max_range_m must be a number, but is the text \"far\"."),
                (["--param", "slam.matcher.revisit.min_score=2"],
                 "--param slam.matcher.revisit.min_score: slam.matcher.revisit.min_score must be from 0.0 to 1.0, "),
                (["--params", file], f"{file}:3:16: There is no parameter slam.matcher.max_range. "
                                     "Did you mean slam.matcher.max_range_m?"),
                (["--params", self.folder / "none.yaml"], f"{self.folder}/none.yaml: The configuration file cannot be"),
                (["--param", "slm.map.hit_gain=3"], "--param slm.map.hit_gain: There is no parameter slm.map.hit_gain."),
                (["--param", "hit_gain"], "--param needs a path and a value"),
                (["--config", matcher, "--param", "slam.map.hit_gain=3"],
                 "--param slam.map.hit_gain: slam.map.hit_gain is for the process that runs the mapper; "),
                (["--set-param", "hit_gain"], "--set-param must be PATH=VALUE"),
                (["--set-param", "hit_gain=3"], "There is no parameter hit_gain; ")):
            with self.subTest(arguments=arguments):
                code, out, err = self.end(self.start(*arguments))
                self.assertEqual((code, out), (2, ""), err)
                self.assertEqual(err[:len("slam2d: " + sentence)], "slam2d: " + sentence)

    def test_parameters_set_by_another_process_act_as_if_given_at_the_start(self):
        running = self.start("--json", *SLOW, env=self.own)
        code, out, err = self.ask([running], *assignments("--set-param", TUNED))
        self.assertEqual((code, out), (0, "slam.matcher.max_range_m is 8\nslam.map.min_translation_m is 0.5\n"), err)
        self.assertEqual(self.ask([running], "--set-param", "slam.source.rate=0")[0], 0)
        tuned = self.hashes(running)
        self.assertEqual(tuned, self.tuned_from_the_start())
        self.assertNotEqual(tuned, self.reference(SCANS))

    def test_parameters_edited_in_a_file_act_as_if_given_at_the_start(self):
        file = self.folder / "params.yaml"

        def edit(params):
            fresh = self.folder / "fresh.yaml"  # Replaced in one step: the demo must not read half a file.
            fresh.write_text("".join(f"{path}: {value}\n" for path, value in params.items()))
            fresh.rename(file)

        def await_sentences(*sentences):
            missing = set(sentences)
            while missing:
                line = running.stderr.readline()
                self.assertNotEqual(line, "", f"the demo has ended without saying {missing}")
                missing = {sentence for sentence in missing if sentence not in line}

        def nested(params, rate):
            return {"slam": json.dumps({"source": {"rate": rate}, **params})}

        tuned = {"matcher": {"max_range_m": 8}, "map": {"min_translation_m": 0.5}}
        edit(nested({}, 0.001))
        running = self.start("--json", "--scans", SCANS, "--params", file, env=self.own)
        self.ask([running], "--list-params")  # Then it has read the file.
        edit(nested({"matcher": {"max_range": 8}}, 0.001))
        await_sentences("There is no parameter slam.matcher.max_range. Did you mean slam.matcher.max_range_m?")
        edit(nested(tuned, 0.001))
        await_sentences("slam.matcher.max_range_m is 8 from", "slam.map.min_translation_m is 0.5 from")
        edit(nested(tuned, 0))
        self.assertEqual(self.hashes(running), self.tuned_from_the_start())

    def test_each_of_three_processes_offers_the_parameters_of_its_nodes(self):
        processes = self.start_three()
        # The source is ready last: it begins when all others are there.
        self.assertEqual(self.ask(processes.values(), *assignments("--set-param", TUNED))[0], 0)
        _, out, _ = self.ask(processes.values(), "--list-params", "--json")
        listed = {one["path"]: one for one in map(json.loads, out.splitlines())}
        self.assertEqual({path: float(listed[path]["value"]) for path in TUNED}, TUNED)
        self.assertEqual(listed["slam.map.cell_size_m"]["read_only"], True)
        self.assertEqual(listed["slam.matcher.revisit.lag_m"]["unit"], "m")
        self.assertEqual(self.ask(processes.values(), "--set-param", "slam.source.rate=0")[0], 0)
        self.assert_all_agree(processes, self.tuned_from_the_start())

    def test_refused_parameters_change_nothing(self):
        running = self.start("--json", *SLOW, env=self.own)
        for arguments, sentence in (
                (["slam.map.cell_size_m=0.1"], "slam.map.cell_size_m is read-only."),
                (["slam.map.hit_gains=5"], "There is no parameter slam.map.hit_gains. Did you mean slam.map.hit_gain?"),
                (["slam.map.hit_gain=50", "slam.map.miss_loss=-1"],
                 "slam.map.miss_loss must be from 0.0 to 127.0, but is the number -1.")):
            words = [word for text in arguments for word in ("--set-param", text)]
            code, out, err = self.ask([running], *words)
            self.assertEqual((code, out), (2, ""), err)
            self.assertIn(sentence, err)
        self.assertEqual(self.ask([running], "--set-param", "slam.source.rate=0")[0], 0)
        self.assertEqual(self.hashes(running), self.reference(SCANS))

    def test_setting_a_parameter_reports_that_no_demo_runs(self):
        code, _, err = self.end(self.start("--set-param", "slam.map.hit_gain=5", env=self.own))
        self.assertEqual(code, 1)
        self.assertIn("The parameters of the mapper were not set: No session \"slam2d/mapper\" offers parameters", err)

    def test_a_mapper_that_takes_over_draws_with_its_own_parameters(self):
        extra = {"robot1": ["--scans", SCANS, "--move-mapper-at", 120], "robot2": ["--param", "slam.map.hit_gain=30"]}
        processes = self.start_plan(ROBOTS, extra)
        self.assertEqual(self.end(processes["robot2"])[0], 0)
        self.assertNotEqual(self.hashes(processes["robot1"]), self.reference(SCANS))

    def test_a_mapper_with_other_cells_takes_over_nothing(self):
        extra = {"robot1": ["--scans", SCANS, "--move-mapper-at", 120, "--patience", 10],
                 "robot2": ["--param", "slam.map.cell_size_m=0.1"]}
        processes = self.start_plan(ROBOTS, extra)
        code, _, err = self.end(processes["robot2"])
        self.assertEqual(code, 1)
        self.assertIn("the received map has slam.map.cell_size_m = 0.05, but here it is 0.1.", err)
        self.assertEqual(self.end(processes["robot1"])[0], 1)


if __name__ == "__main__":
    main(Slam2dParameters)
