"""The rule on ends and places: ground, BODY.INTERFACE or BODY.NODE_SET."""

from __future__ import annotations

from supple.cases.body_kinds import kind_of
from supple.importers.toml import KeyPath, Mistakes, Raw, names, nearest_hint, tables, unknown

NO_INTERFACES = (
    "has explicit elements, and these have no interfaces, which joints, springs, torques, follower loads and "
    "rotations need: tie the nodes to a modal part ([[tie]]) and give an interface of that part; [[support]] "
    "fixes nodes in space"
)


def place_exists(raw: Raw, path: KeyPath, place: object, may_be: str) -> Mistakes:
    """The rule that a place exists; a node set can be checked only once the mesh has been read."""
    ground = may_be == "ground"
    if not isinstance(place, str):
        return
    if place == "ground":
        if not ground:
            yield (
                path,
                "ground is not allowed here, only as first end of a joint or spring, or as end of an element",
            )
        return
    bodies = {str(body.get("name")): body for _, body in tables(raw, "body")}
    name, dot, where = place.partition(".")
    if not dot:
        wanted = "ground or BODY.INTERFACE" if ground else "BODY.INTERFACE"
        nearest = nearest_hint(place, ["ground"] if ground else [])
        yield path, f"{place!r} is not {wanted}{nearest}; for example {next(iter(bodies), 'blade')}.root"
    elif name not in bodies:
        yield path, unknown("body", name, list(bodies))
    else:
        body, interfaces = bodies[name], names(bodies[name], "interface")
        kind = kind_of(body)
        may_be_a_set = may_be == "node set" and "mesh" in body and (kind is None or kind.has_elements)
        if "explicit" in body and not may_be_a_set:
            yield path, f"{name!r} {NO_INTERFACES}"
        elif where not in interfaces and not may_be_a_set:
            yield path, unknown(f"interface of {name!r}", where, interfaces)
