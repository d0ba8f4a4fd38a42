#!/usr/bin/env python3
"""Fails if a source of the library that docs/platforms.md does not name cannot be compiled for Windows by mingw-w64.

    check_windows.py ROOT PROTO_INCLUDE JOBS

PROTO_INCLUDE is the folder of the headers that protoc generates. Nothing is linked. Sources that the page names must be
there, but are not compiled. The libraries' headers are those of Linux: they contain what Windows needs.
"""

import concurrent.futures
import pathlib
import re
import subprocess
import sys
import tempfile

COMPILER = ["x86_64-w64-mingw32-g++-posix", "-std=c++20", "-fsyntax-only", "-w", '-DHGROS_VERSION=""']
# Not all of /usr/include, which has the C library of Linux.
LIBRARIES = ["google", "tbb", "oneapi", "spdlog", "fmt", "yaml-cpp", "zmq.h", "urdf_exception", "urdf_model",
             "urdf_model_state", "urdf_parser", "urdf_sensor", "urdf_world", "tinyxml.h"]
EIGEN = "/usr/include/eigen3"


def compile_one(root, options, source):
    """The first error of a source, or None."""
    result = subprocess.run([*COMPILER, *options, source], cwd=root, capture_output=True, text=True, check=False)
    if result.returncode == 0:
        return None
    errors = [line for line in result.stderr.splitlines() if "error:" in line]
    return f"{source}: {errors[0] if errors else result.stderr.strip()}"


def main():
    root, generated, jobs = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve(), int(sys.argv[3])
    page = (root / "docs/platforms.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`(src/[\w/.]+\.cpp)`", page))
    sources = [path for path in sorted(p.relative_to(root).as_posix() for p in (root / "src").rglob("*.cpp"))
               if path not in named]
    with tempfile.TemporaryDirectory() as folder:
        for name in LIBRARIES:
            (pathlib.Path(folder) / name).symlink_to(f"/usr/include/{name}")
        options = ["-Iinclude", "-Isrc", "-Isrc/include", "-isystem", str(generated), "-isystem", folder, "-isystem", EIGEN]
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            faults = [fault for fault in pool.map(lambda source: compile_one(root, options, source), sources) if fault]
    for fault in faults:
        print(fault, file=sys.stderr)
    print(f"{len(sources) - len(faults)} of {len(sources)} sources compile for Windows; "
          f"docs/platforms.md names {len(named)} that need another system.", file=sys.stderr)
    return 1 if faults or not sources else 0


if __name__ == "__main__":
    sys.exit(main())
