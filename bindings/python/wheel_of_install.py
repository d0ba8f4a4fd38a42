"""Builds a wheel of what CMake installs (PEP 517): the package, and beside it the library and the commands.

The libraries that those need (protobuf, ZeroMQ and others) are Debian's, so the wheel is for Debian 12. With
`-C build=FOLDER`, what that folder has built is packed, and nothing is compiled.
"""

from __future__ import annotations

import base64
import hashlib
import io
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
# The folders of the build with what a program of Python needs; the rest need not be built.
PARTS = ("proto", "src/hgros", "apps/hgros", "bindings/python")
PACKAGES = f"lib/python3.{sys.version_info.minor}/dist-packages"


def _version() -> str:
    found = re.search(r"project\(hgros VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())
    assert found is not None
    return found[1]


def _metadata() -> str:
    # It names no packages: Debian's protobuf has the same library as the module, that of a registry has not.
    return (f"Metadata-Version: 2.1\nName: hgros\nVersion: {_version()}\n"
            "Summary: HyperGraph ROS for Python, with its library and commands\nLicense: MIT\nRequires-Python: >=3.11\n")


def _install(build: str | None, prefix: pathlib.Path) -> None:
    if build is None:
        build = str(ROOT / "build" / "wheel")
        subprocess.run(["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                        "-DHGROS_BUILD_TESTS=OFF", "-DHGROS_BUILD_VIEWER=OFF", f"-DPython_EXECUTABLE={sys.executable}"],
                       check=True)
        subprocess.run(["cmake", "--build", build, "--target", "hgros_python_package",
                        *(f"{part}/all" for part in PARTS)], check=True)
    for part in PARTS:
        subprocess.run(["cmake", f"-DCMAKE_INSTALL_PREFIX={prefix}", "-P", f"{build}/{part}/cmake_install.cmake"],
                       check=True, stdout=subprocess.DEVNULL)
    if not (prefix / PACKAGES / "hgros").is_dir():
        raise SystemExit(f"{build} was built without Python. Install python3-dev and pybind11-dev.")


def build_wheel(wheel_directory: str, config_settings: dict[str, str] | None = None,
                metadata_directory: str | None = None) -> str:
    name = f"hgros-{_version()}"
    tag = f"cp3{sys.version_info.minor}-cp3{sys.version_info.minor}-" + re.sub("[-.]", "_", sysconfig.get_platform())
    file = f"{name}-{tag}.whl"
    records = []
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(pathlib.Path(wheel_directory, file), "w",
                                                                  zipfile.ZIP_DEFLATED) as wheel:
        prefix = pathlib.Path(folder)
        _install((config_settings or {}).get("build"), prefix)

        def add(place: str, data: bytes, mode: int = 0o644) -> None:
            entry = zipfile.ZipInfo(place, (1980, 1, 1, 0, 0, 0))
            entry.external_attr = (0o100000 | mode) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            wheel.writestr(entry, data)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            records.append(f"{place},sha256={digest},{len(data)}\n")

        for path in sorted(prefix.rglob("*")):
            if not path.is_file():
                continue
            inside = path.relative_to(prefix).as_posix()
            data = path.read_bytes()
            if inside.startswith(PACKAGES + "/"):
                add(inside.removeprefix(PACKAGES + "/"), data)
            elif inside.startswith(("bin/", "share/hgros/components/")) or re.search(r"\.so\.[0-9]+\.[0-9]+$", inside):
                if inside == "share/hgros/components/python.yaml":
                    data = data.replace(b"dist-packages", b"site-packages")
                add(f"{name}.data/data/{inside}", data, path.stat().st_mode & 0o777)
        add(f"{name}.dist-info/METADATA", _metadata().encode())
        add(f"{name}.dist-info/WHEEL",
            f"Wheel-Version: 1.0\nGenerator: hgros\nRoot-Is-Purelib: false\nTag: {tag}\n".encode())
        record = f"{name}.dist-info/RECORD"
        wheel.writestr(record, "".join(records) + f"{record},,\n")
    return file


def build_sdist(sdist_directory: str, config_settings: dict[str, str] | None = None) -> str:
    name = f"hgros-{_version()}"
    files = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True).stdout.split(b"\0")
    with tarfile.open(pathlib.Path(sdist_directory, f"{name}.tar.gz"), "w:gz", format=tarfile.PAX_FORMAT) as archive:
        for one in map(os.fsdecode, filter(None, files)):
            if (ROOT / one).exists():
                archive.add(ROOT / one, f"{name}/{one}", recursive=False)
        data = _metadata().encode()
        entry = tarfile.TarInfo(f"{name}/PKG-INFO")
        entry.size = len(data)
        archive.addfile(entry, io.BytesIO(data))
    return f"{name}.tar.gz"
