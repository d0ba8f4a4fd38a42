"""Turns the counts of callgrind into a list for the linker: order.py CALLGRIND_OUT LIBRARY LINKER_SCRIPT."""
import re
import subprocess
import sys

CALLS_AT_LEAST = 150  # Each way sends 200 messages.

HEAD = """/* The library's functions that a message passes through, placed side by side. A thread that wakes up for one
   message finds its caches and its page table entries cold, so every line and page that it touches costs time.
   Written by `./dev bench hot_path`. A name that no longer exists does no harm. */
SECTIONS
{
  .text.hgros_hot :
  {
"""
TAIL = "  }\n}\nINSERT BEFORE .text;\n"


def counts(path):
    """How often each function was called, by mangled name; at least as often as it calls a function of the library."""
    names, calls, caller, called = {}, {}, "", ""
    with open(path, encoding="utf-8") as profile:
        for line in profile:
            if match := re.match(r"c?fn=\((\d+)\)(?: (.*))?$", line):
                number, name = match.groups()
                if name is not None:
                    names[number] = name.split("'")[0]  # Recursive calls have separate entries: NAME'2.
                if line.startswith("cfn"):
                    called = names[number]
                else:
                    caller = names[number]
            elif line.startswith("calls="):
                count = int(line[6:].split()[0])
                calls[called] = calls.get(called, 0) + count
                if called.startswith("_ZN5hgros"):  # A thread's loop is called once.
                    calls[caller] = max(calls.get(caller, 0), count)
    return calls


def defined(library):
    """The functions that the library itself defines."""
    table = subprocess.run(["nm", "--defined-only", library], check=True, capture_output=True, text=True).stdout
    return {line.split()[2] for line in table.splitlines() if line.split()[1] in "tTwW"}


def main():
    profile, library, script_path = sys.argv[1:]
    calls = counts(profile)
    hot = sorted(name for name in defined(library) if name.startswith("_Z") and calls.get(name, 0) >= CALLS_AT_LEAST)
    with open(script_path, "w", encoding="utf-8") as script:
        script.write(HEAD)
        for name in hot:
            # A constructor or destructor has several names, and its section is named after one of them.
            section = re.sub(r"([CD])[12](E|I)", r"\1?\2", name)
            script.write(f"    *(.text.{section})\n")
        script.write(TAIL)
    print(f"hot_functions,{len(hot)},functions")


main()
