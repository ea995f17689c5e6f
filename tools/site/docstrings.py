"""Docstrings of supple as mkdocstrings reads them (griffe extension).

In supple an entry of a section is one line, `name : shape and meaning`, continued by more indented lines;
numpydoc has the meaning below the name. Types come from the annotations.
"""

from __future__ import annotations

import re
from typing import Any

import griffe

_SECTION = re.compile(r"^(Parameters|Returns|Raises|Yields|Attributes)\n-+\n", re.MULTILINE)
_NAMED = re.compile(r"^([\w*]+(?:, [\w*]+)*) : (.+)$")
_UNNAMED = re.compile(r"^([\w.\[\], |]+?)(?:\s{2,}(.+))?$")


class OneLineEntries(griffe.Extension):
    """Entries of one line become a name and an indented meaning."""

    def on_instance(self, *, obj: griffe.Object, **_: Any) -> None:
        """Rewrite the docstring of an object."""
        if obj.docstring is not None:
            obj.docstring.value = numpydoc(obj.docstring.value)


def numpydoc(text: str) -> str:
    """A docstring with the entries of its sections on lines of their own."""
    pieces = _SECTION.split(text)
    written = [pieces[0]]
    for name, content in zip(pieces[1::2], pieces[2::2], strict=True):
        body, _, rest = content.partition("\n\n")
        entry = _NAMED if name in {"Parameters", "Attributes"} else _UNNAMED
        written.append(f"{name}\n{'-' * len(name)}\n{_entries(body.rstrip(), entry)}\n\n{rest}")
    return "".join(written)


def _entries(body: str, entry: re.Pattern[str]) -> str:
    lines = []
    for line in body.splitlines():
        found = None if line.startswith(" ") else entry.match(line)
        if found is None:
            lines.append(f"    {line.strip()}" if line.startswith(" ") else line)
            continue
        lines += [found[1], *([f"    {found[2]}"] if found[2] else [])]
    return "\n".join(lines)
