#!/usr/bin/env python3
"""Writes the ```cpp, ```c, ```csharp or ```go block that follows `<!-- test: NAME -->` in a Markdown file to a source file.

    extract.py DOCUMENT NAME OUTPUT
"""

import pathlib
import re
import sys


def block(text, name):
    """The block of that name and the line where its code begins. None if there is no such block."""
    found = re.search(rf"^<!-- test: {re.escape(name)} -->\s*^```(?:cpp|c|csharp|go)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return (found.group(1), text.count("\n", 0, found.start(1)) + 1) if found else None


def main():
    document, name, output = sys.argv[1:]
    found = block(pathlib.Path(document).read_text(encoding="utf-8"), name)
    if found is None:
        print(f"{document} has no ```cpp, ```c, ```csharp or ```go block right after <!-- test: {name} -->.", file=sys.stderr)
        return 1
    code, line = found
    # Compilers then report lines of the document.
    place = f"//line {document}:{line}" if output.endswith(".go") else f'#line {line} "{document}"'
    pathlib.Path(output).write_text(f'{place}\n{code}', encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
