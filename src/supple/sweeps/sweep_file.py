"""The sweep file (TOML): case file, table of the cases, and results to store."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from supple.cases.read_case import checked_file
from supple.cases.table import Key, table_of
from supple.errors import CaseError, ImportFormatError
from supple.importers.csv_table import CsvTable, read_csv_table
from supple.importers.plain_number import is_finite_number, is_number, number_of_word, plain_integer
from supple.importers.text_file import file_lines
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, Positive, Raw, checked, listed_mistakes
from supple.sweeps.case_table import (
    CaseTable,
    LatinHypercube,
    Normal,
    Sobol,
    Uniform,
    Weibull,
    crossed,
    full_factorial,
    sampled,
)
from supple.sweeps.channel_statistics import STATISTICS
from supple.sweeps.fatigue_loads import FatigueLoads

__all__ = ["SweepFile", "SweepOutput", "read_sweep_file"]

MOST_CASES = 10_000_000
_TRUTH = {"true": True, "false": False}


class SweepOutput(CheckedTable):
    """Table `[output]`: results that are stored besides the statistics of the channels."""

    keep: Literal["none", "all"] | Annotated[tuple[Annotated[int, Field(ge=0)], ...], Field(strict=False)] = (
        Field("none", description="cases whose motion is stored: all, none, or their numbers from 0")
    )
    cases_per_share: int | None = Field(
        None,
        ge=1,
        le=1000,
        description="number of cases per task and result file; default: by the number of cases",
    )
    labels: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        (), description="columns of the table that are no paths and change nothing, such as a wind speed"
    )
    seeds: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        (), description="columns whose values are realisations; statistics over them are computed"
    )
    fatigue: FatigueLoads | None = Field(None, description="damage-equivalent loads and hot spots")

    @property
    def statistics(self) -> tuple[str, ...]:
        """Names of the statistics of a channel."""
        return STATISTICS + (() if self.fatigue is None else self.fatigue.statistics)


class _Sample(CheckedTable):
    """Table `[sample]`: parameters that are sampled together."""

    method: Literal["latin-hypercube", "sobol"]
    number: int = Field(ge=1, le=MOST_CASES, description="number of points")
    seed: int = Field(0, ge=0)
    of: dict[str, Any] = Field(min_length=1, description="a range or distribution for each path")


class _SweepTables(CheckedTable):
    """All tables of a sweep file."""

    case: str = Field(description="case file, beside this one")
    table: str | None = Field(None, description="CSV file beside this one: a column per path, a row per case")
    vary: dict[str, Any] = Field(
        default_factory=dict, description="values of each path; all combinations are run"
    )
    sample: _Sample | None = None
    output: SweepOutput = Field(default_factory=lambda: SweepOutput.model_validate({}))


class _Range(CheckedTable):
    """Table of evenly spaced values."""

    first: int | float = Field(alias="from")
    last: int | float = Field(alias="to")
    number: int | None = Field(None, ge=1, le=MOST_CASES)
    step: int | float | None = Field(None, gt=0)

    def values(self) -> list[float] | list[int]:
        """The values; integers if all of them are, and both ends are written as integers."""
        if self.number is not None:
            values = np.linspace(self.first, self.last, self.number)
        else:
            assert self.step is not None
            number = int(np.floor((self.last - self.first) / self.step * (1 + 1e-12))) + 1
            values = self.first + self.step * np.arange(number)
        whole = (
            isinstance(self.first, int) and isinstance(self.last, int) and np.all(values == np.round(values))
        )
        return values.astype(int).tolist() if whole else values.tolist()


class _Pattern(CheckedTable):
    """Table of numbered names, such as those of files of wind seeds."""

    pattern: str = Field(description="text with {} in place of the number, such as wind-{:03}.csv")
    first: int = Field(1, alias="from")
    last: int = Field(alias="to", description="last number")

    def values(self) -> list[str]:
        return [self.pattern.format(number) for number in range(self.first, self.last + 1)]


_Between = table_of(Uniform, low=Key(name="from"), high=Key(name="to"))
_Normal = table_of(Normal, deviation=Positive)
_Weibull = table_of(Weibull, shape=Key(Positive, default=...))


@dataclass(frozen=True)
class SweepFile:
    """A checked sweep file.

    files : other files named in the sweep file
    """

    path: Path
    text: str
    case: Path
    table: CaseTable
    output: SweepOutput
    files: tuple[Path, ...]


def read_sweep_file(path: str | Path) -> SweepFile:
    """Read a sweep file; its table is not yet checked against the case.

    Raises
    ------
    CaseError           mistakes, each on a line with line number and remedy
    ImportFormatError   a CSV file that cannot be read
    """
    path = Path(path)

    def completed(raw: Raw) -> tuple[Raw, Sequence[tuple[KeyPath, str]]]:
        return raw, [*_mistakes_of_values(raw), *_names_something(raw, path.parent)]

    text, tables, lines = checked_file(path, _SweepTables, completed)
    parts, files = [], []
    if tables.table is not None:
        files.append(path.parent / tables.table)
        parts.append(_of_csv(files[0]))
    if (sample := tables.sample) is not None:
        method = Sobol if sample.method == "sobol" else LatinHypercube
        of = {name: _table_of_draws(given)[0].build() for name, given in sample.of.items()}
        parts.append(sampled(of, method(sample.number, sample.seed)))
    if tables.vary:
        parts.append(full_factorial({name: _listed_values(own) for name, own in tables.vary.items()}))
    number = int(np.prod([len(part) for part in parts], dtype=object))
    if not 1 <= number <= MOST_CASES:
        message = f"the table has {number} cases; give between 1 and {MOST_CASES}"
        raise CaseError(listed_mistakes(path, lines, [(("vary",), message)]))
    return SweepFile(path, text, path.parent / tables.case, crossed(*parts), tables.output, tuple(files))


def _names_something(raw: Raw, folder: Path) -> Mistakes:
    if not {"table", "sample", "vary"} & raw.keys():
        yield (), "nothing is varied: give [vary], [sample] or table = FILE.csv"
    for key in ("case", "table"):
        name = raw.get(key)
        if isinstance(name, str) and not (folder / name).is_file():
            yield (key,), f"there is no file {folder / name}; file names are relative to this file"


def _mistakes_of_values(raw: Raw) -> Mistakes:
    vary, sample = raw.get("vary"), raw.get("sample")
    for name, given in vary.items() if isinstance(vary, Mapping) else ():
        yield from ((("vary", name, *place), words) for place, words in _mistakes_of_list(given))
    of = sample.get("of") if isinstance(sample, Mapping) else None
    for name, given in of.items() if isinstance(of, Mapping) else ():
        yield from ((("sample", "of", name, *place), words) for place, words in _table_of_draws(given)[1])


def _mistakes_of_list(given: object) -> Iterator[tuple[KeyPath, str]]:
    if isinstance(given, list):
        if not given:
            yield (), "the list is empty; give at least one value"
        elif len(kinds := {_kind(value) for value in given}) > 1:
            yield (), f"give values of one kind, not {' and '.join(sorted(kinds))}"
        return
    if not isinstance(given, Mapping):
        yield (), "give a list of values, or {from = .., to = .., number = ..}"
        return
    made, mistakes = _table_of_values(given)
    yield from mistakes
    if isinstance(made, _Range):
        if (made.number is None) == (made.step is None):
            yield (), "give either number or step"
        elif made.step is not None and made.last < made.first:
            yield ("to",), f"{made.last} is less than from = {made.first}; exchange them"
    elif isinstance(made, _Pattern):
        try:
            values = made.values()
        except (ValueError, IndexError, KeyError) as error:
            yield (
                ("pattern",),
                f"a number cannot be inserted ({error}); write a pattern such as wind-{{:03}}.csv",
            )
        else:
            if len(set(values)) < max(len(values), 1):
                yield ("pattern",), "there is no {} for the number, or from is greater than to; correct it"


def _table_of_values(given: Raw) -> tuple[_Pattern | _Range | None, Sequence[tuple[KeyPath, str]]]:
    return checked(_Pattern if "pattern" in given else _Range, given, [])


def _table_of_draws(given: object) -> tuple[Any, Sequence[tuple[KeyPath, str]]]:
    if not isinstance(given, Mapping):
        return None, [
            ((), "give a range {from = .., to = ..}, {mean = .., deviation = ..} or {scale = .., shape = ..}")
        ]
    kind = _Normal if "mean" in given else _Weibull if "scale" in given else _Between
    return checked(kind, given, [])


def _kind(value: object) -> str:
    """Kind of a value, as text; integers and other numbers are of one kind."""
    if isinstance(value, bool):
        return "true or false"
    if isinstance(value, int | float):
        return "numbers"
    return {str: "words", list: "lists", dict: "tables"}.get(type(value), "others")


def _listed_values(given: Any) -> list[Any]:
    if not isinstance(given, Mapping):
        return list(given)
    made, _ = _table_of_values(given)
    assert made is not None  # mistakes are found before
    return made.values()


def _of_csv(path: Path) -> CaseTable:
    """The table in a CSV file.

    A column has numbers if all its entries are numbers, true and false if all entries are these words,
    otherwise texts. ImportFormatError for a column of numbers with empty entries, nan or inf.
    """
    head = next((line for line in file_lines(path) if line.strip() and not line.startswith("#")), "")
    names = [word.strip().strip('"') for word in head.split(",")]
    read = read_csv_table(path, required=names)
    return CaseTable({name: _column(read, name) for name in names})


def _column(read: CsvTable, name: str) -> Sequence[Any]:
    words = read.columns[name]
    given = [word for word in words if word]
    for kind in (plain_integer, number_of_word, _TRUTH.__getitem__):
        try:
            found = [kind(word) for word in given]
        except (ValueError, KeyError):
            continue
        if given and len(given) < len(words):
            line = read.lines[words.index("")]
            raise ImportFormatError(f"{read.path}, line {line}: {name} is empty; every case needs a value")
        return found
    if given and all(map(is_number, given)):
        row = next(row for row, word in enumerate(words) if word and not is_finite_number(word))
        raise ImportFormatError(
            f"{read.path}, line {read.lines[row]}: {name} is '{words[row][:40]}'; write a finite number"
        )
    return words
