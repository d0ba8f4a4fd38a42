"""How long no message is handled while a component with 1 MB of state moves: to another process, and to another host over
ssh, on a line of 1 Gbit/s; and while it is constructed again in its place. Beside them: how long none comes without.

    moves.py HGROS COMPONENTS [--quick]
"""

import getpass
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile

import daemons
from hosts import HERE, THERE, Hosts, NoHosts

COMPONENTS = """
components: {beats: {type: bench/Beats}, carrier: {type: bench/Carrier}, gaps: {type: bench/Gaps}}
"""
LOCAL = COMPONENTS + "processes: {ends: {components: [beats, gaps]}, one: {components: [carrier]}, two: {}}\n"
FAR = COMPONENTS + f"""
hosts: {{desk: {{address: {HERE}, home: true}}, base: {{address: {THERE}}}}}
discovery: {{local: false}}
processes: {{one: {{components: [beats, gaps, carrier]}}, two: {{host: base}}}}
"""


class Robot:
    """A robot that runs, and its log."""

    def __init__(self, hgros, folder, text, environment):
        self.hgros = hgros
        self.environment = environment
        file = folder / "robot.yaml"
        file.write_text(text)
        self.run = subprocess.Popen([hgros, "run", str(file), "--json"], stdout=subprocess.PIPE, env=environment)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.run.terminate()
        self.run.wait()

    def gap(self):
        """The next one that is told, in ms."""
        for line in self.run.stdout:
            text = json.loads(line).get("text", "")
            if "lost or doubled" in text:
                raise SystemExit("A message was lost or doubled.")
            if text.startswith("gap "):
                return float(text.split()[1])
        raise SystemExit("hgros run has ended.")

    def gap_around(self, *command):
        """Returns the longest gap around a command of hgros, in ms."""
        self.gap()
        subprocess.run([self.hgros, *command], check=True, env=self.environment)
        return max(self.gap() for _ in range(3))

    def move(self, place):
        return self.gap_around("move", "carrier", "--to", place)


def report(name, gaps):
    print(f"{name}_ms,{statistics.median(gaps):.6g},ms")
    print(f"{name}_worst_ms,{max(gaps):.6g},ms", flush=True)


def measure(name, robot, places, count):
    robot.move(places[0])
    report(name, [robot.move(places[(1 + i) % 2]) for i in range(count)])
    quiet = statistics.median(max(robot.gap() for _ in range(3)) for _ in range(3))
    print(f"{name}_no_move_ms,{quiet:.6g},ms", flush=True)


def start_sshd(folder, hosts, environment):
    """A server on the other host, with keys of its own. Returns it."""
    for key in ("host", "user"):
        subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", folder / key], check=True)
    pathlib.Path("/run/sshd").mkdir(parents=True, exist_ok=True)
    kept = "".join(f' "{name}={environment[name]}"' for name in ("HGROS_COMPONENT_PATH", "HGROS_DOMAIN"))
    (folder / "sshd_config").write_text(
        f"ListenAddress {THERE}\nHostKey {folder}/host\nAuthorizedKeysFile {folder}/user.pub\nPidFile none\nUsePAM no\n"
        f"StrictModes no\nPermitRootLogin yes\nSetEnv{kept} \"PATH={pathlib.Path(sys.argv[1]).parent}:/usr/bin:/bin\"\n")
    (folder / "known").write_text(f"{THERE} {(folder / 'host.pub').read_text()}")
    (folder / "ssh").write_text(
        f"#!/bin/sh\nexec /usr/bin/ssh -o IdentityFile={folder}/user -o IdentitiesOnly=yes -o UserKnownHostsFile="
        f"{folder}/known -l {getpass.getuser()} \"$@\"\n")
    (folder / "ssh").chmod(0o700)
    daemon = subprocess.Popen([*hosts.prefix, "/usr/sbin/sshd", "-D", "-e", "-f", folder / "sshd_config"],
                              stderr=subprocess.PIPE, text=True)
    for line in daemon.stderr:
        if "Server listening" in line:
            return daemon
    raise NoHosts("sshd does not start.")


def measure_hosts(folder, environment, count):
    if not os.path.exists("/usr/sbin/sshd") or not shutil.which("ssh-keygen"):
        raise NoHosts("openssh-server is not installed.")
    with Hosts() as hosts:
        hosts.set_rate("1gbit")
        daemon = start_sshd(folder, hosts, environment)
        try:
            far = {**environment, "PATH": f"{folder}:{environment['PATH']}"}
            with Robot(sys.argv[1], folder, FAR, far) as robot:
                measure("move_hosts", robot, ("two", "one"), count)
        finally:
            daemons.end(daemon)


def main():
    count = 10 if "--quick" in sys.argv else 40
    daemons.isolate()
    environment = {**os.environ, "HGROS_COMPONENT_PATH": sys.argv[2], "HGROS_DOMAIN": f"bench-moves-{os.getpid()}"}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        with Robot(sys.argv[1], folder, LOCAL, environment) as robot:
            measure("move_local", robot, ("two", "one"), count)
            report("restart_component", [robot.gap_around("restart", "carrier") for _ in range(count)])
        try:
            measure_hosts(folder, environment, count)
        except NoHosts as why:
            print(f"move_hosts_ms is not measured: {why}", file=sys.stderr)


if __name__ == "__main__":
    main()
