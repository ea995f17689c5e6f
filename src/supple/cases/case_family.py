"""A case file and its variants, which have other values in the same tables and pass the same checks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from supple.body import BodyForm
from supple.cases.case import Case
from supple.cases.case_tables import CaseTables, broken_rules, files_named
from supple.cases.notify import Notify, silent
from supple.cases.parameter_path import with_value
from supple.cases.read_case import completed, raw_tables, read_case, values_beyond_any_use
from supple.errors import CaseError
from supple.importers.toml import UNKNOWN_KEY, KeyPath, Raw, checked, index_lines, listed_mistakes


@dataclass(frozen=True, eq=False)
class CaseFamily:
    """A case file, and the cases that differ from it in some values.

    raw : tables of the file, with the tables of a machine file and the interfaces of reduced bodies added
    """

    path: Path
    text: str
    raw: Raw

    @cached_property
    def case(self) -> Case:
        """The case with the values of the file."""
        return read_case(self.path)

    def variant(
        self,
        values: Mapping[KeyPath, object],
        like: Case | None = None,
        made: Mapping[str, BodyForm] | None = None,
        notify: Notify = silent,
    ) -> Case:
        """The case with other values.

        values : by path in its tables
        like : a variant with the same bodies, whose meshes are reused
        made : bodies that are built already, by name

        Raises
        ------
        CaseError   values that a case file cannot have
        """
        raw = self.raw_variant(values)
        beyond = [each for place, value in values.items() for each in values_beyond_any_use(value, place)]
        tables, mistakes = checked(CaseTables, raw, beyond or broken_rules(raw, self.path.parent))
        if tables is None or mistakes:
            raise CaseError(listed_mistakes(self.path, index_lines(self.text), mistakes))
        if like is not None:
            return like.varied(tables, made or {})
        return Case(self.path, self.text, tables, index_lines(self.text), notify, made or {})

    def unknown_keys(self, values: Mapping[KeyPath, object]) -> dict[KeyPath, str]:
        """The places of `values` whose last key a case with these values cannot have, with the remedy."""
        _, mistakes = checked(CaseTables, self.raw_variant(values), ())
        return {place: text for place, text in mistakes if place in values and text.startswith(UNKNOWN_KEY)}

    def raw_variant(self, values: Mapping[KeyPath, object]) -> Raw:
        """The tables with other values."""
        raw = self.raw
        for place, value in values.items():
            raw = with_value(raw, place, value)
        return raw

    def files(self, values: Mapping[KeyPath, object]) -> tuple[str, ...]:
        """Names of the files of a variant."""
        return tuple(name for _, name in files_named(self.raw_variant(values)) if isinstance(name, str))


def case_family(path: Path) -> CaseFamily:
    """The family of a case file; CaseError for one with mistakes."""
    family = CaseFamily(path, *raw_tables(path))
    _ = family.case
    return CaseFamily(path, family.text, completed(family.raw, path.parent)[0])
