"""crashed_tracer.py FOLDER: ends with 0 if LeakSanitizer's own fault is why each failed test of ctest's last run in the
build folder has failed.

After a test has passed, LeakSanitizer stops all threads and looks through their memory. With GCC 12 this crashes by itself
now and then, if a thread is just ending: `Tracer caught signal 11`. Then nothing is known about leaks.
"""

import pathlib
import re
import sys

CRASHED = "LeakSanitizer has encountered a fatal error."
FOUND = re.compile(r"ERROR: \w+Sanitizer|runtime error:|SUMMARY: \w+Sanitizer|^\[  FAILED  \]", re.M)


def is_tracers_fault(output):
    return "Tracer caught signal" in output and CRASHED in output and not FOUND.search(output)


def main():
    logs = pathlib.Path(sys.argv[1], "Testing", "Temporary")
    names = logs / "LastTestsFailed.log"  # Missing if no test has run.
    failed = {line.split(":", 1)[1] for line in names.read_text().splitlines()} if names.exists() else set()
    outputs = {}
    for part in re.split(r"(?m)^\d+/\d+ Testing: ", (logs / "LastTest.log").read_text(errors="replace"))[1:]:
        outputs[part.split("\n", 1)[0]] = part
    sys.exit(0 if failed and all(is_tracers_fault(outputs.get(name, "")) for name in failed) else 1)


if __name__ == "__main__":
    main()
