#!/usr/bin/env python3
"""Runs the two programs of a page as its reader does: the publisher first, which waits for the subscriber.

    pair.py PUBLISHER ITS_LINE SUBSCRIBER ITS_LINE

The subscriber must print its line five times, and ends when it gets an empty line.
"""

import os
import subprocess
import sys
import threading

PATIENCE = 50  # seconds


def main():
    publisher, published, subscriber, received = sys.argv[1:5]
    environment = dict(os.environ, HGROS_DOMAIN=f"readme-{os.getpid()}")
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "env": environment}
    with subprocess.Popen([publisher], **pipes) as sends, subprocess.Popen([subscriber], **pipes) as receives:
        watch = threading.Timer(PATIENCE, lambda: (sends.kill(), receives.kill()))
        watch.start()
        said, _ = sends.communicate()
        heard = "".join(receives.stdout.readline() for _ in range(1 + 5))  # The first line says how to end it.
        heard += receives.communicate("\n")[0]
        watch.cancel()
    if sends.returncode != 0 or receives.returncode != 0:
        sys.exit(f"the publisher ended with {sends.returncode}, the subscriber with {receives.returncode}")
    if said.splitlines() != [published]:
        sys.exit(f"the publisher printed {said!r}")
    if heard.splitlines()[1:] != [received] * 5:
        sys.exit(f"the subscriber printed {heard!r}")


if __name__ == "__main__":
    main()
