"""A slender body condensed on its stations by another program, from its matrices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path

import numpy as np

from supple.body import Damping
from supple.cases.body_kinds import Matrices, Superelement, kind_of
from supple.cases.condense import Condense, is_condensed
from supple.cases.interfaces import InterfaceTable
from supple.importers.toml import KeyPath, Mistakes, Raw, table, tables
from supple.methods.intrinsic import IntrinsicBody, read_condensed_line

_ON_ELEMENTS = ("tip", "stations")
_ON_GRIDS = ("paths", "root_mass")
_NOT_OF_A_LINE = {
    "rigid_tolerance": "its residual forces under rigid motion are removed; remove the key",
    "damping": "a condensed body takes no damping matrix; give damping = {..} of the body instead",
    "recovery": "a condensed body consists of its stations, and has no points inside; remove the key",
}
"""Messages for keys of the matrices that a condensed body does not use"""


def line_on_grids(
    name: str,
    matrices: Matrices,
    mesh: Path,
    given: Condense,
    interfaces: Sequence[InterfaceTable],
    damping: Damping | None,
) -> IntrinsicBody:
    """The body in its intrinsic modes.

    mesh : file of the grids, in the folder of the matrices

    Raises ImportFormatError, ModelError as `read_condensed_line`.
    """
    assert given.paths is not None  # a rule of the case file
    line = read_condensed_line(
        name,
        nodes=mesh,
        stiffness=mesh.parent / matrices.stiffness,
        mass=mesh.parent / matrices.mass,
        paths=given.paths,
        stiffness_name=matrices.stiffness_name,
        mass_name=matrices.mass_name,
        root_mass=None if given.root_mass is None else np.array(given.root_mass),
    )
    return given.on_line(line, _stations(given.paths, interfaces), damping)


def is_on_grids(body: Raw) -> bool:
    """True for a condensed body from matrices."""
    return is_condensed(body) and kind_of(body) is Matrices


def _stations(paths: Sequence[Sequence[int]], interfaces: Sequence[InterfaceTable]) -> Mapping[str, int]:
    """Station number of each interface, by interface name: position of its grid along the paths, from 0."""
    number = {grid: i for i, grid in enumerate(dict.fromkeys(chain(*paths)))}
    return {each.name: number[grid] for each in interfaces for grid in each.node_indices or ()}


def _keys_suit_the_kind(path: KeyPath, body: Raw) -> Mistakes:
    if not is_condensed(body):
        return
    if kind_of(body) is Superelement:
        message = (
            "the rows of a superelement have no grid labels: give a matrices body, condensed on the grids of "
            "its stations, or elements"
        )
        yield (*path, "condense"), message
        return
    given, on_grids = table(body, "condense"), is_on_grids(body)
    wanted, needless = (("paths",), _ON_ELEMENTS) if on_grids else (_ON_ELEMENTS, _ON_GRIDS)
    made_of = "a section table" if "section_table" in body else "elements"
    made_of = "matrices, condensed already," if on_grids else made_of
    for key in wanted:
        if key not in given:
            shown = "paths = [[GRID, GRID, ..]]" if on_grids else key
            yield (*path, "condense"), f"a body of {made_of} needs {shown} here"
    for key in (each for each in needless if each in given):
        yield (*path, "condense", key), f"a body of {made_of} takes no {key}; remove the key"
    for key, message in _NOT_OF_A_LINE.items() if on_grids else ():
        if key in table(body, "matrices"):
            yield (*path, "matrices", key), message


def _interfaces_are_stations(path: KeyPath, body: Raw) -> Mistakes:
    if not is_on_grids(body):
        return
    given = table(body, "condense")
    paths = given.get("paths")
    if not isinstance(paths, list) or not all(isinstance(each, list) and each for each in paths):
        return  # the schema reports it
    grids = list(chain(*paths))
    for place, interface in tables(body, "interface", path):
        for key in (each for each in ("nodes", "connection", "kind", "position") if each in interface):
            yield (*place, key), f"an interface here is a station: give node_indices = [GRID] and no {key}"
        own = interface.get("node_indices")
        if own is None:
            continue
        at = (*place, "node_indices")
        if not isinstance(own, list) or len(own) != 1:
            yield at, "an interface here is one station: give node_indices = [GRID]"
        elif own[0] not in grids:
            yield at, f"grid {own[0]} is on no load path: add it to paths, or give a grid on a path"
        elif interface.get("name") == given.get("root") and own[0] != grids[0]:
            yield at, f"the root is the start of the paths, grid {grids[0]}, not grid {own[0]}"


RULES_OF_BODY = (_keys_suit_the_kind, _interfaces_are_stations)
