"""Reading of a TOML file as a checked case; all mistakes are reported, each with its line and remedy."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

from supple.arguments import checked_arguments
from supple.cases.case import Case
from supple.cases.case_tables import CaseTables, broken_rules
from supple.cases.machine_file import Mistake, with_machine
from supple.cases.notify import Notify, silent
from supple.errors import CaseError, ResultFileError, SuppleError
from supple.importers.plain_number import LARGEST_INTEGER
from supple.importers.toml import (
    CheckedTable,
    KeyPath,
    LineIndex,
    Raw,
    checked,
    index_lines,
    listed_mistakes,
)
from supple.storage import read_interface_names

__all__ = ["read_case"]

_Root = TypeVar("_Root", bound=CheckedTable)

LARGEST = 1e60
"""Largest magnitude of a finite number in a file; above it, powers and products could overflow: an error."""
DEEPEST = 20
"""Largest nesting of tables and lists; deeper nesting is an error. A case needs six levels."""


@checked_arguments
def read_case(path: str | Path, notify: Notify = silent) -> Case:
    """Read and check a case file.

        case = read_case("blade.toml")
        solution = simulate(case.system, case.run)

    notify : called at each long step when the bodies of the case are built

    Raises
    ------
    CaseError   no such file, not TOML, or any number of mistakes: one line each, with line number and remedy
    """
    path = Path(path)

    def checked_by_rules(raw: Raw) -> tuple[Raw, list[Mistake]]:
        raw, mistakes = completed(raw, path.parent)
        return raw, [*mistakes, *broken_rules(raw, path.parent)]

    text, tables, lines = checked_file(path, CaseTables, checked_by_rules)
    unusable = list(_unusable_parts(tables, path.parent))
    if unusable:
        raise CaseError(listed_mistakes(path, lines, unusable))
    try:
        tables.simulation.build()
    except ValueError as error:  # numbers of the run that do not fit together
        raise CaseError(listed_mistakes(path, lines, [(("simulation",), str(error))])) from error
    return Case(path, text, tables, lines, notify)


def completed(raw: Raw, folder: Path) -> tuple[Raw, list[Mistake]]:
    """The raw case with the machine and the interfaces that its files contain, and the mistakes in them."""
    raw, of_machine = with_machine(raw, folder)
    raw, mistakes = _with_interfaces_of_files(raw, folder)
    return raw, [*of_machine, *mistakes]


def _with_interfaces_of_files(raw: Raw, folder: Path) -> tuple[Raw, list[Mistake]]:
    """The raw case with the interfaces of reduced bodies added from their files, and the mistakes found.

    Joints and loads at these interfaces are then checked like all others.
    """
    bodies, mistakes = raw.get("body"), []
    if not isinstance(bodies, list):
        return raw, mistakes
    completed = list(bodies)
    for number, body in enumerate(bodies):
        if not (isinstance(body, Mapping) and isinstance(body.get("reduced"), str)):
            continue
        path: KeyPath = ("body", number)
        if "interface" in body:
            mistakes.append(
                ((*path, "interface"), "the file of a reduced body has its interfaces; remove these")
            )
        try:
            names = read_interface_names(folder / body["reduced"])
        except ResultFileError as error:
            names = ()
            mistakes.append(((*path, "reduced"), str(error)))
        completed[number] = {**body, "interface": [{"name": name} for name in names]}
    return {**raw, "body": completed}, mistakes


def _unusable_parts(tables: CaseTables, folder: Path) -> Iterator[Mistake]:
    """Errors in the numbers of joints, springs and elements; no mesh is needed to find them."""
    for section in ("joint", "spring", "element"):
        for number, each in enumerate(getattr(tables, section)):
            try:
                each.build(folder)
            except SuppleError as error:
                yield (section, number), str(error)


def checked_file(
    path: Path,
    root: type[_Root],
    completed: Callable[[Raw], tuple[Raw, Sequence[Mistake]]],
) -> tuple[str, _Root, LineIndex]:
    """The text of a case file, its tables, and their lines.

    root : the table of the whole file
    completed : function that returns the raw tables, completed for the schema, and the mistakes in them

    Raises
    ------
    CaseError   no such file, not TOML, or any number of mistakes
    """
    text, raw = raw_tables(path)
    lines = index_lines(text)
    beyond = list(values_beyond_any_use(raw))
    if beyond:  # the rules do not handle these
        raise CaseError(listed_mistakes(path, lines, beyond))
    raw, mistakes = completed(raw)
    tables, mistakes = checked(root, raw, mistakes)
    if tables is None or mistakes:
        raise CaseError(listed_mistakes(path, lines, mistakes))
    return text, tables, lines


def raw_tables(path: Path) -> tuple[str, Raw]:
    """The text of a case file, and its tables as the TOML reader returns them.

    CaseError for a file that cannot be read, is not TOML, or is nested deeper than `DEEPEST`.
    """
    text = _text(path)
    try:
        raw = tomllib.loads(text)
    except ValueError as error:  # not TOML, or a number of thousands of digits
        if path.suffix.lower() != ".toml":
            raise CaseError(
                f"{path} is not a case file, which ends in .toml; for a mesh, a deck or a robot write one: "
                f"supple new {path}"
            ) from error
        raise CaseError(
            f"{path} is not valid TOML: {error}; strings need quotes, keys need a value"
        ) from error
    except RecursionError:
        raw = None
    if raw is None or _depth(raw) > DEEPEST:
        raise CaseError(
            f"{path}: tables and lists nest more than {DEEPEST} deep, which no key needs; remove a "
            "repeated bracket"
        )
    return text, raw


def _text(path: Path) -> str:
    try:
        # A byte-order mark, which some editors write, is not part of the text.
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise CaseError(f"cannot read the case file {path}: {error.strerror}; check the path") from error
    except UnicodeDecodeError as error:
        raise CaseError(f"{path} is not a text file in UTF-8; give a case file (.toml)") from error
    except ValueError as error:
        raise CaseError(f"cannot read the case file {str(path)!r}: {error}; check the path") from error


def _depth(raw: Raw) -> int:
    """Nesting of tables and lists, at most `DEEPEST` + 1; without recursion, which could overflow."""
    depth, level = 0, [raw]
    while level and depth <= DEEPEST:
        depth += 1
        held = [each for item in level for each in (item.values() if isinstance(item, dict) else item)]
        level = [each for each in held if isinstance(each, dict | list)]
    return depth


def values_beyond_any_use(value: object, path: KeyPath = ()) -> Iterator[Mistake]:
    """Path and message of each integer beyond 64 bits and each finite float of magnitude above `LARGEST`."""
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from values_beyond_any_use(item, (*path, key))
    elif isinstance(value, int) and not -LARGEST_INTEGER - 1 <= value <= LARGEST_INTEGER:
        digits = f"{value:.6g}" if abs(value) < 10**300 else "one of over 300 digits"
        yield path, f"a whole number has at most 64 bits, got {digits}; add a decimal point, or correct it"
    elif isinstance(value, float) and LARGEST < abs(value) < float("inf"):
        yield path, f"{value:g} exceeds the largest usable magnitude, {LARGEST:g}; correct it"
