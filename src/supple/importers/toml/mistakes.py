"""Tables of a TOML file that a schema checks; their mistakes in one text, each with line, key and remedy."""

from __future__ import annotations

import re
import reprlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails

from supple.importers.toml.line_index import KeyPath, LineIndex
from supple.importers.toml.raw_tables import Raw, nearest_hint

__all__ = [
    "NUMBERS_OR_ROWS",
    "UNKNOWN_KEY",
    "WORD_OR_TABLE",
    "ZERO",
    "CheckedTable",
    "Matrix",
    "NodeIndices",
    "NonNegative",
    "Positive",
    "Vector",
    "checked",
    "listed_mistakes",
]

# Strict numbers and strings (no "0.02" for 0.02), but a TOML array may fill a tuple.
Vector = Annotated[tuple[float, float, float], Field(strict=False)]
Matrix = Annotated[tuple[Vector, Vector, Vector], Field(strict=False)]
NodeIndices = Annotated[tuple[int, ...], Field(strict=False)]
Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]

ZERO: tuple[float, float, float] = (0.0, 0.0, 0.0)


class CheckedTable(BaseModel):
    """A table of a TOML file: unknown keys are mistakes, values cannot change, numbers are finite.

    Its schema may state `json_schema_extra={"renamed": {former key: message}}`.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


UNKNOWN_KEY = "unknown key"
"""First words of the mistake of a key that its table does not have."""

WORD_OR_TABLE = ("word", "table")
"""Tags of a key that accepts a word or a table."""

NUMBERS_OR_ROWS = ("numbers", "rows")
"""Tags of a key that accepts the diagonal of a matrix, or its rows."""

_Schema = Mapping[str, Any]
_Root = TypeVar("_Root", bound=CheckedTable)


def checked(
    root: type[_Root], raw: Raw, mistakes: Sequence[tuple[KeyPath, str]]
) -> tuple[_Root | None, Sequence[tuple[KeyPath, str]]]:
    """The file checked by its schema, or None if it does not fit; and all mistakes.

    root : the table of the whole file;  mistakes : those that the rules found
    """
    try:
        return root.model_validate(raw), mistakes
    except ValidationError as error:
        errors = error.errors(include_url=False)
        # If keys were renamed, only these are reported, because other mistakes may follow from them.
        renamed = list(_renamed(root, errors))
        return None, renamed or [*(_schema_mistake(root, each) for each in errors), *mistakes]


def _renamed(root: type[CheckedTable], errors: Iterable[ErrorDetails]) -> Iterator[tuple[KeyPath, str]]:
    """Renamed keys and their messages."""
    for item in errors:
        *within, key = item["loc"]
        now = _follow(_tree(root), tuple(within))[1].get("renamed", {}).get(key)
        if item["type"] == "extra_forbidden" and now is not None:
            yield _follow(_tree(root), item["loc"])[0], now


def listed_mistakes(path: Path, lines: LineIndex, mistakes: Iterable[tuple[KeyPath, str]]) -> str:
    """The mistakes of a file in the order of their lines, each with its key."""
    found = sorted({(lines.line_of(place), _spell(place), message) for place, message in mistakes})
    count = "one mistake" if len(found) == 1 else f"{len(found)} mistakes"
    listed = "\n".join(f"  line {line}, {place}: {message}" for line, place, message in found)
    return f"{path} has {count}:\n{listed}"


def _spell(path: KeyPath) -> str:
    """`body[2].interface[1].nodes`, counting from 1 as a reader does."""
    return (
        "".join(f"[{part + 1}]" if isinstance(part, int) else f".{part}" for part in path).lstrip(".")
        or "case"
    )


@cache
def _tree(root: type[CheckedTable]) -> _Schema:
    """The schema of a file, cached because it takes long to build."""
    return root.model_json_schema()


def _schema_mistake(root: type[CheckedTable], item: ErrorDetails) -> tuple[KeyPath, str]:
    """One schema error as the path of its key in the file, and a sentence with the remedy.

    root : the table of the whole file, whose check found the error
    """
    tree = _tree(root)
    place, schema = _follow(tree, item["loc"])
    kind, seen = item["type"], item["input"]
    unit = f" ({schema['description']})" if "description" in schema else ""
    if kind == "extra_forbidden":
        known = _follow(tree, item["loc"][:-1])[1].get("properties", {})
        return place, f"{UNKNOWN_KEY}{nearest_hint(str(place[-1]), known)}; known keys: {', '.join(known)}"
    if kind == "missing":
        if isinstance(place[-1], int):
            items = _follow(tree, item["loc"][:-1])[1]["minItems"]
            return place[:-1], f"{items} items are needed, got {_shown(seen)}"
        return place, f"this key is missing; add it{unit}"
    if kind in ("union_tag_not_found", "union_tag_invalid", "literal_error"):
        return _wrong_choice(place, item, schema)
    return place, f"{_wanted(item, schema)}, got {_shown(seen)}" + (unit if kind != "too_long" else "")


def _wanted(item: ErrorDetails, schema: _Schema) -> str:
    """What a value of a wrong form or size must be instead."""
    kind = item["type"]
    if kind == "tuple_type":
        items = f"{schema['minItems']} items" if schema.get("minItems") else "items"
        return f"{items} in brackets, [.., ..], are needed"
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return "a table, { key = value, .. }, is needed"
    if kind == "too_long":
        return f"at most {item['ctx']['max_length']} items are allowed"
    return item["msg"].removeprefix("Input ")


def _wrong_choice(place: KeyPath, item: ErrorDetails, schema: _Schema) -> tuple[KeyPath, str]:
    context = item.get("ctx", {})
    if item["type"] == "literal_error":
        # A word of a union is in no `enum` of the schema at this place, but in the words of the error.
        words = re.findall("'([^']*)'", context["expected"])
        choices, seen = [str(choice) for choice in schema.get("enum", words)], item["input"]
    else:
        key = context["discriminator"].strip("'")
        place, choices = (*place, key), list(schema["discriminator"]["mapping"])
        if item["type"] == "union_tag_not_found":
            return place, f"this key is missing; add {key} = one of {', '.join(choices)}"
        seen = context["tag"]
    return (
        place,
        f"{_shown(seen)} is not known{nearest_hint(str(seen), choices)}; choose one of {', '.join(choices)}",
    )


def _shown(seen: object) -> str:
    """A value as in the file, shortened if long."""
    shortened = reprlib.Repr()
    shortened.maxstring = shortened.maxother = shortened.maxlong = 80
    return shortened.repr(seen)


def _follow(root: _Schema, location: tuple[int | str, ...]) -> tuple[KeyPath, _Schema]:
    """Key path in the file and JSON schema at the location of an error.

    A location also contains the tags of the alternatives that were checked (`reduction`, `rubin`, `modes`),
    which are not keys of the file.
    """
    schema, path = _resolve(root, root), ()
    for part in location:
        alternatives = schema.get("discriminator", {}).get("mapping", {})
        if part in alternatives:
            schema = _resolve(root, {"$ref": alternatives[part]})
            continue
        if not alternatives and part in WORD_OR_TABLE and "oneOf" in schema:
            option = next(each for each in schema["oneOf"] if ("$ref" in each) == (part == "table"))
            schema = _resolve(root, option)
            continue
        if not alternatives and part in NUMBERS_OR_ROWS and "oneOf" in schema:
            own = {key: value for key, value in schema.items() if key != "oneOf"}
            schema = {**_resolve(root, schema["oneOf"][NUMBERS_OR_ROWS.index(part)]), **own}
            continue
        path = (*path, part)
        if isinstance(part, int):
            items = schema.get("prefixItems", [])
            schema = _resolve(root, items[part] if part < len(items) else schema.get("items", {}))
        else:
            schema = _resolve(root, schema.get("properties", {}).get(part, {}))
    return path, schema


def _resolve(root: _Schema, schema: _Schema) -> _Schema:
    """The schema behind references and optional values, with the description of the key itself."""
    while "$ref" in schema or "anyOf" in schema:
        if "$ref" in schema:
            target = root["$defs"][schema["$ref"].rsplit("/", 1)[-1]]
        else:
            target = next(option for option in schema["anyOf"] if option.get("type") != "null")
        own = {key: value for key, value in schema.items() if key not in ("$ref", "anyOf")}
        schema = {**target, **own}
    return schema
