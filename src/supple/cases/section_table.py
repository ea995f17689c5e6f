"""A slender body from a section table, without a mesh; its stations define the body."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from supple.body import Damping
from supple.cases.body_kinds import SectionTableFile, kind_of
from supple.cases.condense import Condense, is_condensed
from supple.cases.interfaces import InterfaceTable
from supple.errors import ModelError
from supple.importers import SECTION_SUFFIXES, read_section_table
from supple.importers.toml import KeyPath, Mistakes, Raw, table, tables
from supple.methods.intrinsic import IntrinsicBody, section_line
from supple.units import SI, UnitSystem

IN_SI = [suffix for suffix in SECTION_SUFFIXES if suffix != ".csv"]
"""Suffixes of windIO and BeamDyn files, whose numbers are in m, kg and s."""


def line_of_sections(
    name: str, path: Path, given: Condense, interfaces: Sequence[InterfaceTable], damping: Damping | None
) -> IntrinsicBody:
    """The body in its intrinsic modes.

    Raises ImportFormatError, ModelError as `read_section_table` and `section_line`.
    """
    assert given.stations is not None  # a rule of the case file
    ends = {given.root: 0, given.tip or "tip": given.stations - 1}
    inner = {each.name: index for each in interfaces for index in each.node_indices or ()}
    return given.on_line(section_line(name, read_section_table(path), given.stations), ends | inner, damping)


def _is_a_line(path: KeyPath, body: Raw) -> Mistakes:
    if kind_of(body) is not SectionTableFile:
        return
    name = body.get("section_table")
    if isinstance(name, str) and Path(name).suffix.lower() not in SECTION_SUFFIXES:
        message = f"{name!r} is not a section table: give one of {', '.join(SECTION_SUFFIXES)}"
        yield (*path, "section_table"), message
    if is_condensed(body):
        yield from _interfaces_are_stations(path, body)


def _interfaces_are_stations(path: KeyPath, body: Raw) -> Iterator[tuple[KeyPath, str]]:
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


RULES_OF_BODY = (_is_a_line,)
