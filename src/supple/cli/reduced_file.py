"""Bodies of a case that are files of reduced bodies: their interfaces, and the bodies themselves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from supple.cases.line_index import KeyPath
from supple.errors import ResultFileError

if TYPE_CHECKING:
    from supple.reduction import ReducedBody

Raw = Mapping[str, Any]


def with_interfaces_of_files(raw: Raw, folder: Path) -> tuple[Raw, list[tuple[KeyPath, str]]]:
    """The raw case with the interfaces of such bodies as if they were written in it, and mistakes about them.

    So joints and loads that name them are checked like all others.
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
            mistakes.append(((*path, "interface"), "a reduced body brings its interfaces; remove these"))
        names, mistake = _interface_names(folder / body["reduced"])
        if mistake:
            mistakes.append(((*path, "reduced"), mistake))
        completed[number] = {**body, "interface": [{"name": name} for name in names]}
    return {**raw, "body": completed}, mistakes


def read_body(path: Path, name: str) -> ReducedBody:
    """The reduced body of a file under its name in the case; ResultFileError when it cannot be read."""
    from supple.storage import read_reduced_body

    return replace(read_reduced_body(path), name=name)


def _interface_names(path: Path) -> tuple[tuple[str, ...], str]:
    """The names, or what is wrong with the file."""
    # Imported here: the solvers take seconds to load, and few cases have such bodies.
    from supple.storage import read_interface_names

    try:
        return read_interface_names(path), ""
    except ResultFileError as error:
        return (), str(error)
