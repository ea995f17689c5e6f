"""Interfaces of reduced bodies, read from their files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from supple.errors import ResultFileError
from supple.importers.toml import KeyPath, Raw
from supple.storage import read_interface_names


def with_interfaces_of_files(raw: Raw, folder: Path) -> tuple[Raw, list[tuple[KeyPath, str]]]:
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
