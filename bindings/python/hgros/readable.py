"""Text of others, so that it can be shown."""

from __future__ import annotations

import re

# As hgros::IsReadable; and halves of surrogate pairs, which cannot be printed.
_HIDDEN = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
_NAMED = {"\n": "\\n", "\r": "\\r", "\t": "\\t"}


def _escaped(found: re.Match[str]) -> str:
    character = found[0]
    code = ord(character)
    return _NAMED.get(character) or (f"\\x{code:02x}" if code < 0x80 else f"\\u{code:04x}")


def readable(text: str) -> str:
    """The text with control characters, and those that change the direction of text, escaped as in C++."""
    return _HIDDEN.sub(_escaped, text)
