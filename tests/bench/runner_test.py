#!/usr/bin/env python3
"""Runs bench/support/runner.sh with a script in place of a benchmark, and checks that nothing is left behind.

    HGROS_BENCH=<bench> runner_test.py [TEST...]
"""

import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import unittest

BENCH = pathlib.Path(os.environ["HGROS_BENCH"])
# Leaves a file where sessions and programs leave theirs, starts a child, and prints "running,PID OF THE CHILD,count".
RUN = """#!/usr/bin/env bash
question=fake
source "$(dirname -- "$0")/../support/runner.sh"
measure() {
  echo > "$TMPDIR/left"
  sleep 1000 &
  echo "running,$!,count"
  BODY
}
relay measure
"""


class Runner(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="hgros_runner_test_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.temporary = self.folder / "tmp"
        self.temporary.mkdir()
        (self.folder / "fake").mkdir()
        shutil.copytree(BENCH / "support", self.folder / "support")
        self.results = self.folder / "results" / "fake"

    def start(self, body):
        script = self.folder / "fake" / "run"
        script.write_text(RUN.replace("BODY", body))
        script.chmod(0o755)
        return subprocess.Popen(
            [script, "--csv"], stdout=subprocess.PIPE, text=True, start_new_session=True,
            env={**os.environ, "HGROS_BUILD_DIR": str(self.folder), "TMPDIR": str(self.temporary)},
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))

    def end(self, program, sent=None):
        """(output, exit status). Checks that the child of the script is gone."""
        first = program.stdout.readline()
        if sent is not None:
            program.send_signal(sent)
        rest = program.stdout.read()
        program.stdout.close()
        program.wait(timeout=30)
        child = int(first.split(",")[1])
        status = pathlib.Path(f"/proc/{child}/stat")
        self.assertTrue(not status.exists() or status.read_text().rpartition(")")[2].split()[0] in "ZX")
        self.assertEqual(list(self.temporary.iterdir()), [])
        return first + rest, program.returncode

    def test_a_result_is_printed_and_kept_and_all_other_files_are_gone(self):
        said, code = self.end(self.start("echo 'value,1,us'"))
        self.assertEqual(code, 0)
        self.assertIn("value,1,us\n", said)
        self.assertEqual((self.results / "result.csv").read_text(), said)
        self.assertIn("`./dev bench fake`", (self.results / "machine.txt").read_text())

    def test_signals_end_everything_and_keep_the_previous_result(self):
        self.results.mkdir(parents=True)
        (self.results / "result.csv").write_text("value,7,us\n")
        for number in (signal.SIGTERM, signal.SIGINT):
            _, code = self.end(self.start("wait"), number)
            self.assertNotEqual(code, 0)
            self.assertEqual((self.results / "result.csv").read_text(), "value,7,us\n")

    def test_the_runner_fails_if_the_benchmark_fails(self):
        _, code = self.end(self.start("return 3"))
        self.assertEqual(code, 3)
        self.assertFalse((self.results / "result.csv").exists())


if __name__ == "__main__":
    unittest.main()
