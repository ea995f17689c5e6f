"""The ends of joints and springs and the places of loads: ground, BODY.INTERFACE or BODY.NODE_SET."""

from __future__ import annotations

from typing import Any

from supple.cases.body_kinds import kind_of
from supple.cases.contacts import part_places
from supple.cases.sensors import sensed_places
from supple.cases.stated_error import judged_places
from supple.importers.toml import KeyPath, Mistakes, Raw, did_you_mean, names, table, tables, unknown


def ends_exist(raw: Raw) -> Mistakes:
    """The rule that every end and place is there."""
    for key in ("joint", "spring"):
        for path, item in tables(raw, key):
            ground = item.get("kind") != "straight"
            yield from _exists(raw, (*path, "first"), item.get("first"), ground=ground)
            yield from _exists(raw, (*path, "second"), item.get("second"))
    for path, item in tables(raw, "element"):
        yield from _exists(raw, (*path, "first"), item.get("first"), ground=True)
        yield from _exists(raw, (*path, "second"), item.get("second"), ground=True)
    for path, load in tables(raw, "load"):
        yield from _exists(raw, (*path, "at"), load.get("at"), node_sets=True)
    tracked = table(raw, "output").get("track")
    for position, place in enumerate(tracked if isinstance(tracked, list) else []):
        yield from _exists(raw, ("output", "track", position), place, node_sets=True)
    for path, place in part_places(raw):
        yield from _exists(raw, path, place, node_sets=True)
    for path, key, place, node_sets in sensed_places(raw):
        yield from _exists(raw, (*path, key), place, node_sets=node_sets)
    for path, judged in judged_places(raw):
        yield from _exists(raw, (*path, "at"), judged.get("at"), node_sets=True)


def _exists(
    raw: Raw, path: KeyPath, place: Any, *, ground: bool = False, node_sets: bool = False
) -> Mistakes:
    """Check one place; whether a node set exists is known only once the mesh has been read."""
    if not isinstance(place, str):
        return
    if place == "ground":
        if not ground:
            yield path, "ground cannot stand here, only as first end of a joint or torsion spring"
        return
    bodies = {str(body.get("name")): body for _, body in tables(raw, "body")}
    name, dot, where = place.partition(".")
    if not dot:
        wanted = "ground or BODY.INTERFACE" if ground else "BODY.INTERFACE"
        nearest = did_you_mean(place, ["ground"] if ground else [])
        yield path, f"{place!r} is not {wanted}{nearest}; for example {next(iter(bodies), 'blade')}.root"
    elif name not in bodies:
        yield path, unknown("body", name, list(bodies))
    else:
        body, interfaces = bodies[name], names(bodies[name], "interface")
        kind = kind_of(body)
        may_be_a_set = node_sets and "mesh" in body and (kind is None or kind.has_elements)
        if where not in interfaces and not may_be_a_set:
            yield path, unknown(f"interface of {name!r}", where, interfaces)
