"""Numbers of a case that an exported machine may change, by names."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from supple.cases.parameter_path import parameter_path
from supple.cases.shared_rules import usable_names
from supple.errors import CaseError
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, Raw, tables

__all__ = ["RULES", "ParameterTable", "number_at"]


class ParameterTable(CheckedTable):
    """A number of the case under a name."""

    name: str = Field(description="of the variable in the FMU")
    path: str = Field(description="key that has the number, such as load[0].law.amplitude")
    unit: str = Field("", description="of the number, as the FMU states it")


def number_at(path: KeyPath, raw: Raw) -> float | None:
    """The number that stands at a place of a case; None where there is none."""
    found: Any = raw
    for key in path:
        if isinstance(found, dict) and key not in found:
            return None
        found = found[key]
    return float(found) if isinstance(found, int | float) and not isinstance(found, bool) else None


def _lead_to_numbers(raw: Raw) -> Mistakes:
    for place, each in tables(raw, "parameter"):
        path = each.get("path")
        if not isinstance(path, str):
            continue
        try:
            there = parameter_path(path, raw)
        except CaseError as error:
            yield (*place, "path"), str(error)
            continue
        if number_at(there, raw) is None:
            yield (
                (*place, "path"),
                f"{path} is no number of this file; write it there, also where it is the default",
            )


def _names_differ(raw: Raw) -> Mistakes:
    yield from usable_names(raw, "parameter")


RULES = (_lead_to_numbers, _names_differ)
