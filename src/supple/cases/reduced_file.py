"""Bodies of a case that are files of reduced bodies bring their interfaces."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from supple.errors import ResultFileError
from supple.importers.toml import KeyPath, Raw
from supple.storage import read_interface_names


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


def _interface_names(path: Path) -> tuple[tuple[str, ...], str]:
    """The names, or what is wrong with the file."""
    try:
        return read_interface_names(path), ""
    except ResultFileError as error:
        return (), str(error)
