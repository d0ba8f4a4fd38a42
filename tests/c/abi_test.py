#!/usr/bin/env python3
"""Compares the C interface with the list of the last release.

    abi_test.py COMPILER INCLUDE LIBRARY LIST [--update]

The list has each exported symbol with its version, each constant with its value, the size of each struct with the
offsets of its fields, as the compiler lays them out here, and the types of each function and callback. Lines may be
added; a line that is missing or different breaks programs that were compiled before. --update writes the list: use it when
something was added.
"""

import pathlib
import re
import subprocess
import sys
import tempfile


def symbols(library):
    """'symbol NAME@@VERSION' for each exported one."""
    shown = subprocess.run(["nm", "--dynamic", "--defined-only", library], check=True, capture_output=True, text=True)
    names = [line.split()[2] for line in shown.stdout.splitlines()]
    return [f"symbol {name}" for name in names if not re.fullmatch(r"HGROS_\d+", name)]


def declarations(include):
    """The headers without comments."""
    headers = sorted((include / "hgros" / "c").glob("*.h"))
    return re.sub(r"//.*", "", "\n".join(header.read_text(encoding="utf-8") for header in headers))


def types(parameters):
    """The types of a list of parameters, without their names."""
    each = [" ".join(one.split()) for one in parameters.split(",")]
    return ", ".join(one if " " not in one else re.sub(r"\s*\b\w+$", "", one) for one in each)


def prototypes(text):
    """'function RESULT NAME(TYPES)' for each function, 'callback RESULT NAME(TYPES)' for each typedef of one."""
    functions = re.findall(r"^((?:const )?\w+\*?)\s+(hgros_\w+)\(([^()]*)\);", text, re.MULTILINE)
    callbacks = re.findall(r"^typedef (\w+) \(\*(hgros_\w+)\)\(([^()]*)\);", text, re.MULTILINE)
    return [f"{kind} {result} {name}({types(parameters)})"
            for kind, found in (("function", functions), ("callback", callbacks)) for result, name, parameters in found]


def layout(compiler, include, text):
    """Constants and structs of the headers, by a program that prints them."""
    lines = []
    for body in re.findall(r"\benum\s*\{(.*?)\}", text, re.DOTALL):
        lines += [f'printf("constant {name} %d\\n", (int){name});' for name in re.findall(r"(HGROS_\w+)\s*=", body)]
    for body, name in re.findall(r"typedef struct \w+ \{(.*?)\} (\w+);", text, re.DOTALL):
        lines.append(f'printf("struct {name} %zu\\n", sizeof({name}));')
        for field in re.findall(r"(\w+)(?:\[\d+\])?;", body):
            lines.append(f'printf("field {name}.{field} %zu %zu\\n", offsetof({name}, {field}), '
                         f'sizeof((({name}*)0)->{field}));')
    with tempfile.TemporaryDirectory() as folder:
        source = pathlib.Path(folder, "layout.c")
        source.write_text("#include <hgros/hgros.h>\n#include <stdio.h>\nint main(void) {\n" + "\n".join(lines) +
                          "\nreturn 0;\n}\n", encoding="utf-8")
        program = pathlib.Path(folder, "layout")
        subprocess.run([compiler, "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{include}", source, "-o",
                        program], check=True)
        printed = subprocess.run([program], check=True, capture_output=True, text=True).stdout.splitlines()
    return printed


def main():
    compiler, include, library, known = sys.argv[1:5]
    known = pathlib.Path(known)
    exported = symbols(library)
    text = declarations(pathlib.Path(include))
    printed = layout(compiler, pathlib.Path(include), text)
    typed = prototypes(text)
    declared = set(re.findall(r"\b(hgros_\w+)\(", text))
    faults = [f"the types of {name} cannot be read: declare it in one form with the others"
              for name in sorted(declared - {re.search(r"(\w+)\(", one)[1] for one in typed})]
    names = {one.split()[1].split("@")[0] for one in exported}
    faults += [f"{name} is declared, but not exported" for name in sorted(declared - names)]
    faults += [f"{name} is exported, but not declared in the headers" for name in sorted(names - declared)]
    faults += [f"{one} has no version: it must be in a node of src/c/exports.map" for one in exported if "@@" not in one]
    ends = {}
    for line in printed:
        if line.startswith("field "):
            name, offset, size = line.split()[1:]
            struct = name.split(".")[0]
            ends[struct] = max(ends.get(struct, 0), int(offset) + int(size))
    faults += [f"{line} ends in padding, which a later field would share: put a smaller field before the others"
               for line in printed if line.startswith("struct ") and ends[line.split()[1]] != int(line.split()[2])]
    now = sorted(exported) + sorted(printed) + sorted(typed)
    if "--update" in sys.argv and not faults:
        known.write_text("".join(f"{line}\n" for line in now), encoding="utf-8")
        return 0
    then = known.read_text(encoding="utf-8").splitlines()
    faults += [f"breaks programs of the last release: \"{line}\" is gone or different" for line in then if line not in now]
    faults += [f"is new, and not in the list: \"{line}\"" for line in now if line not in then]
    for fault in faults:
        print(fault, file=sys.stderr)
    if faults:
        print(f"If nothing breaks, run: python3 {' '.join(sys.argv[:5])} --update", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
