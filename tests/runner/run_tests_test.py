"""Runs the runner on folders whose tests fail in known ways. ctest really runs them."""

import contextlib
import io
import pathlib
import tempfile
import unittest
from unittest import mock

import run_tests

FAILURE = "[ RUN      ] Planted.Test\n/src/tests/planted_test.cpp:7: Failure\nExpected: 1\n  seed = 42"


class RunTestsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "CTestTestfile.cmake").touch()
        waiting = mock.patch.object(run_tests, "wait_until_calm")
        self.waits = waiting.start()
        self.addCleanup(waiting.stop)

    def add(self, name, failures, output=FAILURE, end="exit 1", labels=""):
        """A test that fails so many times before it passes. It counts its runs in a file."""
        (self.folder / f"{name}.output").write_text(output)
        script = self.folder / f"{name}.sh"
        script.write_text(f"echo run >> {self.folder}/{name}.runs\n"
                          f"[ $(wc -l < {self.folder}/{name}.runs) -le {failures} ] || exit 0\n"
                          f"cat {self.folder}/{name}.output\n{end}\n")
        with open(self.folder / "CTestTestfile.cmake", "a", encoding="ascii") as file:
            file.write(f'add_test({name} "sh" "{script}")\nset_tests_properties({name} PROPERTIES TIMEOUT 20 LABELS "{labels}")\n')

    def runs(self, name):
        return len((self.folder / f"{name}.runs").read_text().splitlines())

    def run_all(self, *arguments):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            self.code = run_tests.main([str(self.folder), "4", *arguments])
        return printed.getvalue()

    def test_a_run_without_failures_repeats_nothing(self):
        self.add("good", failures=0)
        self.assertNotIn("UNSTABLE", self.run_all())
        self.assertEqual((self.code, self.runs("good")), (0, 1))

    def test_a_test_that_passes_alone_is_unstable_and_fails_nothing(self):
        self.add("Load.Once", failures=1)
        self.add("Load.Twice", failures=2)
        self.add("good", failures=0)
        printed = self.run_all()
        self.assertIn("UNSTABLE Load.Once, seed 42, /src/tests/planted_test.cpp:7: Failure Expected: 1\n", printed)
        self.assertIn("UNSTABLE Load.Twice, seed 42,", printed)
        self.assertEqual((self.code, self.runs("Load.Once"), self.runs("Load.Twice"), self.runs("good")), (0, 2, 3, 1))
        self.assertEqual(self.waits.call_count, 3)

    def test_of_a_suite_the_test_that_failed_is_unstable(self):
        self.add("Suite", failures=1, output=FAILURE + "\n[  FAILED  ] Suite.Second, where GetParam() = 2 (3 ms)\n")
        self.assertIn("UNSTABLE Suite.Second, seed 42, /src/tests/planted_test.cpp:7: Failure", self.run_all())

    def test_skipped_tests_are_listed_by_reason(self):
        skip = "[ RUN      ] S.{0}\na_test.cpp:3: Skipped\nno root\n\n[  SKIPPED ] S.{0} (0 ms)\n"
        self.add("S", failures=1, output="".join(skip.format(name) for name in "ABC"), end="exit 0")
        self.assertIn("\nSkipped: S.A and 2 more: no root\n", self.run_all())

    def test_three_failures_of_one_test_fail_the_run(self):
        self.add("wrong", failures=3)
        self.add("good", failures=0)
        self.run_all()
        self.assertNotEqual(self.code, 0)
        self.assertEqual((self.runs("wrong"), self.runs("good")), (3, 1))

    def assert_fails_at_once(self, name, *arguments):
        self.run_all(*arguments)
        self.assertNotEqual(self.code, 0)
        self.assertEqual(self.runs(name), 1)

    def test_what_load_cannot_cause_does_not_repeat(self):
        self.add("model", failures=1, labels="pure;slow")
        for signal in ("SEGV", "ABRT", "KILL", "ILL"):
            self.add(signal, failures=1, end=f"kill -{signal} $$")
        reports = {"asan": "==1==ERROR: AddressSanitizer: heap-use-after-free", "tsan": "WARNING: ThreadSanitizer: data race",
                   "lsan": "==1==ERROR: LeakSanitizer: detected memory leaks",
                   "ubsan": "/src/a.cpp:1:2: runtime error: signed integer overflow",
                   "child": "terminate called after throwing an instance of 'std::bad_alloc'",
                   "long": ("x" * 1000 + "\n") * 1000 + "WARNING: ThreadSanitizer: data race\n"}
        for name, output in reports.items():
            self.add(name, failures=1, output=output)
        build = run_tests.Build(self.folder)
        with contextlib.redirect_stdout(io.StringIO()):
            failed, labels = build.run(["-j", "4"])[1], build.labels()
        for name in ("model", "SEGV", "ABRT", "KILL", "ILL", *reports):
            self.assertTrue(run_tests.why_not_repeated(name, *failed[name], labels), name)

    def test_a_signal_in_a_repeat_fails_the_run(self):
        self.add("crash", failures=2, end="[ $(wc -l < $0.ran) -le 1 ] || kill -SEGV $$; exit 1")
        script = self.folder / "crash.sh"
        script.write_text("echo run >> $0.ran\n" + script.read_text())
        self.run_all()
        self.assertNotEqual(self.code, 0)
        self.assertEqual(self.runs("crash"), 2)

    def test_a_fault_beside_a_test_that_load_may_fail_fails_at_once(self):
        self.add("load", failures=1)
        self.add("signal", failures=1, end="kill -SEGV $$")
        self.assert_fails_at_once("load")

    def test_repetitions_of_ctest_itself_are_all(self):
        self.add("load", failures=1)
        self.run_all("--repeat", "until-fail:3")
        self.assertNotEqual(self.code, 0)
        self.assertEqual(self.runs("load"), 1)

    def test_unstable_tests_are_named_if_another_one_fails(self):
        self.add("aload", failures=1)
        self.add("wrong", failures=3)
        self.assertIn("UNSTABLE aload, seed 42,", self.run_all())
        self.assertNotEqual(self.code, 0)

    def test_a_crash_of_leak_sanitizer_itself_repeats(self):
        self.add("tracer", failures=1, output="Tracer caught signal 11: addr=0x1\n==1==LeakSanitizer has encountered a fatal error.")
        self.assertIn("UNSTABLE tracer, no seed, ==1==LeakSanitizer has encountered a fatal error.", self.run_all())
        self.assertEqual(self.code, 0)

    def test_more_than_eight_failures_do_not_repeat(self):
        for number in range(9):
            self.add(f"fails{number}", failures=1)
        self.assert_fails_at_once("fails3")

    def test_strict_does_not_repeat(self):
        self.add("load", failures=1)
        self.assert_fails_at_once("load", "--strict")

    def test_a_missing_program_and_no_test_at_all_fail_the_run(self):
        self.run_all()
        self.assertNotEqual(self.code, 0)
        (self.folder / "CTestTestfile.cmake").write_text('add_test(missing "/nonexistent/program")\n')
        self.run_all()
        self.assertNotEqual(self.code, 0)
        self.waits.assert_not_called()


class WaitUntilCalmTest(unittest.TestCase):
    def samples(self, shares, seconds=60):
        busy = mock.Mock(side_effect=shares)
        run_tests.wait_until_calm(seconds, busy)
        return busy.call_count

    def test_two_calm_seconds_in_a_row_are_enough(self):
        self.assertEqual(self.samples([1, 0.1, 0.9, 0.1, 0.2]), 5)

    def test_it_gives_up_on_a_machine_that_stays_busy(self):
        self.assertEqual(self.samples([1] * 10, seconds=10), 10)


if __name__ == "__main__":
    unittest.main()
