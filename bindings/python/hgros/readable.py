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


def encodable(text: str) -> str:
    """The text with halves of surrogate pairs escaped: C++ takes only what can be written as UTF-8."""
    return text.encode("utf-8", "backslashreplace").decode() if isinstance(text, str) else text


def told(fault: BaseException) -> str:
    """The type of an exception and what it says, for C++. Raises none itself."""
    name = type(fault).__name__
    try:
        text = f"{name}: {fault}".removesuffix(": ")
    except BaseException as other:
        text = f"{name} (its __str__ has raised {type(other).__name__})"
    return encodable(text)
