"""Rules and types common to several sections: keys with places and files, names."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict

from supple.importers.toml import KeyPath, Mistakes, Raw, tables

End = Annotated[str, "ground"]
InterfaceOf = Annotated[str, "interface"]
PlaceOf = Annotated[str, "node set"]
FileName = Annotated[str, "file"]
"""Types of keys: `InterfaceOf` names an interface, `End` also the ground, `PlaceOf` also a node set."""

BODY_AXIS = ConfigDict(
    json_schema_extra={
        "renamed": {
            "axis": "axis is now body_axis: the direction is along the axes of the body, not global ones"
        }
    }
)
"""For tables whose direction had the key `axis`; in all other tables, `axis` is along global axes."""


def joint_label(kind: object, first: object, second: object) -> str:
    """Label of a joint without a name: its kind without hyphens, and its ends."""
    return f"{str(kind).replace('-', '')} {first} - {second}"


def joint_names(raw: Raw) -> list[str]:
    """Labels of the joints of a case."""
    return [
        str(each.get("name") or joint_label(each.get("kind"), each.get("first"), each.get("second")))
        for _, each in tables(raw, "joint")
    ]


def usable_names(raw: Raw, key: str, path: KeyPath = ()) -> Mistakes:
    """The rule that the names in an array of tables are unique, printable, and valid in `BODY.INTERFACE`.

    key, path : key of the array, such as body or joint, and path of the table that contains it
    """
    taken: set[str] = set()
    for place, item in tables(raw, key, path):
        name = item.get("name")
        if not isinstance(name, str):
            continue
        if name in taken:
            yield (*place, "name"), f"an earlier {key} is already named {name!r}; names must differ"
        if "." in name or name == "ground":
            yield (*place, "name"), f"{name!r} cannot be a {key} name: no dots, and not the word ground"
        if not name.isprintable():
            yield (*place, "name"), f"{name!r} cannot be a {key} name: remove the unprintable characters"
        taken.add(name)


def axes_with_length(path: KeyPath, raw: Raw) -> Mistakes:
    """The rule that a direction is not zero."""
    for key in ("axis", "second_axis", "x_axis"):
        if raw.get(key) == [0, 0, 0]:
            yield (*path, key), "an axis of length zero has no direction; give for example [1, 0, 0]"
