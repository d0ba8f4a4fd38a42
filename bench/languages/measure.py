"""measure.py FOLDER [--quick]: prints metric,value,unit. See `run`."""

import os
import statistics
import subprocess
import sys

LANGUAGES = ["cpp", "go", "java", "node"]


def received_per_second(language, command, talker, flood):
    """One publisher and one receiver, each a process. A receiver fails if a message is lost."""
    os.environ["HGROS_DOMAIN"] = f"bench_languages_{language}"
    receiver = subprocess.Popen([*command, str(flood)], stdout=subprocess.PIPE, text=True)
    publisher = subprocess.Popen([*talker, str(flood)])
    try:
        out, _ = receiver.communicate(timeout=120)
        if receiver.returncode or publisher.wait(20):
            sys.exit(f"The run with {language} failed.")
        return float(out)
    finally:
        for process in (receiver, publisher):
            process.kill()
            process.wait()


def main():
    folder, quick = os.path.abspath(sys.argv[1]), "--quick" in sys.argv
    with open(os.path.join(folder, "commands"), encoding="utf-8") as file:
        commands = {words[0]: words[1:] for words in (line.split() for line in file)}
    for language in LANGUAGES:
        if language not in commands:
            print(f"bench: {language} is left out: its binding is not built here (./dev setup languages).", file=sys.stderr)
    talker = [commands["cpp"][0], "talk"]
    rounds, flood = (1, 50_000) if quick else (5, 500_000)
    rates = {language: [] for language in LANGUAGES if language in commands}
    for _ in range(rounds):
        for language, found in rates.items():
            found.append(received_per_second(language, commands[language], talker, flood))
    for language, found in rates.items():
        print(f"{language}_msgs_s_1KB,{statistics.median(found):.4g},1/s", flush=True)


if __name__ == "__main__":
    main()
