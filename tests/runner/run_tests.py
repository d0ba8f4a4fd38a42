"""run_tests.py [--strict] FOLDER JOBS [CTEST ARGUMENTS]: runs the tests of a build folder with ctest, JOBS at a time, and
those that failed again, one at a time, when the machine is calm. A test that passes alone is printed as UNSTABLE and does
not fail the run. Three failures of one test do.

A failure counts at once, without repeating, where load cannot be the cause: a process died by a signal, a sanitizer
reported something, or the test is labelled `pure`. So do more than eight failures. --strict never repeats. LeakSanitizer
sometimes crashes itself while a thread ends ("Tracer caught signal 11"): that is no report, so the test repeats.
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
COUNT = re.compile(r"^\d+% tests passed, (\d+) tests? failed out of \d+$", re.M)
# Of a sanitizer, or what a process says when it dies by itself.
REPORT = re.compile(r"(ERROR|WARNING): \w+Sanitizer|SUMMARY: \w+Sanitizer|runtime error:|terminate called|"
                    r"Assertion .* failed|Segmentation fault|core dumped|stack smashing detected|double free")
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


def failed_test(name, output):
    """The first test of a suite that failed, or the entry's own name."""
    found = re.search(r"^\[  FAILED  \] ([^\s,]+)", output, re.M)
    return found.group(1) if found else name


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
                   "--output-junit", self.report, "--test-output-size-failed", str(100 << 20)]
        with subprocess.Popen(command + arguments, stdout=subprocess.PIPE, text=True, errors="replace") as ctest:
            for line in ctest.stdout:
                print(line, end="", flush=True)
                lines.append(line)
        summary = "".join(lines).rpartition("\nThe following tests FAILED:\n")[2] if ctest.returncode else ""
        reasons = dict(FAILED_TEST.findall(summary))
        if sum(int(count) for count in COUNT.findall("".join(lines))) != len(reasons):
            reasons = {}  # Not all of the failures are known by name.
        outputs = {}
        if reasons and self.report.exists():
            for case in xml.etree.ElementTree.parse(self.report).iter("testcase"):
                outputs[case.get("name")] = case.findtext("system-out") or ""
        return ctest.returncode, {name: (reason, outputs.get(name, "")) for name, reason in reasons.items()}

    def skipped(self):
        """For each reason that tests of GoogleTest gave for not running: a line with the first of them."""
        log = self.folder / "Testing" / "Temporary" / "LastTest.log"
        text = log.read_text(errors="replace") if log.exists() else ""
        tests = {}
        for reason, name in re.findall(r": Skipped\n(.*)\n(?:(?!\[).*\n)*\[  SKIPPED \] (\S+) \(\d+ ms\)\n", text):
            tests.setdefault(reason, []).append(name)
        return [f"Skipped: {names[0]}{f' and {len(names) - 1} more' if names[1:] else ''}: {reason}"
                for reason, names in tests.items()]

    def labels(self):
        listing = subprocess.run(["ctest", "--test-dir", self.folder, "--show-only=json-v1"], capture_output=True, check=True)
        return {test["name"]: {value for known in test.get("properties", []) if known["name"] == "LABELS"
                               for value in known["value"]}
                for test in json.loads(listing.stdout)["tests"]}


def why_not_repeated(name, reason, output, labels):
    if reason not in LOAD_MAY_CAUSE:
        return f"{name} ended with: {reason}"
    if REPORT.search(output):
        return f"A process of {name} reported a fault"
    if "pure" in labels.get(name, ()):
        return f"{name} depends on no thread, process or clock"
    return None


def run(folder, jobs, arguments, strict):
    build = Build(folder)
    code, failed = build.run(["-j", jobs] + arguments)
    print("\n" + "\n".join(build.skipped()))
    if code == 0 or strict or not failed:
        return code
    if len(failed) > MOST_REPEATED:
        print(f"{len(failed)} tests failed, more than {MOST_REPEATED}: none runs again.")
        return code
    labels = build.labels()
    for name, first in failed.items():
        if reason := why_not_repeated(name, *first, labels):
            print(f"{reason}: no test runs again.")
            return code
    unstable = []
    for name, first in failed.items():
        if not passes_alone(build, name, labels):
            break
        unstable.append(f"UNSTABLE {failed_test(name, first[1])}, {seed_of(first[1])}, {first_failing_line(*first)}")
    else:
        code = 0
    print()
    print("\n".join(unstable))
    return code


def passes_alone(build, name, labels):
    for repeat in range(1, REPEATS + 1):
        print(f"\n{name} failed. It runs again, alone, {repeat} of {REPEATS}, when the machine is calm.", flush=True)
        wait_until_calm()
        code, failed = build.run(["-R", f"^{re.escape(name)}$"])
        if code == 0:
            return True
        reason = why_not_repeated(name, *failed[name], labels) if name in failed else f"{name} could not run again"
        if reason:
            print(f"{reason}: it does not run again.")
            return False
    print(f"{name} failed {REPEATS + 1} times.")
    return False


def main(arguments):
    # ctest's own repetition says what counts.
    strict = "--strict" in arguments or any(argument.startswith("--repeat") for argument in arguments)
    folder, jobs, *rest = [argument for argument in arguments if argument != "--strict"]
    return run(folder, jobs, rest, strict)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
