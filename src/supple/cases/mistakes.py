"""The mistakes of a case file in words: all of them in one error, each with its line, key and remedy."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pydantic_core import ErrorDetails

from supple.cases.case_tables import CaseTables
from supple.cases.line_index import KeyPath, LineIndex
from supple.cases.raw_tables import did_you_mean
from supple.errors import CaseError


def case_error(path: Path, lines: LineIndex, mistakes: Iterable[tuple[KeyPath, str]]) -> CaseError:
    """The error of a file: its mistakes in the order of their lines, each with its key."""
    found = sorted({(lines.line_of(place), _spell(place), message) for place, message in mistakes})
    count = "one mistake" if len(found) == 1 else f"{len(found)} mistakes"
    listed = "\n".join(f"  line {line}, {place}: {message}" for line, place, message in found)
    return CaseError(f"{path} has {count}:\n{listed}")


def _spell(path: KeyPath) -> str:
    """`body[2].interface[1].nodes`, counting from 1 as a reader does."""
    return (
        "".join(f"[{part + 1}]" if isinstance(part, int) else f".{part}" for part in path).lstrip(".")
        or "case"
    )


def schema_mistake(item: ErrorDetails) -> tuple[KeyPath, str]:
    """One schema error as the path of its key in the file, and a sentence with the remedy."""
    place, schema = _follow(item["loc"])
    kind, seen, context = item["type"], item["input"], item.get("ctx", {})
    unit = f" ({schema['description']})" if "description" in schema else ""
    if kind == "extra_forbidden":
        known = _follow(item["loc"][:-1])[1].get("properties", {})
        return place, f"unknown key{did_you_mean(str(place[-1]), known)}; known keys: {', '.join(known)}"
    if kind == "missing":
        if isinstance(place[-1], int):
            items = _follow(item["loc"][:-1])[1]["minItems"]
            return place[:-1], f"{items} items are needed, got {seen!r}"
        return place, f"this key is missing; add it{unit}"
    if kind in ("union_tag_not_found", "union_tag_invalid", "literal_error"):
        return _wrong_choice(place, item, schema)
    if kind == "too_long":
        return place, f"at most {context['max_length']} items are taken, got {seen!r}"
    return place, f"{item['msg'].removeprefix('Input ')}, got {seen!r}{unit}"


def _wrong_choice(place: KeyPath, item: ErrorDetails, schema: Mapping[str, Any]) -> tuple[KeyPath, str]:
    context = item.get("ctx", {})
    if item["type"] == "literal_error":
        choices, seen = [str(choice) for choice in schema.get("enum", [schema.get("const")])], item["input"]
    else:
        key = context["discriminator"].strip("'")
        place, choices = (*place, key), list(schema["discriminator"]["mapping"])
        if item["type"] == "union_tag_not_found":
            return place, f"this key is missing; add {key} = one of {', '.join(choices)}"
        seen = context["tag"]
    return (
        place,
        f"{seen!r} is not known{did_you_mean(str(seen), choices)}; choose one of {', '.join(choices)}",
    )


def _follow(location: tuple[int | str, ...]) -> tuple[KeyPath, Mapping[str, Any]]:
    """The key path in the file, and the JSON schema there, of an error's location.

    A location also holds the tags of the alternatives that were tried (`reduction`, `rubin`, `modes`),
    which are no keys of the file.
    """
    root = CaseTables.model_json_schema()
    schema, path = _resolve(root, root), ()
    for part in location:
        alternatives = schema.get("discriminator", {}).get("mapping", {})
        if part in alternatives:
            schema = _resolve(root, {"$ref": alternatives[part]})
            continue
        path = (*path, part)
        if isinstance(part, int):
            items = schema.get("prefixItems", [])
            schema = _resolve(root, items[part] if part < len(items) else schema.get("items", {}))
        else:
            schema = _resolve(root, schema.get("properties", {}).get(part, {}))
    return path, schema


def _resolve(root: Mapping[str, Any], schema: Mapping[str, Any]) -> Mapping[str, Any]:
    """The schema behind references and behind 'or nothing', keeping the description of the key itself."""
    while "$ref" in schema or "anyOf" in schema:
        if "$ref" in schema:
            target = root["$defs"][schema["$ref"].rsplit("/", 1)[-1]]
        else:
            target = next(option for option in schema["anyOf"] if option.get("type") != "null")
        own = {key: value for key, value in schema.items() if key not in ("$ref", "anyOf")}
        schema = {**target, **own}
    return schema
