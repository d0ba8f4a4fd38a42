#!/usr/bin/env python3
"""Fails if a source breaks a house rule that a pattern can check.

    check_house.py [ROOT]

Faults go to standard error, one per line. Comments and string literals are blanked before the code rules are checked.
"""

import collections
import pathlib
import re
import sys

CODE = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(?P<tag>[^(\s]*)\(.*?\)(?P=tag)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'', re.DOTALL)

PUBLIC = ("include",)
LIBRARY = ("include", "src")
PRODUCT = ("include", "src", "apps", "bindings")
ALL = ("include", "src", "apps", "bindings", "tests", "examples", "bench")

# (folders, only headers?, pattern in the code, the fault and its fix)
CODE_RULES = [
    (("include", "src", "apps", "bindings", "tests"), False, r"\b(sleep_for|sleep_until|usleep|nanosleep)\b",
     "sleeps; wait on something that wakes"),
    (ALL, False, r"\bshared_ptr<\s*void\s*>", "shares a message without its type; keep the type, or const void beside it"),
    (ALL, False, r"\b(?:class|struct|enum|namespace|using)\s+(?:class\s+)?(?:HGROS_EXPORT\s+)?"
                 r"\w*(?:Manager|Helper|Util|manager|helper|util)\w*\b(?!::)",
     "is named manager, helper or util; name the thing"),
    (PUBLIC, True, r"^[ \t]*#[ \t]*define[ \t]+(?!HGROS_(?:EXPORT\b|COMPONENT))",
     "defines a macro; only HGROS_EXPORT and HGROS_COMPONENT are"),
    (LIBRARY, False, r"\bstd::cout\b|(?<![\w:.>])(?:std::)?(?:printf|puts|putchar)\s*\(|\bstdout\b",
     "writes to standard output, which belongs to the program; use the log"),
    (PRODUCT, True, r"^(?:inline\s+)?static\s", "has a static function or variable in a header; use inline"),
    (PRODUCT, True, r"^using namespace\b", "opens a namespace in every source that includes it"),
]
TEXT_RULE = re.compile(r"\b(TODO|FIXME|XXX)\b")
NAME_RULE = re.compile(r"(^|_)(manager|helpers?|utils?|common|misc)(_|$)", re.IGNORECASE)
HEADERS = {".hpp", ".h"}
SUFFIXES = HEADERS | {".cpp"}

MAX_FILE_LINES = 400  # in include, src, apps and bindings
MAX_PUBLIC_HEADER_LINES = 150
MAX_SOURCES_PER_FOLDER = 30  # .cpp and .hpp, subfolders not counted
MAX_CLASS_LINES = 500  # the class and its functions, in all files of include, src, apps and bindings

# Both begin in the first column and end with a brace there.
CLASS = re.compile(r"(?:template <.*> )?(?:class|struct)\s+(?:HGROS_EXPORT\s+|alignas\([^)]*\)\s+)*(\w+)(?: final)?\s*"
                   r"(?::[^;]*)?(?:\{|,?$)")
FUNCTION = re.compile(r"(?:\w[^;=]*?\b)?([A-Z]\w*)(?:<[^>]*>)?::(?:~?\w+::)*(?:~?\w+|operator\S+)\(")


def without_comments_and_strings(text):
    """The same text with comments and literals blanked; the lines keep their numbers."""
    return CODE.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)


def check_file(root, path):
    """Yields (line, fault)."""
    text = (root / path).read_text(encoding="utf-8", errors="replace")
    for match in TEXT_RULE.finditer(text):
        yield text.count("\n", 0, match.start()) + 1, f"leaves a {match.group()}; do it or open an issue"
    if NAME_RULE.search(path.stem):
        yield 1, "has a file name without meaning; name the thing"
    lines = len(text.splitlines())
    if path.parts[0] in PUBLIC and path.suffix in HEADERS and lines > MAX_PUBLIC_HEADER_LINES:
        yield lines, f"is a public header of more than {MAX_PUBLIC_HEADER_LINES} lines; split it by subject"
    elif path.parts[0] in PRODUCT and lines > MAX_FILE_LINES:
        yield lines, f"has more than {MAX_FILE_LINES} lines; split it by subject"
    code = without_comments_and_strings(text)
    for folders, only_headers, pattern, fault in CODE_RULES:
        if path.parts[0] not in folders or (only_headers and path.suffix not in HEADERS):
            continue
        for match in re.finditer(pattern, code, re.MULTILINE):
            yield code.count("\n", 0, match.start()) + 1, fault
    if path.suffix in HEADERS and "#pragma once" not in code:
        yield 1, "has no #pragma once"


def class_sizes(path, code):
    """Yields (module, class, lines) for each class, and for each function outside its class."""
    folders = [part for part in path.parts[:-1] if part not in ("include", "src", "hgros", "internal")]
    module = "/".join(folders[:2] if path.parts[0] == "apps" else folders[:1])
    name, first = None, 0
    lines = code.split("\n")
    for number, line in enumerate(lines):
        if name is None:
            match = CLASS.match(line) or FUNCTION.match(line)
            if match:
                name, first = match.group(1), number
        # What fits one line ends on the line where it begins.
        if name is not None and (line.startswith("}") or (number == first and line.rstrip().endswith(("}", ";")))):
            yield module, name, number - first + 1
            name = None


def check_tree(root):
    """All faults of a tree as "path:line: fault", and the number of files read."""
    root = pathlib.Path(root).resolve()
    faults = []
    files = 0
    folders = collections.Counter()
    classes = collections.Counter()
    for top in ALL:
        for file in sorted((root / top).rglob("*")):
            if file.suffix in SUFFIXES and file.is_file():
                files += 1
                path = pathlib.PurePosixPath(file.relative_to(root).as_posix())
                folders[path.parent] += 1
                faults += [f"{path}:{line}: {fault}" for line, fault in sorted(check_file(root, path))]
                if top in PRODUCT:
                    code = without_comments_and_strings(file.read_text(encoding="utf-8", errors="replace"))
                    for module, name, lines in class_sizes(path, code):
                        classes[module, name] += lines
    for folder, count in sorted(folders.items()):
        if count > MAX_SOURCES_PER_FOLDER:
            faults.append(f"{folder}:1: has {count} source files, more than {MAX_SOURCES_PER_FOLDER}; "
                          "split it into subfolders of one subject each")
    for (module, name), lines in sorted(classes.items()):
        if lines > MAX_CLASS_LINES:
            faults.append(f"{module}: class {name} has {lines} lines in all its files, more than {MAX_CLASS_LINES}; "
                          "split it by the state that its parts guard")
    return faults, files


def main():
    faults, files = check_tree(sys.argv[1] if len(sys.argv) > 1 else ".")
    for fault in faults:
        print(fault, file=sys.stderr)
    if files == 0:
        print("No source was found: is this the root of the tree?", file=sys.stderr)
        return 2
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
