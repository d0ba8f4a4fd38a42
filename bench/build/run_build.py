#!/usr/bin/env python3
"""Measures the cost of building in CPU seconds and wall seconds, and prints "metric,value,unit" lines.

Each commit is unpacked into its own folder and built from nothing with CCACHE_DISABLE=1. CPU seconds are the sum over
all processes of a build (user and system). A busy machine distorts them less than wall seconds.
"""

import argparse
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
PARTS = {  # metric: (preset, targets)
    "demo": ("dev", ["slam2d", "hgros_command"]),
    "test_build": ("dev", []),
}
LOG = "bench_build.log"
QUICK = {"core_build": ("release", ["hgros_base", "hgros_clock"])}


def git(*arguments):
    return subprocess.run(["git", "-C", str(ROOT), *arguments], check=True, capture_output=True, text=True).stdout.strip()


def commit_of(name):
    try:
        return git("rev-parse", "--verify", "--quiet", f"{name}^{{commit}}")
    except subprocess.CalledProcessError:
        sys.exit(f'There is no commit "{name}" in this repository.')


def working_tree():
    """The working tree as a commit, without files that git does not track yet."""
    return git("stash", "create") or git("rev-parse", "HEAD")


def unpack(commit, folder):
    folder.mkdir(parents=True)
    archive = subprocess.Popen(["git", "-C", str(ROOT), "archive", commit], stdout=subprocess.PIPE)
    subprocess.run(["tar", "-x", "-C", str(folder)], stdin=archive.stdout, check=True)
    if archive.wait() != 0:
        sys.exit(f"git could not unpack {commit}.")


def timed(commands, folder, what):
    """(CPU seconds, wall seconds) of commands run one after another."""
    log = folder / LOG
    environment = dict(os.environ, CCACHE_DISABLE="1")
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.monotonic()
    with open(log, "w", encoding="utf-8") as out:
        for command in commands:
            if subprocess.run(command, cwd=folder, env=environment, stdout=out, stderr=out, check=False).returncode != 0:
                sys.stderr.write("".join(log.read_text(errors="replace").splitlines(keepends=True)[-30:]))
                sys.exit(f"{what} failed. The last lines of its output are above.")
    wall = time.monotonic() - begin
    now = resource.getrusage(resource.RUSAGE_CHILDREN)
    return now.ru_utime + now.ru_stime - used.ru_utime - used.ru_stime, wall


def build(commit, preset, targets, scratch, what):
    folder = scratch / "tree"
    unpack(commit, folder)
    target = ["--target", *targets] if targets else []
    try:
        return timed([["cmake", "--preset", preset],
                      ["cmake", "--build", f"build/{preset}", "-j", str(os.cpu_count()), *target]], folder, what)
    finally:
        shutil.rmtree(folder)


def ci(commit, scratch):
    folder = scratch / "clone"
    subprocess.run(["git", "clone", "--quiet", str(ROOT), str(folder)], check=True)
    subprocess.run(["git", "-C", str(folder), "fetch", "--quiet", str(ROOT), commit], check=True)
    subprocess.run(["git", "-C", str(folder), "checkout", "--quiet", "--detach", "FETCH_HEAD"], check=True)
    try:
        cpu, wall = timed([["bash", ".ci/run"]], folder, ".ci/run")
        log = (folder / LOG).read_text(errors="replace")
    finally:
        shutil.rmtree(folder)
    # Its first section is ./dev test, of which its table and ctest give the time.
    say("test_wall_s", float(re.search(r"^ *(\d+) s  passed  tests,", log, re.M)[1]), "s")
    say("test_run_s", float(re.search(r"^Total Test time \(real\) = +([\d.]+) sec", log, re.M)[1]), "s")
    say("ci_wall_s", wall, "s")
    say("ci_cpu_s", cpu, "s")


def say(metric, value, unit):
    print(f"{metric},{value:.3f}" if unit == "ratio" else f"{metric},{value:.1f}", unit, sep=",", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--folder", required=True, type=pathlib.Path)
    parser.add_argument("--before")
    parser.add_argument("--only", action="append", choices=[*PARTS, "ci"])
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    if arguments.quick and arguments.only:
        parser.error("--quick always builds two modules and nothing else; leave out --quick or --only.")
    parts = QUICK if arguments.quick else {name: part for name, part in PARTS.items()
                                           if not arguments.only or name in arguments.only}
    commits = {"": working_tree()}
    if arguments.before:
        commits["before_"] = commit_of(arguments.before)
    for name, (preset, targets) in parts.items():
        cpu = {}
        for prefix, commit in reversed(commits.items()):
            cpu[prefix], wall = build(commit, preset, targets, arguments.folder, f"Building {name} of {commit[:12]}")
            say(f"{prefix}{name}_cpu_s", cpu[prefix], "s")
            say(f"{prefix}{name}_wall_s", wall, "s")
        if arguments.before:
            say(f"{name}_cpu_ratio", cpu[""] / cpu["before_"], "ratio")
    if not arguments.quick and (not arguments.only or "ci" in arguments.only):
        ci(commits[""], arguments.folder)


if __name__ == "__main__":
    main()
