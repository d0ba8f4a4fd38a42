"""The memory of a graphics card that a process uses (the machine's memory if the card has none), as its driver reports
it: in the kernel's files of open cards (amdgpu, i915, xe, msm, panfrost, v3d, nouveau ...), or through nvidia-smi. A
process that draws in software uses none, and has no figure."""

import pathlib
import re
import shutil
import subprocess
import time
import xml.etree.ElementTree

UNITS = {"": 1, "KiB": 2**10, "MiB": 2**20, "GiB": 2**30}
SMI_EVERY_S = 2  # One call takes nearly a second.


def has_card(devices=pathlib.Path("/dev/dri"), smi=shutil.which("nvidia-smi")):
    return any(devices.glob("renderD*")) or smi is not None


def client_of(text):
    """(identity of the client, bytes) of one open file. None if it is not a card's or its driver reports no memory."""
    fields = dict(re.findall(r"^(drm-[\w-]+):\s*(.*?)\s*$", text, re.MULTILINE))
    if "drm-driver" not in fields:
        return None
    # A driver reports them per region. The first kind that it reports is the best measure of the memory in use.
    for kind in ("resident", "memory", "total"):
        sizes = {}
        for key, value in fields.items():
            size = re.fullmatch(r"(\d+)\s*(\w*)", value)
            if key.startswith(f"drm-{kind}-") and size and size[2] in UNITS:
                sizes[key.rpartition("-")[2]] = int(size[1]) * UNITS[size[2]]
        own = [size for region, size in sizes.items() if region.startswith(("vram", "local"))]
        if sizes:
            client = fields["drm-driver"], fields.get("drm-pdev"), fields.get("drm-client-id")
            return client, sum(own or sizes.values())
    return None


def told_by_kernel(pid, proc=pathlib.Path("/proc")):
    """Bytes, or None. Several files may belong to one client."""
    clients = {}
    try:
        files = list((proc / str(pid) / "fdinfo").iterdir())
    except OSError:
        return None
    for file in files:
        try:
            client = client_of(file.read_text(encoding="utf-8", errors="replace"))
        except OSError:
            continue  # It was closed in the meantime.
        if client:
            name, size = client
            clients[name if name[2] is not None else (*name, file.name)] = size
    return sum(clients.values()) if clients else None


def told_by_nvidia(pid, report):
    """Bytes, or None. `report`: output of `nvidia-smi -q -x`."""
    try:
        root = xml.etree.ElementTree.fromstring(report)
    except xml.etree.ElementTree.ParseError:
        return None
    sizes = []
    for process in root.iter("process_info"):
        size = re.fullmatch(r"(\d+) (\w+)", process.findtext("used_memory", "").strip())
        if process.findtext("pid", "").strip() == str(pid) and size and size[2] in UNITS:
            sizes.append(int(size[1]) * UNITS[size[2]])
    return sum(sizes) if sizes else None


class Peak:
    """The largest value of all calls to look()."""

    def __init__(self, pid, proc=pathlib.Path("/proc"), smi=shutil.which("nvidia-smi")):
        self.pid = pid
        self.proc = proc
        self.smi = smi
        self.bytes = None
        self.smi_at = 0

    def look(self):
        now = time.monotonic()
        told = told_by_kernel(self.pid, self.proc)
        if told is None and self.smi and now >= self.smi_at:
            try:
                said = subprocess.run([self.smi, "-q", "-x"], capture_output=True, text=True, check=False, timeout=30).stdout
            except (OSError, subprocess.TimeoutExpired):
                said = ""
            told = told_by_nvidia(self.pid, said)
            self.smi_at = time.monotonic() + SMI_EVERY_S
        if told is not None:
            self.bytes = max(self.bytes or 0, told)
