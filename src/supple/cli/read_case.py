"""From a TOML file to a checked case: every mistake at once, each with its line and remedy."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from supple.cases.case_tables import Case
from supple.cases.line_index import KeyPath, LineIndex, index_lines
from supple.cli.case_rules import broken_rules
from supple.cli.did_you_mean import did_you_mean
from supple.cli.reduced_file import with_interfaces_of_files
from supple.errors import CaseError


@dataclass(frozen=True)
class CaseFile:
    """A checked case with the way back to its text."""

    path: Path
    case: Case
    lines: LineIndex

    def resolve(self, name: str) -> Path:
        """A file named in the case, which is relative to the case file."""
        return self.path.parent / name

    def error(self, mistakes: Iterable[tuple[KeyPath, str]]) -> CaseError:
        """One error that lists mistakes found after reading, such as a node set missing in a mesh."""
        return _case_error(self.path, self.lines, mistakes)


def read_case(path: str | Path) -> CaseFile:
    """Read and check a case file.

    Raises
    ------
    CaseError   no such file, not TOML, or any number of mistakes: one line each, with line number and remedy
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise CaseError(f"cannot read the case file {path}: {error.strerror}; check the path") from error
    except UnicodeDecodeError as error:
        raise CaseError(f"{path} is not a text file in UTF-8; is it a case file (.toml)?") from error
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise CaseError(
            f"{path} is not valid TOML: {error}; strings need quotes, keys need a value"
        ) from error
    lines = index_lines(text)
    raw, mistakes = with_interfaces_of_files(raw, path.parent)
    mistakes += broken_rules(raw, path.parent)
    try:
        case = Case.model_validate(raw)
    except ValidationError as error:
        details = error.errors(include_url=False)
        raise _case_error(path, lines, [*(_mistake(item) for item in details), *mistakes]) from error
    if mistakes:
        raise _case_error(path, lines, mistakes)
    return CaseFile(path, case, lines)


def _case_error(path: Path, lines: LineIndex, mistakes: Iterable[tuple[KeyPath, str]]) -> CaseError:
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


def _mistake(item: ErrorDetails) -> tuple[KeyPath, str]:
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
    root = Case.model_json_schema()
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
