#!/usr/bin/env python3
"""Writes the ```cpp, ```c, ```go or ```java block that follows `<!-- test: NAME -->` in a Markdown file to a source file.

    extract.py DOCUMENT NAME OUTPUT
"""

import pathlib
import re
import sys


def block(text, name):
    """The block of that name and the line where its code begins. None if there is no such block."""
    found = re.search(rf"^<!-- test: {re.escape(name)} -->\s*^```(?:cpp|c|go|java)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return (found.group(1), text.count("\n", 0, found.start(1)) + 1) if found else None


def main():
    document, name, output = sys.argv[1:]
    found = block(pathlib.Path(document).read_text(encoding="utf-8"), name)
    if found is None:
        print(f"{document} has no ```cpp, ```c, ```go or ```java block right after <!-- test: {name} -->.", file=sys.stderr)
        return 1
    code, line = found
    # Compilers then report lines of the document; that of Java has no such directive.
    places = {".go": f"//line {document}:{line}\n", ".java": ""}
    place = places.get(pathlib.Path(output).suffix, f'#line {line} "{document}"\n')
    pathlib.Path(output).write_text(place + code, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
