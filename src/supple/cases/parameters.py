"""Named numbers of a case that can be changed in an exported machine."""

from __future__ import annotations

from pydantic import Field

from supple.cases.parameter_path import number_at, parameter_path
from supple.cases.shared_rules import usable_names
from supple.errors import CaseError
from supple.importers.toml import CheckedTable, Mistakes, Raw, tables


class ParameterTable(CheckedTable):
    """A named number of the case."""

    name: str = Field(description="name of the variable in the FMU")
    path: str = Field(description="key that has the number, such as load[0].law.amplitude")
    unit: str = Field("", description="unit of the number in the FMU")


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
                f"{path} is not a number in this file; write it there, even if it is the default",
            )


RULES = (_lead_to_numbers, lambda raw: usable_names(raw, "parameter"))
