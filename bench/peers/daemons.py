"""The environment of some peers: a separate network, rosmaster, iox-roudi. Everything ends with the benchmark."""

import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
INSIDE = "HGROS_PEERS_ISOLATED"  # set in the process that is already isolated


def isolate(required=False):
    """Runs this program again with only loopback and an empty /dev/shm, if the system allows it. If it does not,
    a message is printed, and the program ends if isolation is required."""
    if os.environ.get(INSIDE):
        subprocess.run("""mount -t tmpfs none /dev/shm && ip link set lo up && ip link set lo multicast on &&
            ip route add 224.0.0.0/4 dev lo""", shell=True, check=True)
        return
    if shutil.which("unshare") and shutil.which("ip"):
        for command in (["unshare", "-n", "-m"], ["unshare", "-r", "-n", "-m"]):
            if subprocess.run([*command, "true"], capture_output=True, check=False).returncode == 0:
                os.environ[INSIDE] = "1"
                os.execvp(command[0], [*command, sys.executable, "-B", *sys.argv])
    if required:
        sys.exit("This benchmark needs two network namespaces. Making them needs root, unshare and ip.")
    print("The peers share this machine's network and /dev/shm: it does not allow separate namespaces.",
          file=sys.stderr)


def free_ports(count):
    """The first of `count` ports in a row that were free just now."""
    for base in range(20_000, 30_000, count):
        sockets = [socket.socket() for _ in range(count)]
        try:
            for offset, one in enumerate(sockets):
                one.bind(("127.0.0.1", base + offset))
            return base
        except OSError:
            continue
        finally:
            for one in sockets:
                one.close()
    raise RuntimeError(f"There are no {count} consecutive free ports.")


def end(*processes, patience_s=2.0):
    """Ends processes that this program started."""
    limit = time.monotonic() + patience_s
    for process in processes:
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
    for process in processes:
        try:
            process.wait(max(0, limit - time.monotonic()))
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def leave_in_order():
    """Ctrl-C and SIGTERM end this program through its contexts, which end everything that it started. A second signal
    does not interrupt that."""

    def leave(number, _):
        for one in LEAVING:
            signal.signal(one, signal.SIG_IGN)
        sys.exit(128 + number)

    for number in LEAVING:
        signal.signal(number, leave)


LEAVING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Daemons:
    """Starts each daemon when a mode first needs it. The context ends them all."""

    def __init__(self, address="127.0.0.1"):
        self.address = address
        self.folder = tempfile.TemporaryDirectory(prefix="hgros_peers_")
        self.running = {}
        self.refused = {}
        self.environment = {"ROS_IP": address, "ROS_LOG_DIR": self.folder.name, "ROS_HOME": self.folder.name}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        end(*self.running.values(), patience_s=5)
        self.folder.cleanup()

    def need(self, name):
        """Empty if the daemon runs, otherwise one sentence with the reason."""
        if not name or name in self.running:
            return ""
        if name not in self.refused:
            self.refused[name] = self.start(name) if shutil.which(name) else f"{name} is not installed."
        return self.refused[name]

    def start(self, name):
        log = pathlib.Path(self.folder.name, f"{name}.log")
        if name == "rosmaster":
            port = free_ports(1)
            self.environment["ROS_MASTER_URI"] = f"http://{self.address}:{port}"
            command = [name, "--core", "-p", str(port)]
        else:
            command = [name, "-c", str(HERE / "roudi.toml"), "-m", "off", "-l", "warning"]
        with log.open("wb") as output:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=output,
                                       env={**os.environ, **self.environment})
        self.running[name] = process  # It ends with the others even if its start fails below.
        ready = ((lambda: answers(self.address, port)) if name == "rosmaster" else
                 (lambda: b"RouDi is ready" in log.read_bytes()))
        limit = time.monotonic() + 15
        while process.poll() is None and time.monotonic() < limit and not ready():
            time.sleep(0.05)
        if process.poll() is not None or not ready():
            end(self.running.pop(name))
            words = log.read_text(errors="replace").strip().splitlines()
            return f"{name} did not start: {words[-1] if words else 'no error message'}"
        return ""


def answers(address, port):
    with socket.socket() as probe:
        return probe.connect_ex((address, port)) == 0
