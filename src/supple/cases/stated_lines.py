"""Slender bodies whose files state their stations: section tables, and matrices condensed elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from supple.body import Damping
from supple.cases.body_kinds import Matrices, SectionTableFile, Superelement, kind_of
from supple.cases.condense import is_condensed
from supple.errors import ModelError
from supple.importers import SECTION_SUFFIXES, read_section_table
from supple.importers.toml import KeyPath, Mistakes, Raw, table, tables
from supple.methods.intrinsic import IntrinsicBody, read_condensed_line, section_line
from supple.units import SI, UnitSystem

if TYPE_CHECKING:
    from supple.cases.bodies import Body

IN_SI = [suffix for suffix in SECTION_SUFFIXES if suffix != ".csv"]
"""Suffixes of windIO and BeamDyn files, whose numbers are in m, kg and s."""
_ON_ELEMENTS = ("tip", "stations")
_ON_GRIDS = ("paths", "root_mass")
_NOT_OF_A_LINE = {
    "rigid_tolerance": "its residual forces under rigid motion are removed; remove the key",
    "damping": "a condensed body takes no damping matrix; give damping = {..} of the body instead",
    "recovery": "a condensed body consists of its stations, and has no points inside; remove the key",
}
"""Messages for keys of the matrices that a condensed body does not use"""


def stated_line(body: Body, folder: Path, damping: Damping | None) -> IntrinsicBody:
    """The body in its intrinsic modes, from its files in `folder`.

    Raises ImportFormatError, ModelError as `read_section_table`, `section_line` and `read_condensed_line`.
    """
    given, matrices = body.condense, body.matrices
    assert given is not None
    interfaces = [(each.name, own) for each in body.interface for own in each.node_indices or ()]
    if body.section_table is not None:
        assert given.stations is not None  # a rule of the case file
        line = section_line(body.name, read_section_table(folder / body.section_table), given.stations)
        stations = {given.root: 0, given.tip or "tip": given.stations - 1, **dict(interfaces)}
        return given.on_line(line, stations, damping)
    assert matrices is not None
    assert given.paths is not None  # a rule of the case file
    line = read_condensed_line(
        body.name,
        nodes=folder / (body.mesh or ""),
        stiffness=folder / matrices.stiffness,
        mass=folder / matrices.mass,
        paths=given.paths,
        stiffness_name=matrices.stiffness_name,
        mass_name=matrices.mass_name,
        root_mass=None if given.root_mass is None else np.array(given.root_mass),
    )
    # The number of a station is the position of its grid along the paths.
    number = {grid: i for i, grid in enumerate(dict.fromkeys(chain(*given.paths)))}
    return given.on_line(line, {name: number[grid] for name, grid in interfaces}, damping)


def _is_a_line(path: KeyPath, body: Raw) -> Mistakes:
    if kind_of(body) is not SectionTableFile:
        return
    name = body.get("section_table")
    if isinstance(name, str) and Path(name).suffix.lower() not in SECTION_SUFFIXES:
        message = f"{name!r} is not a section table: give one of {', '.join(SECTION_SUFFIXES)}"
        yield (*path, "section_table"), message
    if is_condensed(body):
        yield from _interfaces_are_stations_of_the_table(path, body)


def _interfaces_are_stations_of_the_table(path: KeyPath, body: Raw) -> Iterator[tuple[KeyPath, str]]:
    given = table(body, "condense")
    ends, last = (given.get("root"), given.get("tip")), given.get("stations")
    for place, interface in tables(body, "interface", path):
        own, name = interface.get("node_indices"), interface.get("name")
        for key in (each for each in ("nodes", "connection", "kind", "position") if each in interface):
            yield (
                (*place, key),
                f"an interface of a section table is a station and takes no {key}; remove the key",
            )
        if name in ends:
            if own is not None:
                yield (*place, "node_indices"), f"{name!r} is an end of the line; remove the key"
        elif not isinstance(own, list) or len(own) != 1:
            yield (
                place,
                "an interface between the ends is one station: give node_indices = [NUMBER] (0: the root)",
            )
        elif isinstance(last, int) and isinstance(own[0], int) and not 0 <= own[0] < last:
            message = f"station {own[0]} does not exist: give one from 0 (the root) to {last - 1}"
            yield (*place, "node_indices"), message


def tables_are_in_units_of_the_case(raw: Raw) -> Mistakes:
    """The rule that a table in the SI units of its format belongs to a case in these units, or in none."""
    given = table(raw, "units")
    try:
        units = UnitSystem.stated({key: str(unit) for key, unit in given.items()})
    except ModelError:
        return  # reported elsewhere
    pairs = zip((units.length, units.mass, units.time), (SI.length, SI.mass, SI.time), strict=True)
    others = [stated for stated, own in pairs if stated not in ("", own)]
    if not others:
        return
    for path, body in tables(raw, "body"):
        name = body.get("section_table")
        if isinstance(name, str) and Path(name).suffix.lower() in IN_SI:
            yield (
                (*path, "section_table"),
                f"windIO and BeamDyn files are in m, kg and s, and units of the case {', '.join(others)}: "
                "give the case in m, kg and s, or the table as .csv in the units of the case",
            )


def _is_on_grids(body: Raw) -> bool:
    """True for a condensed body from matrices."""
    return is_condensed(body) and kind_of(body) is Matrices


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
    given, on_grids = table(body, "condense"), _is_on_grids(body)
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


def _interfaces_are_grids(path: KeyPath, body: Raw) -> Mistakes:
    if not _is_on_grids(body):
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


RULES_OF_BODY = (_keys_suit_the_kind, _interfaces_are_grids, _is_a_line)
