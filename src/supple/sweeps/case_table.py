"""The table of a sweep: a column of values for each varied path, a row for each case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Protocol

import numpy as np
import scipy

from supple.arguments import check_fields, given
from supple.arrays import FloatArray
from supple.errors import CaseError, did_you_mean
from supple.fatigue import Weibull

__all__ = [
    "CaseTable",
    "Distribution",
    "LatinHypercube",
    "Normal",
    "Sampling",
    "Sobol",
    "Uniform",
    "Weibull",
    "crossed",
    "full_factorial",
    "sampled",
]


@dataclass(frozen=True)
class CaseTable:
    """The table of a sweep, with a case in each row; columns by path, such as `joint.shaft.law.speed`.

    Columns may be arrays. Raises CaseError for columns of different lengths, a column that is no list, and
    values that a case file cannot have.
    """

    columns: Mapping[str, Sequence[Any]]

    def __post_init__(self) -> None:
        for path, column in self.columns.items():
            if isinstance(column, str | Mapping) or not hasattr(column, "__len__"):
                raise CaseError(f"{path}: give a list with one value per case, not {given(column)}")
        lengths = {path: len(column) for path, column in self.columns.items()}
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{path} {length}" for path, length in lengths.items())
            raise CaseError(
                f"the columns of a table of cases have different lengths: {listed}; give one value per case"
            )
        plain = {path: tuple(_plain(path, value) for value in own) for path, own in self.columns.items()}
        object.__setattr__(self, "columns", plain)

    def __len__(self) -> int:
        return next((len(column) for column in self.columns.values()), 0)

    def check_has(self, name: str, what: str = "") -> None:
        """CaseError for a name that is no column, after the words `what`."""
        if name not in self.columns:
            raise CaseError(f"{what}no column is named {name!r}{did_you_mean(name, self.columns)}")

    def row(self, case: int) -> dict[str, Any]:
        """The values of a case, by path."""
        return {path: column[case] for path, column in self.columns.items()}


def _plain(path: str, value: Any) -> Any:
    """A value as in a case file; those of NumPy as numbers, texts and lists of Python."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(path, each) for each in value]
    if isinstance(value, Mapping):
        return {key: _plain(path, each) for key, each in value.items()}
    if value is None or isinstance(value, str | int | float):
        return value
    raise CaseError(f"{path}: a case file has numbers, texts, lists and tables, not {given(value)}")


class Distribution(Protocol):
    """Probability distribution of a sampled parameter."""

    def quantiles(self, shares: FloatArray, /) -> FloatArray:
        """Values (n,) at cumulative probabilities (n,)."""
        ...


@dataclass(frozen=True)
class Uniform:
    """Uniform distribution between two values; raises CaseError unless both are finite."""

    low: float
    high: float

    def __post_init__(self) -> None:
        check_fields(self)
        if not np.isfinite([self.low, self.high]).all():
            raise CaseError(f"Uniform: low and high must be finite, got {self.low} and {self.high}")

    def quantiles(self, shares: FloatArray) -> FloatArray:
        """Values x = low + (high - low) p at probabilities p."""
        return self.low + (self.high - self.low) * shares


@dataclass(frozen=True)
class Normal:
    """Normal distribution with a mean and a standard deviation.

    Raises CaseError unless both are finite and the deviation is positive.
    """

    mean: float
    deviation: float

    def __post_init__(self) -> None:
        check_fields(self)
        if not (np.isfinite([self.mean, self.deviation]).all() and self.deviation > 0):
            raise CaseError(
                f"Normal: mean and deviation must be finite, and the deviation positive, got {self.mean} and "
                f"{self.deviation}"
            )

    def quantiles(self, shares: FloatArray) -> FloatArray:
        """Values x = mean + deviation Phi^-1(p) at probabilities p."""
        return scipy.stats.norm.ppf(shares, self.mean, self.deviation)


class Sampling(Protocol):
    """Sampling of points in the unit cube."""

    def points(self, dimensions: int, /) -> FloatArray:
        """Points (number, dimensions), with coordinates between 0 and 1."""
        ...


@dataclass(frozen=True)
class _Numbered:
    """Number of points, and seed of their random numbers."""

    number: int
    seed: int = 0

    def __post_init__(self) -> None:
        check_fields(self)
        if self.number < 1:
            raise CaseError(f"{type(self).__name__}: number must be at least 1, got {self.number}")


class LatinHypercube(_Numbered):
    """Latin hypercube: one point in each of `number` intervals of every parameter (`scipy.stats.qmc`).

    Raises CaseError for a number below one.
    """

    def points(self, dimensions: int) -> FloatArray:
        """Points (number, dimensions)."""
        return scipy.stats.qmc.LatinHypercube(dimensions, rng=self.seed).random(self.number)


class Sobol(_Numbered):
    """Scrambled Sobol sequence (`scipy.stats.qmc.Sobol`) of 2^m points, for which it is balanced.

    Raises CaseError for a number below one.
    """

    def points(self, dimensions: int) -> FloatArray:
        """Points (number, dimensions); CaseError for a number that is no power of two."""
        if self.number & (self.number - 1):
            raise CaseError(
                f"Sobol's sequence is balanced for powers of two: give number = "
                f"{2 ** (self.number.bit_length() - 1)} or {2 ** self.number.bit_length()}, not {self.number}"
            )
        return scipy.stats.qmc.Sobol(dimensions, rng=self.seed).random(self.number)


def full_factorial(values: Mapping[str, Sequence[Any]]) -> CaseTable:
    """The table of all combinations of the values; the last path varies fastest."""
    rows = list(product(*values.values()))
    return CaseTable({path: [row[i] for row in rows] for i, path in enumerate(values)})


def sampled(of: Mapping[str, Distribution], sampling: Sampling) -> CaseTable:
    """The table of sampled cases.

    of : distribution of each parameter, by its path;   sampling : design of the points
    """
    points = sampling.points(len(of))
    columns = zip(of.items(), points.T, strict=True)
    return CaseTable({path: own.quantiles(column).tolist() for (path, own), column in columns})


def crossed(*tables: CaseTable) -> CaseTable:
    """The table of all combinations of the rows of some tables; the last table varies fastest.

    Raises CaseError if two tables vary the same path.
    """
    columns: dict[str, Sequence[Any]] = {}
    for table in tables:
        if twice := columns.keys() & table.columns.keys():
            raise CaseError(f"{', '.join(sorted(twice))} is varied twice: keep one of the columns")
        n, m = max(len(next(iter(columns.values()), ())), 1), len(table)
        repeated = {path: [value for value in own for _ in range(m)] for path, own in columns.items()}
        columns = repeated | {path: [*own] * n for path, own in table.columns.items()}
    return CaseTable(columns)
