#!/usr/bin/env python3
"""Runs the minimal publisher and subscriber until Ctrl-C: over a socket, and with discovery.

    minimal_test.py PUBLISHER SUBSCRIBER
"""

import os
import pathlib
import pty
import signal
import subprocess
import sys
import tempfile

END_S = 20


def say_hello_until_ctrl_c(publisher, subscriber, domain):
    """`publisher` and `subscriber`: the program and its arguments."""
    terminal, end = pty.openpty()  # A terminal, so that lines are not buffered.
    environment = {**os.environ, "HGROS_DOMAIN": domain}
    programs = [subprocess.Popen(subscriber, stdout=end, env=environment),
                subprocess.Popen(publisher, env=environment)]
    try:
        os.close(end)
        line = os.read(terminal, 100)
        assert line.startswith(b"Hello number "), line
        for program in programs:
            program.send_signal(signal.SIGINT)
        codes = [program.wait(END_S) for program in programs]
        assert codes == [0, 0], f"the subscriber and the publisher ended with {codes}"
    finally:
        for program in programs:
            program.kill()
            program.wait()
        os.close(terminal)


def main():
    publisher, subscriber = sys.argv[1:]
    say_hello_until_ctrl_c([publisher], [subscriber], f"minimal-test-{os.getpid()}")
    with tempfile.TemporaryDirectory(prefix="minimal_") as folder:
        ours = pathlib.Path(folder, "publisher.yaml")
        theirs = pathlib.Path(folder, "subscriber.yaml")
        ours.write_text(f'network: {{publisher: {{ip: "ipc://{folder}/bus", channels: [greetings]}}}}\n')
        theirs.write_text(f'network: {{subscribers: [{{ip: "ipc://{folder}/bus", channels: [greetings]}}]}}\n')
        say_hello_until_ctrl_c([publisher, ours], [subscriber, theirs], "none")


if __name__ == "__main__":
    main()
