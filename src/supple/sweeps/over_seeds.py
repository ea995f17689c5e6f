"""Statistics over seeds: cases that differ only in their realisation form a condition."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.errors import CaseError
from supple.optional_packages import optional_package
from supple.sweeps.case_table import CaseTable
from supple.sweeps.plan import numbered

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["statistics_over_seeds"]


class OverSeeds(NamedTuple):
    """Statistics (k, ...) of a value over the cases of k conditions, without cases where it is missing.

    number : number of cases with a value
    deviation : sample standard deviation, with n - 1; NaN for a single case
    """

    number: IntArray
    mean: FloatArray
    deviation: FloatArray
    minimum: FloatArray
    maximum: FloatArray


def conditions_of(table: CaseTable, seeds: Sequence[str]) -> tuple[IntArray, CaseTable]:
    """Condition (n,) of each case, numbered from 0 in order of appearance, and the table of conditions.

    Cases belong to one condition if all columns but the seeds agree. CaseError for a seed that is no column.
    """
    for name in seeds:
        table.check_has(name)
    others = {path: column for path, column in table.columns.items() if path not in seeds}
    keys = [tuple(map(repr, row)) for row in zip(*others.values(), strict=True)]
    numbers = numbered(keys, len(table))
    first = np.unique(numbers, return_index=True)[1]
    return numbers, CaseTable({path: [column[case] for case in first] for path, column in others.items()})


def over_conditions(values: FloatArray, numbers: IntArray) -> OverSeeds:
    """Statistics over the cases of each condition.

        mean = sum x / n,    deviation = sqrt(sum (x - mean)^2 / (n - 1))

    values : (n, ...), NaN for cases without results;   numbers : (n,) condition of each case
    """
    order = np.argsort(numbers, kind="stable")
    begins = np.flatnonzero(np.diff(numbers[order], prepend=-1))
    known, own = np.isfinite(values[order]), values[order]
    number = np.add.reduceat(known.astype(np.int64), begins)
    mean = _over(np.add.reduceat(np.where(known, own, 0.0), begins), number)
    away = np.where(known, own - mean[numbers[order]], 0.0)
    deviation = np.sqrt(_over(np.add.reduceat(away**2, begins), number - 1))
    return OverSeeds(number, mean, deviation, np.fmin.reduceat(own, begins), np.fmax.reduceat(own, begins))


def _over(sums: FloatArray, number: IntArray) -> FloatArray:
    """Quotients; NaN where the number is not positive."""
    return np.where(number > 0, sums / np.maximum(number, 1), np.nan)


def statistics_over_seeds(dataset: Dataset, seeds: Sequence[str] = ()) -> Dataset:
    """Statistics over the seeds of a sweep as an `xarray.Dataset`: conditions in place of cases.

        ds = sp.read_sweep("results/gusts")
        over = statistics_over_seeds(ds, ["load[1].law.file"])
        over["mean"].sel(channel="joint root.My", statistic="maximum")     # means of the maxima, (condition,)

    Variables are mean, deviation, minimum, maximum and number (condition, channel, statistic). The columns
    that distinguish the conditions are coordinates by their paths. Cases without results are left out.

    seeds : columns whose values are realisations; default: `seeds` of the sweep file

    Raises
    ------
    CaseError               a seed that is no column; no seeds at all
    MissingPackageError     without xarray
    """
    xarray = optional_package("xarray", "a data set", "xarray")
    names = list(seeds) or list(dataset.attrs.get("seeds", ()))
    if not names:
        raise CaseError("statistics over seeds: name the columns whose values are realisations")
    varied = [str(name) for name, own in dataset.coords.items() if own.dims == ("case",) and name != "case"]
    table = CaseTable({name: dataset[name].values.tolist() for name in varied})
    numbers, conditions = conditions_of(table, names)
    found = [
        over_conditions(dataset.statistics.sel(statistic=each).values, numbers)
        for each in dataset.statistic.values
    ]
    dims = ("condition", "channel", "statistic")
    variables = {
        name: (dims, np.stack([getattr(each, name) for each in found], axis=-1)) for name in OverSeeds._fields
    }
    kept = {name: own for name, own in dataset.coords.items() if own.dims in {("channel",), ("statistic",)}}
    coordinates = {path: ("condition", np.array(column)) for path, column in conditions.columns.items()}
    number = {"condition": np.arange(len(found[0].mean))}
    return xarray.Dataset(variables, {**number, **kept, **coordinates}, {"seeds": names})
