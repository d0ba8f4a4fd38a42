"""Size of a viewer's installation in MB: the packages that a system with a window system does not have yet."""

import re
import shutil
import subprocess
import tempfile

WINDOW_SYSTEM = ("libgl1 libglx-mesa0 libgl1-mesa-dri libegl1 libegl-mesa0 libopengl0 libx11-6 libxext6 libxrandr2 libxi6 "
                 "libxcursor1 libxinerama1 libxkbcommon0 libsm6 libice6 libfontconfig1 libfreetype6 fonts-dejavu-core "
                 "libstdc++6").split()


def has(program):
    return shutil.which(program) is not None


def closure(packages):
    """All packages that apt would install for them on an empty system."""
    with tempfile.NamedTemporaryFile() as nothing:
        said = subprocess.run(["apt-get", "-o", f"Dir::State::status={nothing.name}", "-s", "--no-install-recommends", "install",
                               *packages], capture_output=True, text=True, check=True).stdout
    return {line.split()[1] for line in said.splitlines() if line.startswith("Inst ")}


def known():
    """{package: (MB, whether every system has it)}"""
    said = subprocess.run(["apt-cache", "dumpavail"], capture_output=True, text=True, check=True).stdout
    packages = {}
    for paragraph in said.split("\n\n"):
        fields = dict(re.findall(r"^([A-Za-z-]+): (.*)$", paragraph, re.MULTILINE))
        if "Package" in fields:
            packages[fields["Package"]] = (int(fields.get("Installed-Size", 0)) / 1024,
                                           fields.get("Priority") in ("required", "important") or "Essential" in fields)
    return packages


def libraries_of(program):
    """The packages of a program's shared libraries."""
    files = re.findall(r"=> (/\S+)", subprocess.run(["ldd", str(program)], capture_output=True, text=True, check=True).stdout)
    packages = set()
    for file in files:
        said = subprocess.run(["dpkg-query", "-S", file], capture_output=True, text=True, check=False)
        if said.returncode != 0:
            said = subprocess.run(["dpkg-query", "-S", "/usr" + file], capture_output=True, text=True, check=False)
        packages.update(line.split(":")[0] for line in said.stdout.splitlines()[:1])
    return sorted(packages)


def sizes(build):
    """("installed_mb", ...) and ("rviz_installed_mb", ...)"""
    if not has("apt-get"):
        return
    packages = known()
    base = closure(sorted(name for name, (_, everywhere) in packages.items() if everywhere)) | closure(WINDOW_SYSTEM)
    program = build / "apps/viewer/app/hgros-viewer"
    library = (build / "src/hgros/libhgros.so").resolve()
    ours = sum(packages.get(name, (0,))[0] for name in closure(libraries_of(program)) - base)
    with tempfile.TemporaryDirectory() as folder:
        for file in (program, library):
            subprocess.run(["strip", "-o", f"{folder}/stripped", str(file)], check=True)
            ours += len(open(f"{folder}/stripped", "rb").read()) / 2**20
    yield "installed_mb", ours
    if "rviz" in packages:
        yield "rviz_installed_mb", sum(packages.get(name, (0,))[0] for name in closure(["rviz", "python3-rosmaster"]) - base)
