#!/usr/bin/env python3
"""Writes the code block behind `<!-- test: NAME -->` in a Markdown file to a source file.

    extract.py DOCUMENT NAME OUTPUT
"""

import pathlib
import re
import sys


def block(text, name):
    """The block of that name and the line where its code begins. None if there is no such block."""
    found = re.search(rf"^<!-- test: {re.escape(name)} -->\s*^```\w+\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return (found.group(1), text.count("\n", 0, found.start(1)) + 1) if found else None


def main():
    document, name, output = sys.argv[1:]
    found = block(pathlib.Path(document).read_text(encoding="utf-8"), name)
    if found is None:
        print(f"{document} has no code block right after <!-- test: {name} -->.", file=sys.stderr)
        return 1
    code, line = found
    # Compilers then report lines of the document, where the language has a directive for that.
    comment = f"//line {document}:{line}\n"
    places = {".go": comment, ".rs": comment, ".java": "", ".js": "", ".php": ""}
    place = places.get(pathlib.Path(output).suffix, f'#line {line} "{document}"\n')
    pathlib.Path(output).write_text(place + code, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
