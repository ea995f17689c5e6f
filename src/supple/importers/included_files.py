"""A file of cards or keywords and the files that it includes."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from supple.importers.inclusion import included_file
from supple.importers.matrices.matrix_file import DMIG_SUFFIXES

__all__ = ["files_read_with"]

# Inclusions in files of Abaqus and CalculiX, BeamDyn, and Nastran; a quoted name of Nastran may span lines.
_INCLUDE = re.compile(
    r"""^\s*(?: \*INCLUDE\b[^=\n]*=[ \t]*"?(?P<keyword>[^"\n]+)
            | (?P<mark>['"])(?P<blade>[^\n]*?)(?P=mark)\s+BldFile\b
            | INCLUDE\s+(?: (?P<quote>['"])(?P<quoted>.*?)(?P=quote) | (?P<plain>[^\n$]+) ) )""",
    re.IGNORECASE | re.MULTILINE | re.VERBOSE | re.DOTALL,
)


def files_read_with(path: Path) -> tuple[Path, ...]:
    """A file and all existing files that it includes, each once."""
    found: dict[Path, None] = {}
    left = [path]
    while left:
        file = left.pop()
        if file not in found and file.is_file():
            found[file] = None
            left += _included(file, path)
    return tuple(found)


def _included(path: Path, main: Path) -> Iterator[Path]:
    if path.suffix.lower() not in (".inp", *DMIG_SUFFIXES):
        return
    for match in _INCLUDE.finditer(path.read_text(encoding="utf-8", errors="replace")):
        name = next(match[kind] for kind in ("keyword", "blade", "quoted", "plain") if match[kind])
        yield included_file("".join(line.strip() for line in name.splitlines()), path.parent, main.parent)
