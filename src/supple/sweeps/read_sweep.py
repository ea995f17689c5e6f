"""Results of a sweep as a data set, read column by column."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray
from supple.errors import ResultFileError
from supple.optional_packages import optional_package
from supple.storage.sealed_hdf5 import open_sealed
from supple.sweeps.case_table import CaseTable
from supple.sweeps.fatigue_loads import DAMAGE, range_of, summed_spectra
from supple.sweeps.part_file import CHANNEL_KINDS, NUMBERS, WORDS, motion_in, part_path
from supple.sweeps.plan import SweepPlan, read_plan
from supple.sweeps.sweep_shares import SweepShares, sweep_shares

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["SweepColumns", "read_sweep", "write_parquet"]


_MISSING: Mapping[str, Any] = {
    "cause": "not run yet",
    "no_estimate": "",
    "status": -1,
    "steps": 0,
    "iterations": 0,
}
"""Values for cases that have not run, by name of the data set; other data sets have NaN"""


class SweepColumns:
    """Reader of the results of a sweep, one column at a time; values of cases without results are NaN.

    folder : folder of the sweep, in which each share of the cases has one file, its part

    Raises
    ------
    ResultFileError     no sweep in the folder; a damaged part
    """

    def __init__(self, folder: Path | str) -> None:
        self.folder = Path(folder)
        self.plan: SweepPlan = read_plan(self.folder)
        self.shares: SweepShares = sweep_shares(self.folder, self.plan)
        self._cases = {share: self.shares.cases[share] for share in self.shares.whole}
        """Cases of the complete parts; those of repeated runs follow those of the runs they replace"""
        self.runs = np.zeros(self.plan.n_cases, dtype=np.int64)
        """Number of runs of each case, (n,)"""
        for share, cases in self._cases.items():
            self.runs[cases] = self.shares.level[share] + 1

    @property
    def statistics(self) -> tuple[str, ...]:
        """Names of the statistics."""
        return self.plan.output.statistics

    @property
    def table(self) -> CaseTable:
        """The parameters of the cases."""
        return self.plan.table

    def _parts(self) -> Iterator[tuple[NDArray[np.int64], h5py.File]]:
        """The cases of each complete part, and its file."""
        for share, cases in self._cases.items():
            with open_sealed(part_path(self.folder, share), verify=False) as file:
                yield cases, file

    def statistic(
        self, statistic: int | str, channels: NDArray[np.intp] | slice | int = slice(None)
    ) -> FloatArray:
        """Values (n, c) of a statistic, by number or name, for c channels, or (n,) for one; n cases."""
        number = self.statistics.index(statistic) if isinstance(statistic, str) else statistic
        numbers = np.arange(len(self.channels["name"]))[channels]
        found = np.full((self.plan.n_cases, *numbers.shape), np.nan)
        for cases, file in self._parts():
            names, data = file["channels/name"].asstr()[()], file["statistics"]
            if np.array_equal(names, self.channels["name"]):
                found[cases] = data[number, channels].T
            else:
                found[cases] = self._by_name(data[number], list(names), numbers)
        return found

    def _by_name(self, data: FloatArray, names: list[str], numbers: NDArray[np.intp]) -> FloatArray:
        """Columns of the wanted channels from a part, by name; NaN for channels that are not in the part."""
        wanted = np.atleast_1d(self.channels["name"][numbers])
        found = np.full((data.shape[1], len(wanted)), np.nan)
        for place, name in enumerate(wanted):
            if name in names:
                found[:, place] = data[names.index(name)]
        return found if np.ndim(numbers) else found[:, 0]

    def spectra(self) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Rainflow spectrum of all cases, by channel: middle (b,) of each range class, and cycles (b,)."""
        places = {name: number for number, name in enumerate(self.channels["name"])}
        parts = []
        for _, file in self._parts():
            rows, names = file["spectrum"][()], file["channels/name"].asstr()[()]
            rows[:, 0] = [places[names[int(number)]] for number in rows[:, 0]]
            parts.append(rows)
        rows = summed_spectra(parts)
        return {
            name: (range_of(own[:, 1]), own[:, 2])
            for name, number in places.items()
            if len(own := rows[rows[:, 0] == number])
        }

    def lifetime(self) -> tuple[FloatArray, float]:
        """Fatigue statistics (f, c) over the lifetime, and the fraction of the lifetime that the cases cover.

        The statistics are damage-equivalent ranges for the reference number of cycles, and damage at hot
        spots; NaN if a case has no result. Raises ResultFileError if the sweep file has no lifetime.
        """
        fatigue = self.plan.output.fatigue
        if fatigue is None or fatigue.lifetime is None:
            raise ResultFileError(
                f"{self.folder} has no lifetime: give [output.fatigue.lifetime] and run the sweep again"
            )
        durations = self.of_cases("end_time") - self.plan.start_times
        whole = np.isfinite(durations) & (durations > 0)
        life = fatigue.lifetime.of(self.table, np.where(whole, durations, 1.0))
        found = np.full((len(fatigue.statistics), len(self.channels["name"])), np.nan)
        for row, name in enumerate(fatigue.statistics):
            values = self.statistic(name)
            known = np.isfinite(values).all(axis=0) & whole.all()
            if name == DAMAGE:
                found[row, known] = life.damage(values[:, known])
            else:
                cycles = fatigue.reference_frequency * durations
                found[row, known] = life.equivalent_load(
                    values[:, known], fatigue.exponents[row], cycles, fatigue.lifetime.cycles
                )
        return found, life.covered

    def of_cases(self, name: str) -> NDArray[Any]:
        """A number or a text of each case, (n,); `name` is that of the data set in a part."""
        return self.all_of_cases(name)[0][name]

    def all_of_cases(self, *names: str) -> tuple[dict[str, NDArray[Any]], Counter[str]]:
        """Numbers or texts of each case, by name; number of parts with each warning."""
        n = self.plan.n_cases
        kinds = {name: object if name in WORDS else None for name in names}
        found = {name: np.full(n, _MISSING.get(name, np.nan), kind) for name, kind in kinds.items()}
        warned = Counter[str]()
        for cases, file in self._parts():
            warned.update(file["warnings"].asstr()[()])
            for name, own in found.items():
                own[cases] = file[name].asstr()[()] if name in WORDS else file[name][()]
        return found, warned

    def motion(self, case: int) -> dict[str, FloatArray]:
        """Stored motion of a case: arrays by path (`supple.storage.solution_arrays`), and channels (t, c).

        Raises ResultFileError if the motion of the case was not stored.
        """
        found: dict[str, FloatArray] = {}
        for share, cases in self._cases.items():
            if case in cases:
                with open_sealed(part_path(self.folder, share), verify=False) as file:
                    found = motion_in(file, case)
        if not found:
            raise ResultFileError(
                f"{self.folder} has no motion of case {case}: list the case in `keep` of [output], or "
                "simulate it again with swept_case"
            )
        return found

    @cached_property
    def channels(self) -> dict[str, NDArray[Any]]:
        """Name, unit and other descriptions of the channels of all parts, in order of first appearance."""
        rows: dict[str, tuple[str, ...]] = {}
        for _, file in self._parts():
            if not all(name in rows for name in file["channels/name"].asstr()[()]):
                kinds = (file[f"channels/{kind}"].asstr()[()] for kind in CHANNEL_KINDS)
                for row in zip(*kinds, strict=True):
                    rows.setdefault(row[0], row)
        return {
            kind: np.array([row[i] for row in rows.values()], dtype=object)
            for i, kind in enumerate(CHANNEL_KINDS)
        }


def read_sweep(folder: Path | str) -> Dataset:
    """The results of a sweep as an `xarray.Dataset`; statistics are read from the files when used.

        ds = sp.read_sweep("results/speeds")
        tip = ds.statistics.sel(channel="deflection blade.TIP.x", statistic="maximum")

    The variable statistics has the dimensions (case, channel, statistic); unit, quantity, axes and place of
    each channel are coordinates. Variables per case are status (0 ran, 1 failed, 2 killed, -1 not run yet),
    cause (of a failure), no_estimate (why there is no error estimate), seconds, end_time, estimated_error,
    basis_error, allowed_error, runs, steps and iterations. Each parameter of the sweep is a coordinate per
    case, named by its path in the case file. Values of cases without results are NaN. With a lifetime in
    `output.fatigue`, the variable lifetime (fatigue, channel) has the damage-equivalent ranges and the damage
    over the lifetime.

    Raises
    ------
    ResultFileError         no sweep in the folder; a damaged part
    MissingPackageError     without xarray
    """
    xarray = optional_package("xarray", "a data set", "xarray")
    columns = SweepColumns(folder)
    time = {"units": columns.plan.units.time} if columns.plan.units.time else {}
    lazy = xarray.core.indexing.LazilyIndexedArray(_lazy_statistics(columns))
    length = {"units": columns.plan.units.length} if columns.plan.units.length else {}
    about = {
        "status": {"meaning": "0 ran, 1 failed, 2 killed, -1 not run yet"},
        "seconds": {"units": "s", "of": "processor"},
        "end_time": time,
        **dict.fromkeys(("estimated_error", "basis_error", "allowed_error"), length),
        "runs": {"meaning": "number of runs; each repeated run has enriched bases"},
    }
    of_cases, _ = columns.all_of_cases(*dict.fromkeys(("status", *WORDS, *NUMBERS)))
    of_cases["runs"] = columns.runs
    variables: dict[str, Any] = {"statistics": (("case", "channel", "statistic"), lazy)}
    variables |= {name: ("case", values, about.get(name, {})) for name, values in of_cases.items()}
    coordinates: dict[str, Any] = {
        "case": np.arange(columns.plan.n_cases),
        "statistic": list(columns.statistics),
        "channel": columns.channels["name"],
        **{kind: ("channel", columns.channels[kind]) for kind in CHANNEL_KINDS[1:]},
        **{path: ("case", _as_array(column)) for path, column in columns.table.columns.items()},
    }
    title = {"case_file": str(columns.plan.case_file), "missing": int((of_cases["status"] < 0).sum())}
    if columns.plan.output.seeds:
        title["seeds"] = list(columns.plan.output.seeds)
    fatigue = columns.plan.output.fatigue
    if fatigue is not None:
        title["fatigue"] = fatigue.conventions
        if fatigue.lifetime is not None:
            lifetime, covered = columns.lifetime()
            variables["lifetime"] = (("fatigue", "channel"), lifetime, {"covered": covered})
            coordinates["fatigue"] = list(fatigue.statistics)
    return xarray.Dataset(variables, coords=coordinates, attrs=title)


def _as_array(column: Sequence[Any]) -> NDArray[Any]:
    if any(isinstance(value, list | dict) for value in column):
        return np.array([str(value) for value in column], dtype=object)
    return np.array(column) if not isinstance(column[0], str) else np.array(column, dtype=object)


def _lazy_statistics(columns: SweepColumns) -> Any:
    """FloatArray from which xarray reads the statistics that are used."""
    backends = optional_package("xarray.backends", "a data set", "xarray")
    indexing = optional_package("xarray.core.indexing", "a data set", "xarray")

    class Statistics(backends.BackendArray):
        shape = (columns.plan.n_cases, len(columns.channels["name"]), len(columns.statistics))
        dtype = np.dtype(np.float64)

        def __getitem__(self, key: Any) -> FloatArray:
            outer = indexing.IndexingSupport.OUTER
            return indexing.explicit_indexing_adapter(key, self.shape, outer, self._read)

        def _read(self, key: tuple[Any, ...]) -> FloatArray:
            cases, channels, statistics = key
            numbers = np.arange(len(columns.statistics))[statistics]
            if np.ndim(numbers) == 0:
                return columns.statistic(int(numbers), channels)[cases]
            found = [columns.statistic(int(number), channels)[cases] for number in numbers]
            return np.stack(found, axis=-1)

    return Statistics()


def write_parquet(dataset: Dataset, path: Path | str) -> None:
    """Write the data set of a sweep as a Parquet file, with a row per case.

    Each parameter, each variable per case, and each statistic of each channel has a column.
    Raises MissingPackageError if pyarrow is not installed.
    """
    pyarrow = optional_package("pyarrow", "a Parquet file", "parquet")
    parquet = optional_package("pyarrow.parquet", "a Parquet file", "parquet")
    by_case = [*dataset.coords, *(name for name in dataset.data_vars if dataset[name].dims == ("case",))]
    columns = {name: dataset[name].values for name in by_case if dataset[name].dims == ("case",)}
    for statistic in dataset.statistic.values:
        values = dataset.statistics.sel(statistic=statistic).values
        columns |= {
            f"{name} {statistic}": own for name, own in zip(dataset.channel.values, values.T, strict=True)
        }
    parquet.write_table(pyarrow.table(columns), Path(path))
