"""The whole file of an explicit case: all its tables, and all its rules."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

from pydantic import Field

from supple.cases.case_tables import units_are_one_set
from supple.cases.explicit import contacts, explicit_simulation, parts
from supple.cases.explicit.contacts import ContactTable, ForceTable, SupportTable, TieTable
from supple.cases.explicit.explicit_output import ExplicitOutput
from supple.cases.explicit.explicit_simulation import ExplicitSimulation
from supple.cases.explicit.parts import PartTable
from supple.cases.laws import tables_suit_the_run
from supple.importers.text_file import is_file
from supple.importers.toml import (
    ZERO,
    CheckedTable,
    KeyPath,
    Mistakes,
    Raw,
    Rule,
    Vector,
    names,
    table,
    tables,
    unknown,
)


class ExplicitTables(CheckedTable):
    """A whole case file of an explicit run."""

    title: str = Field(description="one line for tables and pictures")
    gravity: Vector = Field(ZERO, description="acceleration, global axes")
    units: dict[str, str] = Field(
        default_factory=dict,
        description='such as { length = "mm", mass = "t", time = "s" }; nothing is converted',
    )
    part: Annotated[tuple[PartTable, ...], Field(strict=False, min_length=1)]
    tie: Annotated[tuple[TieTable, ...], Field(strict=False)] = ()
    contact: Annotated[tuple[ContactTable, ...], Field(strict=False)] = ()
    support: Annotated[tuple[SupportTable, ...], Field(strict=False)] = ()
    load: Annotated[tuple[ForceTable, ...], Field(strict=False)] = ()
    simulation: ExplicitSimulation
    output: ExplicitOutput = Field(default_factory=lambda: ExplicitOutput.model_validate({}))


def places_named(raw: Raw) -> Iterator[tuple[KeyPath, object]]:
    """Every PART.NODE_SET of an explicit case, with the path of its key."""
    for section, key in (("tie", "nodes"), ("contact", "nodes"), ("support", "nodes"), ("load", "at")):
        for path, item in tables(raw, section):
            yield (*path, key), item.get(key)
    for path, contact in tables(raw, "contact"):
        if "surface" in contact:
            yield (*path, "surface"), contact["surface"]
    tracked = table(raw, "output").get("track")
    for position, place in enumerate(tracked if isinstance(tracked, list) else []):
        yield ("output", "track", position), place


def files_named(raw: Raw) -> Iterator[tuple[KeyPath, object]]:
    """Every key of an explicit case that may name a file, and what stands there."""
    for path, part in tables(raw, "part"):
        yield (*path, "mesh"), part.get("mesh")
    for path, load in tables(raw, "load"):
        yield (*path, "law", "file"), table(load, "law").get("file")


def _places_have_parts(raw: Raw) -> Mistakes:
    known = names(raw, "part")
    for path, place in places_named(raw):
        if not isinstance(place, str):
            continue
        name, dot, _ = place.partition(".")
        if not dot:
            yield path, f"{place!r} is not PART.NODE_SET; for example {next(iter(known), 'nose')}.TIP"
        elif name not in known:
            yield path, unknown("part", name, known)
    for path, tie in tables(raw, "tie"):
        if isinstance(tie.get("on"), str) and tie["on"] not in known:
            yield (*path, "on"), unknown("part", tie["on"], known)


def _suit_explicit_parts(raw: Raw) -> Mistakes:
    """Modal parts are tied to modal ones; supports hold explicit nodes; only a modal frame turns a force."""
    kinds = {part.get("name"): "explicit" in part for _, part in tables(raw, "part")}
    for path, tie in tables(raw, "tie"):
        name = tie["nodes"].partition(".")[0] if isinstance(tie.get("nodes"), str) else None
        if name is not None and name == tie.get("on"):
            yield (*path, "on"), "a part is not tied to itself; name another"
        elif kinds.get(name) is False and kinds.get(tie.get("on")) is True:
            message = (
                "this part is modal, and tied on an explicit one; name the nodes of the explicit part, and "
                "tie them on the modal one"
            )
            yield (*path, "nodes"), message
        elif table(tie, "transfer").get("kind") == "mortar" and kinds.get(tie.get("on")) is True:
            message = "explicit parts are tied node to node; a mortar is for ties on modal parts"
            yield (*path, "transfer"), message
        elif "continuity" in tie and kinds.get(name) is True:
            yield (
                (*path, "continuity"),
                "explicit nodes hang position for position; leave it out, or tie two modal parts",
            )
    for section, key, wanted, message in (
        ("support", "nodes", True, "only nodes of explicit parts are held, and this part is modal"),
        ("load", "at", False, "a force turns with a modal part's frame, and this part is explicit"),
    ):
        for path, item in tables(raw, section):
            place = item.get(key)
            name = place.partition(".")[0] if isinstance(place, str) else None
            concerned = section != "load" or item.get("follower") is True
            if concerned and kinds.get(name, wanted) is not wanted:
                yield (*path, key), message


def _files_exist(raw: Raw, folder: Path) -> Mistakes:
    for path, name in files_named(raw):
        if isinstance(name, str) and not is_file(folder / name):
            yield path, f"there is no file {folder / name}; file names are relative to the case file"


RULES: tuple[Rule, ...] = (
    *parts.RULES,
    *contacts.RULES,
    *explicit_simulation.RULES,
    units_are_one_set,
    _places_have_parts,
    _suit_explicit_parts,
)
"""What one key demands of another; each section states its own."""


def broken_rules(raw: Raw, folder: Path) -> list[tuple[KeyPath, str]]:
    """Every broken rule: the path of the key to look at, and what is wrong with the remedy.

    folder : where the case file lies: its file names are relative to it
    """
    broken = [mistake for rule in RULES for mistake in rule(raw)]
    return [*broken, *_files_exist(raw, folder), *tables_suit_the_run(raw, folder)]
