"""The reference of the case file: every table with its keys, from the schema by which case files are checked.

The dimension of a key is the clause of its description that consists of quantities, as "force per length".
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from supple.cases.case_tables import CaseTables

Schema = Mapping[str, Any]

_FRONT = """# Reference of the case file

All tables and keys of a [case file](../how-to/case_file.md), generated from the tables that check it.
A dimension is given in the units of the case: "a time" is in seconds if the case is in SI units.
A key without a default that is not required has no effect unless it is given.
"""
_WORDS = "one|time|length|mass|force|moment|area|volume|depth|velocity|acceleration|rad|periods|Hz"
_QUANTITY = rf"(?:angular )?(?:{_WORDS})(?: squared)?"
_DIMENSION = re.compile(rf"(?:an? )?{_QUANTITY}(?: (?:per|or|times) {_QUANTITY})*")
_BOUNDS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}
_HEAD = "| key | type | dimension | default | meaning |\n| --- | --- | --- | --- | --- |\n"
_SELECTORS = ("kind", "basis")
_LONGEST = 40
"""Characters of a selector that a heading shows."""


def case_reference() -> str:
    """The page, in Markdown."""
    tables = _Tables(CaseTables.model_json_schema())
    tables.visit("Top level", tables.root)
    return _FRONT + "".join(f"\n## {heading}\n{tables.page(table)}" for heading, table in tables.listed)


def dimension_and_meaning(description: str) -> tuple[str, str]:
    """The dimension in a description, or "", and the other clauses."""
    clauses = re.split(r"(?<=[,;:]) ", description)
    for place, clause in enumerate(clauses):
        if _DIMENSION.fullmatch(clause.rstrip(",;:")):
            rest = " ".join(clauses[:place] + clauses[place + 1 :])
            return clause.rstrip(",;:"), rest.rstrip(",;:")
    return "", description


@dataclass
class _Tables:
    """The tables of a schema in the order of their nesting, each under its first place."""

    root: Schema
    listed: list[tuple[str, Schema]] = field(default_factory=list)
    anchors: dict[str, str] = field(default_factory=dict)

    def visit(self, heading: str, table: Schema, place: str = "") -> None:
        """List a table, then the tables of its keys."""
        self.listed.append((heading, table))
        for key, rule in table.get("properties", {}).items():
            brackets = "[[{}]]" if rule.get("type") == "array" else "[{}]"
            here = f"{place}.{key}" if place else brackets.format(key)
            for name in _references(rule):
                if name in self.anchors:
                    continue
                inner = self.root["$defs"][name]
                selector = _selector(inner)
                # A selector with many words, such as the kinds of joints, is only in the row of its key.
                title = f"`{here}` with `{selector}`" if 0 < len(selector) < _LONGEST else f"`{here}`"
                self.anchors[name] = _anchor(f"{here} {selector[:_LONGEST]}", taken=self.anchors.values())
                self.visit(f"{title} {{ #{self.anchors[name]} }}", inner, here)

    def page(self, table: Schema) -> str:
        """The description of a table and its keys."""
        required = table.get("required", ())
        rows = [
            "| " + " | ".join(_cell(text) for text in self._row(key, rule, key in required)) + " |\n"
            for key, rule in table.get("properties", {}).items()
            if "const" not in rule
        ]
        about = "" if table is self.root else f"{table.get('description', '').partition(chr(10))[0]}\n\n"
        if not rows:
            return about
        return "".join([about, _HEAD, *rows])

    def _row(self, key: str, rule: Schema, required: bool) -> tuple[str, ...]:
        dimension, meaning = dimension_and_meaning(rule.get("description", ""))
        links = " or ".join(dict.fromkeys(self._types(rule)))
        default = rule.get("default")
        shown = "required" if required else "" if default in (None, [], {}) else f"`{_toml(default)}`"
        return f"`{key}`", links, dimension, shown, meaning or self._about(rule)

    def _about(self, rule: Schema) -> str:
        """The meaning of a key with a table as value: that of the table, or the key that selects one."""
        tables = [self.root["$defs"][name] for name in _references(rule)]
        if not tables:
            return ""
        key, _, _ = _selector(tables[0]).partition(" = ")
        about = f"a table for each `{key}`" if len(tables) > 1 else tables[0].get("description", "")
        return about.partition("\n")[0]

    def _types(self, rule: Schema) -> Iterator[str]:
        if "$ref" in rule:
            name = rule["$ref"].rpartition("/")[2]
            _, _, words = _selector(self.root["$defs"][name]).partition(" = ")
            label = f"`{words}`" if 0 < len(words) < _LONGEST else "table"
            yield f"[{label}](#{self.anchors[name]})"
        elif "const" in rule or "enum" in rule:
            yield from (f"`{_toml(word)}`" for word in rule.get("enum", [rule.get("const")]))
        elif rule.get("type") == "array":
            yield from self._array(rule)
        elif "anyOf" in rule or "oneOf" in rule:
            for each in (*rule.get("anyOf", ()), *rule.get("oneOf", ())):
                yield from self._types(each)
        elif rule.get("type") not in (None, "null"):
            inner = rule.get("additionalProperties")
            if isinstance(inner, Mapping):
                yield f"table of {inner['type']}s"
                return
            limits = " and ".join(f"{sign} {rule[word]:g}" for word, sign in _BOUNDS.items() if word in rule)
            yield f"{rule['type']} {limits}".strip()

    def _array(self, rule: Schema) -> Iterator[str]:
        items = rule.get("items") or (rule.get("prefixItems") or [{}])[0]
        inner = re.sub(r"^(number|integer|string)\b", r"\1s", " or ".join(dict.fromkeys(self._types(items))))
        least, most = rule.get("minItems"), rule.get("maxItems")
        rows = "rows of " if inner[:1].isdigit() else ""
        yield f"{least} {rows}{inner}" if least and least == most else f"list of {inner}"


def _references(rule: Any) -> Iterator[str]:
    """Names of the tables allowed for a key, in the order of the schema."""
    if isinstance(rule, Mapping):
        if "$ref" in rule:
            yield rule["$ref"].rpartition("/")[2]
        for word in ("anyOf", "oneOf", "items", "prefixItems"):
            yield from _references(rule.get(word))
    elif isinstance(rule, list):
        for each in rule:
            yield from _references(each)


def _selector(table: Schema) -> str:
    """The key that selects a table among alternatives, such as `kind = "sine"`, or ""."""
    for key in _SELECTORS:
        rule = table.get("properties", {}).get(key, {})
        if words := rule.get("enum") or ([rule["const"]] if "const" in rule else []):
            return f"{key} = " + " or ".join(_toml(word) for word in words)
    return ""


def _anchor(place: str, taken: Collection[str]) -> str:
    """A unique anchor from the words of a place."""
    words = "-".join(re.findall(r"[a-z0-9]+", place))
    return words if words not in taken else f"{words}-{len(taken)}"


def _toml(value: Any) -> str:
    """A value as text of a case file."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml(each)}" for key, each in value.items()) + " }"
    return json.dumps(value)


def _cell(text: str) -> str:
    return text.replace("|", r"\|").replace("\n", " ")
