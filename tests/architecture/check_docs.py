#!/usr/bin/env python3
"""Fails if a Markdown page breaks a rule that a pattern can check: long lines, dead links, words that we never use,
sources that the page of platforms does not name.

    check_docs.py [ROOT]

Faults go to standard error, one per line: "path:line: the fault; the fix". Code spans (`...`) may use any word,
and code blocks contain no links.
"""

import pathlib
import re
import sys

COLUMNS = 130
# Pages in build folders and similar folders are not ours.
SKIPPED = re.compile(r"(\..*|build(-.*)?|out|node_modules)")

PLATFORMS = "docs/platforms.md"
LINUX = re.compile(r"#include <(linux/\w+|sys/(?:epoll|eventfd|inotify|prctl|random|signalfd|syscall|timerfd)|sched)\.h>")

# (pattern, what to write instead)
WORDS = [
    (r"carriers?", "write transport"),
    (r"anew", "write again"),
    (r"but for", "write except for"),
    (r"whoever|whomever|whosoever", "name the subject: a session, a caller, everybody"),
    (r"so[- ]manieth", "write every n-th"),
    (r"so many", "write a number, many, or as many as"),
    (r"of which", "make it two sentences"),
    (r"therewith|thereby|hitherto|henceforth|wherewith|albeit", "use a modern word, or two sentences"),
    (r"colour(?:s|ed|ing)?", "write color"),
    (r"behaviours?|neighbours?|neighbouring", "write -or: behavior, neighbor"),
    (r"metres?|centres?|licences?", "use American spelling: meter, center, license"),
    (r"(?:recogni|speciali|seriali|initiali|optimi)s(?:e|es|ed|ing|ation)", "write -ize"),
]
WORD = re.compile("|".join(rf"(?P<w{number}>\b(?:{pattern})\b)" for number, (pattern, _) in enumerate(WORDS)), re.IGNORECASE)
# A statement that begins like a question, or with "Of". Questions and headings are allowed.
OPENING = re.compile(r"(?:^|(?<=[.!?:] ))[*_]*(?P<words>Who|Whom|What is|Of)\b(?=[^.!?]*(?:[.!]|$))")

FENCE = re.compile(r"^\s*(```|~~~)")
SPAN = re.compile(r"(`+)(?!`).*?(?<!`)\1(?!`)")
LINK = re.compile(r"!?\[[^\]]*\]\(\s*<?([^)\s>]*)>?[^)]*\)")
ONE_LINK = re.compile(r"^\s*(?:[-*+]\s+|\d+\.\s+|>\s*)?(?:!?\[[^\]]*\](?:\([^)]*\)|:\s*\S+)|<?https?://\S+>?)[.,;:]?$")
SCHEME = re.compile(r"^[a-z][a-z0-9+.-]*:", re.IGNORECASE)
HEADING = re.compile(r"^#{1,6}\s+(.*?)\s*#*$")


def pages_of(root):
    """All Markdown pages below a folder, sorted, without those in build folders."""
    for path in sorted(root.iterdir()):
        if path.is_symlink():
            continue
        if path.is_dir():
            if not SKIPPED.fullmatch(path.name):
                yield from pages_of(path)
        elif path.suffix == ".md":
            yield path


def code_lines(lines):
    """For each line, whether it belongs to a code block: between fences, or indented by four after an empty line."""
    fenced = False
    indented = False
    empty_before = True
    for line in lines:
        if FENCE.match(line):
            fenced = not fenced
            yield True
        elif fenced:
            yield True
        else:
            if line.strip():
                indented = line.startswith(("    ", "\t")) and (indented or empty_before)
            yield indented and bool(line.strip())
        empty_before = not line.strip()


def anchors_of(page):
    """All texts after the # that a link to a heading of the page may have."""
    lines = page.read_text(encoding="utf-8", errors="replace").split("\n")
    anchors = set()
    for line, is_code in zip(lines, code_lines(lines)):
        heading = None if is_code else HEADING.match(line)
        if heading:
            text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading[1]).lower()
            anchors.add(re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", text)))
    return anchors


def link_fault(page, target):
    """The fault of a link, or None."""
    if not target or SCHEME.match(target):
        return None
    path, _, anchor = target.partition("#")
    goal = (page.parent / path) if path else page
    if not goal.exists():
        return f'links to "{target}", which does not exist; correct the path, relative to this page'
    if anchor and goal.suffix == ".md" and anchor not in anchors_of(goal):
        return f'links to "{target}", but {goal.name} has no such heading; correct the part after the #'
    return None


def check_page(page):
    """Yields (line, fault)."""
    lines = page.read_text(encoding="utf-8", errors="replace").split("\n")
    for number, (line, is_code) in enumerate(zip(lines, code_lines(lines)), start=1):
        if len(line) > COLUMNS and not ONE_LINK.match(line):
            mend = "shorten a cell, or move the details below the table" if line.startswith("|") else "break it"
            yield number, f"has {len(line)} columns, {COLUMNS} at most; {mend}"
        text = line if is_code else SPAN.sub(lambda span: " " * len(span[0]), line)
        for word in WORD.finditer(text):
            yield number, f'contains "{word[0]}"; {WORDS[int(word.lastgroup[1:])][1]}'
        if is_code:
            continue
        if not line.startswith("#"):
            for opening in OPENING.finditer(re.sub(r"^\s*(?:[-*+]|\d+\.)\s+", "", text)):
                yield number, f'begins a sentence with "{opening["words"]}"; put subject and verb first'
        for link in LINK.finditer(text):
            fault = link_fault(page, link[1])
            if fault:
                yield number, fault


def check_platforms(root):
    """Faults of the page that names all sources with headers of Linux. None if a tree has no such page."""
    page = root / PLATFORMS
    if not page.exists():
        return []
    text = page.read_text(encoding="utf-8")
    sources = [path for folder in ("src", "apps", "bindings", "include") for suffix in ("c", "cpp", "h", "hpp")
               for path in sorted((root / folder).rglob(f"*.{suffix}"))]
    faults = []
    for source in sources:
        path = source.relative_to(root).as_posix()
        header = LINUX.search(source.read_text(encoding="utf-8", errors="replace"))
        if header and f"`{path}`" not in text:
            faults.append(f"{PLATFORMS}:1: does not name {path}, which includes <{header[1]}.h>; add it to a table")
    faults += [f"{PLATFORMS}:1: names {path}, which does not exist; remove it"
               for path in re.findall(r"`((?:src|apps|bindings)/[\w/.]+\.\w+)`", text) if not (root / path).exists()]
    return faults


def check_tree(root):
    """All faults of a tree as "path:line: fault", and the number of pages read."""
    root = pathlib.Path(root).resolve()
    faults = check_platforms(root)
    pages = 0
    for page in pages_of(root):
        pages += 1
        path = page.relative_to(root).as_posix()
        faults += [f"{path}:{line}: {fault}" for line, fault in check_page(page)]
    return faults, pages


def main():
    faults, pages = check_tree(sys.argv[1] if len(sys.argv) > 1 else ".")
    for fault in faults:
        print(fault, file=sys.stderr)
    if pages == 0:
        print("No page was found: is this the root of the tree?", file=sys.stderr)
        return 2
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
