"""run_tests.py [--strict] FOLDER JOBS [CTEST ARGUMENTS]: runs the tests of a build folder with ctest, JOBS at a time, and
those that failed again, one at a time, when the machine is calm. A test that passes alone is printed as UNSTABLE and does
not fail the run. Three failures of one test do.

A failure counts at once, without repeating, where load cannot be the cause: a process died by a signal, a sanitizer
reported something, or the test is labelled `pure`. So do more than eight failures. --strict never repeats. LeakSanitizer
of GCC 12 sometimes crashes itself while a thread ends ("Tracer caught signal 11"): that is no report, so the test repeats.
"""

import json
import pathlib
import re
import subprocess
import sys
import time
import xml.etree.ElementTree

MOST_REPEATED = 8
REPEATS = 2
LOAD_MAY_CAUSE = ("Failed", "Timeout")  # Of ctest's reasons. The others are signals and programs that are missing.
FAILED_TEST = re.compile(r"^\t *\d+ - (.+) \(([^()]+)\)$", re.M)
REPORT = re.compile(r"(ERROR|WARNING): \w+Sanitizer|SUMMARY: \w+Sanitizer|runtime error:")
SEED = re.compile(r"\bseed\b\D{0,4}(\d+)", re.I)


def first_failing_line(reason, output):
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    for index, line in enumerate(lines):
        if re.search(r":\d+: Failure$", line):  # GoogleTest prints the details below.
            return " ".join(lines[index:index + 2])
    for line in lines:
        if re.search(r"\w+Error\b|\berror:|has encountered a fatal error|\bpanicked\b", line):
            return line
    return f"{reason}: {lines[-1] if lines else 'no output'}"


def seed_of(output):
    found = SEED.search(output)
    return "seed " + found.group(1) if found else "no seed"


def busy_share():
    """The share of the processors' time that was used in the next second."""
    def times():
        with open("/proc/stat", encoding="ascii") as file:
            values = [int(value) for value in file.readline().split()[1:9]]
        return sum(values), values[3] + values[4]  # all; idle and waiting for disks
    total, idle = times()
    time.sleep(1)
    total_later, idle_later = times()
    return 1 - (idle_later - idle) / max(total_later - total, 1)


def wait_until_calm(seconds=60, busy=busy_share):
    calm = 0
    for _ in range(seconds):
        calm = calm + 1 if busy() < 0.25 else 0
        if calm == 2:
            return


class Build:
    """A build folder whose tests ctest runs."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.report = self.folder.resolve() / "Testing" / "report.xml"

    def run(self, arguments):
        """Returns ctest's exit status, and of each failed test its reason and output."""
        self.report.unlink(missing_ok=True)
        lines = []
        command = ["ctest", "--test-dir", self.folder, "--output-on-failure", "--no-tests=error",
                   "--output-junit", self.report]
        with subprocess.Popen(command + arguments, stdout=subprocess.PIPE, text=True, errors="replace") as ctest:
            for line in ctest.stdout:
                print(line, end="", flush=True)
                lines.append(line)
        summary = "".join(lines).rpartition("\nThe following tests FAILED:\n")[2] if ctest.returncode else ""
        reasons = dict(FAILED_TEST.findall(summary))
        outputs = {}
        if reasons and self.report.exists():
            for case in xml.etree.ElementTree.parse(self.report).iter("testcase"):
                outputs[case.get("name")] = case.findtext("system-out") or ""
        return ctest.returncode, {name: (reason, outputs.get(name, "")) for name, reason in reasons.items()}

    def labels(self):
        listing = subprocess.run(["ctest", "--test-dir", self.folder, "--show-only=json-v1"], capture_output=True, check=True)
        return {test["name"]: {value for known in test.get("properties", []) if known["name"] == "LABELS"
                               for value in known["value"]}
                for test in json.loads(listing.stdout)["tests"]}


def why_not_repeated(name, reason, output, labels):
    if reason not in LOAD_MAY_CAUSE:
        return f"{name} ended with: {reason}"
    if REPORT.search(output):
        return f"A sanitizer reported a fault in {name}"
    if "pure" in labels.get(name, ()):
        return f"{name} depends on no thread, process or clock"
    return None


def run(folder, jobs, arguments, strict):
    build = Build(folder)
    code, failed = build.run(["-j", jobs] + arguments)
    if code == 0 or strict or not failed:
        return code
    if len(failed) > MOST_REPEATED:
        print(f"{len(failed)} tests failed, more than {MOST_REPEATED}: none runs again.")
        return code
    labels = build.labels()
    unstable = []
    for name, first in failed.items():
        last = first
        for repeat in range(1, REPEATS + 1):
            reason = why_not_repeated(name, *last, labels)
            if reason:
                print(f"{reason}: it does not run again.")
                return code
            print(f"\n{name} failed. It runs again, alone, {repeat} of {REPEATS}, when the machine is calm.", flush=True)
            wait_until_calm()
            code_alone, failed_alone = build.run(["-R", f"^{re.escape(name)}$"])
            if code_alone == 0:
                break
            if name not in failed_alone:
                return code
            last = failed_alone[name]
        else:
            print(f"{name} failed {REPEATS + 1} times.")
            return code
        unstable.append(f"UNSTABLE {name}, {seed_of(first[1])}, {first_failing_line(*first)}")
    print()
    print("\n".join(unstable))
    return 0


def main(arguments):
    strict = "--strict" in arguments
    folder, jobs, *rest = [argument for argument in arguments if argument != "--strict"]
    return run(folder, jobs, rest, strict)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
