"""Turns what callgrind counted into a list for the linker: order.py CALLGRIND_OUT LIBRARY LINKER_SCRIPT."""
import re
import subprocess
import sys

CALLS_AT_LEAST = 150  # Of the 200 messages that each way sends.

HEAD = """/* The functions of the library that a message passes through, side by side: a thread that wakes up to one message finds
   its caches and its page table entries cold, and pays for every line and page that it touches. Written by
   `./dev bench hot_path`; a name that is no longer there does no harm. */
SECTIONS
{
  .text.hgros_hot :
  {
"""
TAIL = "  }\n}\nINSERT BEFORE .text;\n"


def counts(path):
    """How often each function was called, by its mangled name; one that does nothing but call such ones counts as they."""
    names, calls, caller, called = {}, {}, "", ""
    with open(path, encoding="utf-8") as profile:
        for line in profile:
            if match := re.match(r"c?fn=\((\d+)\)(?: (.*))?$", line):
                number, name = match.groups()
                if name is not None:
                    names[number] = name.split("'")[0]  # Recursion has entries of its own: NAME'2.
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
    """The functions that the library has itself."""
    table = subprocess.run(["nm", "--defined-only", library], check=True, capture_output=True, text=True).stdout
    return {line.split()[2] for line in table.splitlines() if line.split()[1] in "tTwW"}


def main():
    profile, library, script_path = sys.argv[1:]
    calls = counts(profile)
    hot = sorted(name for name in defined(library) if name.startswith("_Z") and calls.get(name, 0) >= CALLS_AT_LEAST)
    with open(script_path, "w", encoding="utf-8") as script:
        script.write(HEAD)
        for name in hot:
            # A constructor or destructor goes by several names, and its section by one of them.
            section = re.sub(r"([CD])[12](E|I)", r"\1?\2", name)
            script.write(f"    *(.text.{section})\n")
        script.write(TAIL)
    print(f"hot_functions,{len(hot)},functions")


main()
