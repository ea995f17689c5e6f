"""A file and the files that are read with it: those it includes, and those its reader finds beside it."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from supple.errors import ImportFormatError
from supple.importers.inclusion import included_file
from supple.importers.nastran.mesh_view import NASTRAN_SUFFIXES
from supple.importers.text_file import file_text

__all__ = ["files_read_with"]

# Inclusions in files of Abaqus and CalculiX, BeamDyn, and Nastran; a quoted name of Nastran may span lines.
_INCLUDE = re.compile(
    r"""^\s*(?: \*INCLUDE\b[^=\n]*=[ \t]*"?(?P<keyword>[^"\n]+)
            | (?: (?P<mark>['"])(?P<blade>[^\n]*?)(?P=mark) | (?P<word>\S+) )\s+BldFile\b
            | INCLUDE\b\s*(?: (?P<quote>['"])(?P<quoted>.*?)(?P=quote) | (?P<plain>[^\n$]+) ) )""",
    re.IGNORECASE | re.MULTILINE | re.VERBOSE | re.DOTALL,
)


def files_read_with(path: Path) -> tuple[Path, ...]:
    """A file and all existing files that are read with it, each once.

    These are the files that a deck includes, the .dof file beside a matrix of CalculiX, and the modules
    beside a Python file that it imports.
    """
    suffix, found, left = path.suffix.lower(), dict[Path, None](), [path]
    while left:
        file = left.pop()
        if file in found or not file.is_file():
            continue
        found[file] = None
        if suffix in (".inp", *NASTRAN_SUFFIXES):  # an included file may have any suffix
            left += _included(file, path)
        elif suffix == ".py":
            left += _imported(file, path.parent)
        elif suffix in (".sti", ".mas"):
            left.append(path.with_suffix(".dof"))
    return tuple(found)


def _included(path: Path, main: Path) -> Iterator[Path]:
    for match in _INCLUDE.finditer(_text(path)):
        name = next(own for own in match.group("keyword", "blade", "word", "quoted", "plain") if own)
        yield included_file("".join(line.strip() for line in name.splitlines()), path.parent, main.parent)


def _imported(path: Path, folder: Path) -> Iterator[Path]:
    try:
        steps = list(ast.walk(ast.parse(_text(path))))
    except (SyntaxError, ValueError):  # reported when the file is run
        return
    for step in steps:
        match step:
            case ast.Import():
                names = [each.name for each in step.names]
            case ast.ImportFrom():
                names = [f"{step.module or ''}.{each.name}".strip(".") for each in step.names]
            case _:
                continue
        for name in names:
            parts = name.split(".")
            for end in range(1, len(parts) + 1):
                module = folder.joinpath(*parts[:end])
                yield from (module / "__init__.py", module.with_name(f"{module.name}.py"))


def _text(path: Path) -> str:
    """The text of a file; empty where it is no text, which its reader reports."""
    try:
        return file_text(path)
    except ImportFormatError:
        return ""
