# pilot.py: w drives forward, s back, a left, d right, q ends. `python3 pilot.py wwa` presses these keys by itself.
import json
import subprocess
import sys
import termios
import time
import tty

VELOCITIES = {"w": (0.4, 0), "s": (-0.4, 0), "a": (0, 1), "d": (0, -1)}


def pressed_keys():
    before = termios.tcgetattr(sys.stdin)
    tty.setcbreak(sys.stdin)  # Keys come at once, without Enter.
    try:
        while (key := sys.stdin.read(1)) not in ("q", ""):
            yield key
    except KeyboardInterrupt:
        pass
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)


def given_keys(keys):
    for key in keys:
        yield key
        time.sleep(0.4)


# This command publishes each line that it reads: a message as JSON.
command = ["hgros", "pub", "wanted", "--type", "foxglove.Vector3", "--file", "-"]
with subprocess.Popen(command, stdin=subprocess.PIPE, text=True) as publisher:
    for key in given_keys(sys.argv[1]) if len(sys.argv) > 1 else pressed_keys():
        if key in VELOCITIES:
            x, z = VELOCITIES[key]
            print(json.dumps({"x": x, "z": z}), file=publisher.stdin, flush=True)
