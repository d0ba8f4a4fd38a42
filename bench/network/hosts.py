"""Two hosts with a line between them: unnamed network namespaces, which disappear with their processes."""

import shutil
import subprocess

import daemons

HERE, THERE = "10.111.0.1", "10.111.0.2"


class NoHosts(Exception):
    """A sentence that explains why this system cannot simulate two hosts."""


def run(*words):
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise NoHosts(f'"{" ".join(words)}" failed: {done.stderr.strip() or "no error message"}')


class Hosts:
    """This process is one host, to be made with daemons.isolate(). This context makes the other host.

    Invariant: one process holds the other host's namespace. It ends with this process, however that ends.
    """

    def __init__(self):
        self.holder = None
        self.rate = ""

    def __enter__(self):
        for name in ("unshare", "nsenter", "ip", "tc"):
            if not shutil.which(name):
                raise NoHosts(f"{name} is not installed.")
        # cat echoes a line once it is inside, and exits when its input is closed.
        self.holder = subprocess.Popen(["unshare", "-n", "cat"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        try:
            self.connect()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        self.holder.stdin.close()
        daemons.end(self.holder)
        self.holder.stdout.close()

    @property
    def prefix(self):
        """Words before a command that runs on the other host."""
        return ("nsenter", f"--net=/proc/{self.holder.pid}/ns/net")

    def connect(self):
        try:
            self.holder.stdin.write(b"\n")
            self.holder.stdin.flush()
        except BrokenPipeError:
            pass
        if self.holder.stdout.read(1) != b"\n":
            raise NoHosts("this system does not allow network namespaces.")
        run("ip", "link", "add", "hgba", "type", "veth", "peer", "name", "hgbb", "netns", str(self.holder.pid))
        for prefix, device, address in (((), "hgba", HERE), (self.prefix, "hgbb", THERE)):
            run(*prefix, "ip", "address", "add", f"{address}/24", "dev", device)
            run(*prefix, "ip", "link", "set", "lo", "up")
            run(*prefix, "ip", "link", "set", device, "up")
            run(*prefix, "ip", "route", "replace", "224.0.0.0/4", "dev", device)

    def set_rate(self, rate):
        """Sets the rate of the line in both directions, as tc writes it, such as "1gbit"."""
        if rate == self.rate:
            return
        for prefix, device in (((), "hgba"), (self.prefix, "hgbb")):
            run(*prefix, "tc", "qdisc", "replace", "dev", device, "root", "tbf", "rate", rate, "burst", "64kb",
                "latency", "50ms")
        self.rate = rate
