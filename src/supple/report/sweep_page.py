"""The page of a sweep: one HTML file that needs no network, with tables, plots and spectra of its cases."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from supple.arguments import checked_arguments
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.report.packed_arrays import PackedArrays
from supple.report.page import Assets, PageSection, html_text, write_text
from supple.units import labelled

__all__ = ["ChannelOfCases", "RainflowSpectrum", "SweepPage", "channels_that_fit", "write_sweep_page"]


_ASSETS = Assets(
    "sweep.html",
    ("page", "sweep"),
    ("arrays", "colours", "cases", "sweep_tables", "sweep_plots", "sweep"),
)
_NUMBERS = 2**22
"""Largest number of values in a page, 32 MiB before compression: a browser opens such a page in seconds."""
_EXTREMES = ("minimum", "time of minimum", "maximum", "time of maximum")


@dataclass(frozen=True, eq=False)
class ChannelOfCases:
    """Statistics of a channel over the cases.

    statistics : (n,) by name, NaN for cases without results
    has_extremes : False for a constant channel; otherwise the page lists the extremes if the statistics
        include minimum, time of minimum, maximum and time of maximum
    """

    name: str
    unit: str
    statistics: Mapping[str, FloatArray]
    has_extremes: bool = True


@dataclass(frozen=True, eq=False)
class RainflowSpectrum:
    """Rainflow cycles of a channel over all cases.

    ranges : (b,) class centres, ascending;   counts : (b,) of cycles
    """

    name: str
    unit: str
    ranges: FloatArray
    counts: FloatArray


@dataclass(frozen=True, eq=False)
class SweepPage:
    """Content of the page of a sweep.

    parameters : (n,) numbers or texts by path;   results : (n,) by name, such as the status of the cases
    spectra : of channels;   exponents : S-N exponents, for each of which the shares of damage are plotted
    sections : above the plots;   reports : addresses of pages of single cases, by number
    time : unit of times;   row : name of a row of the table
    """

    title: str
    parameters: Mapping[str, Sequence[object]]
    channels: Sequence[ChannelOfCases]
    results: Mapping[str, Sequence[object] | FloatArray] = field(default_factory=lambda: MappingProxyType({}))
    spectra: Sequence[RainflowSpectrum] = ()
    exponents: Sequence[float] = ()
    sections: Sequence[PageSection] = ()
    reports: Mapping[int, str] = field(default_factory=lambda: MappingProxyType({}))
    time: str = ""
    row: str = "case"

    @property
    def n_cases(self) -> int:
        """Number of cases, n; ModelError for columns of different lengths."""
        lengths = {len(column) for column in (*self.parameters.values(), *self.results.values())}
        lengths |= {len(column) for channel in self.channels for column in channel.statistics.values()}
        if len(lengths) != 1:
            raise ModelError(f"the columns of a page of a sweep have different lengths: {sorted(lengths)}")
        return lengths.pop()


def channels_that_fit(n_cases: int, n_others: int, n_statistics: int) -> int:
    """Largest number of channels, at least one, for which a browser opens the page in seconds.

    n_others : number of columns that are not of channels;   n_statistics : number of statistics per channel
    """
    return max(1, (_NUMBERS // max(n_cases, 1) - n_others) // n_statistics)


@checked_arguments
def write_sweep_page(path: Path | str, page: SweepPage) -> Path:
    """Write the page of a sweep; its content policy forbids all requests, and scripts from elsewhere.

    Raises
    ------
    ModelError          columns of different lengths
    ResultFileError     the file cannot be written
    """
    arrays = PackedArrays()
    n = page.n_cases
    columns = [_Column(page.row, "case", range(n))]
    columns += [_Column(name, "result", column) for name, column in page.results.items()]
    columns += [_Column(name, "parameter", column) for name, column in page.parameters.items()]
    shown: list[dict[str, object]] = []
    for channel in page.channels:
        own = list(_columns(channel, page.time))
        places = {name: len(columns) + i for i, name in enumerate(channel.statistics)}
        columns += own
        if channel.has_extremes and all(name in places for name in _EXTREMES):
            low, low_time, high, high_time = (places[name] for name in _EXTREMES)
            shown.append(
                {
                    "name": channel.name,
                    "unit": channel.unit,
                    "smallest": {"column": low, "instant": low_time},
                    "largest": {"column": high, "instant": high_time},
                }
            )
    head = {
        "time": page.time,
        "sweep": {
            "number": n,
            "rows": f"{page.row}s",
            "columns": [column.plain(arrays) for column in columns],
            "channels": shown,
            "spectra": [
                {
                    "name": each.name,
                    "unit": each.unit,
                    "ranges": arrays.add(each.ranges, "f8"),
                    "counts": arrays.add(each.counts, "f8"),
                }
                for each in page.spectra
            ],
            "exponents": list(page.exponents),
            "reports": {str(case): address for case, address in page.reports.items()},
        },
    }
    return write_text(path, html_text(_ASSETS, page.title, page.sections, head, arrays))


class _Column(NamedTuple):
    """One value per case; a column with texts is written as numbers of its different texts."""

    label: str
    kind: str
    values: Sequence[object] | FloatArray

    def plain(self, arrays: PackedArrays) -> dict[str, object]:
        """The column as JSON values for the script."""
        known: dict[str, object] = {"label": self.label, "kind": self.kind, "words": None}
        values = np.asarray(self.values) if not _are_words(self.values) else None
        if values is None:
            words = list(dict.fromkeys(str(value) for value in self.values))
            numbers = {word: number for number, word in enumerate(words)}
            known["words"] = words
            values = np.array([numbers[str(value)] for value in self.values])
        known["whole"] = values.dtype.kind in "iu"
        return known | {"values": arrays.add(values.astype(np.float64), "f8")}


def _are_words(values: Sequence[object] | FloatArray) -> bool:
    if isinstance(values, np.ndarray) and values.dtype.kind in "iuf":
        return False
    return any(isinstance(value, bool) or not isinstance(value, int | float | np.number) for value in values)


def _columns(channel: ChannelOfCases, time: str) -> Iterator[_Column]:
    for name, values in channel.statistics.items():
        unit = time if name.startswith("time of") else channel.unit
        yield _Column(labelled(f"{channel.name}, {name}", unit), "output", values)
