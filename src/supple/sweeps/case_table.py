"""The table of a sweep: a column of values for each path that varies, a row for each case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from scipy.stats import qmc

from supple.errors import CaseError
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

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CaseTable:
    """A case for each row; columns by path, such as `joint.shaft.law.speed`.

    Raises CaseError for columns of different lengths.
    """

    columns: Mapping[str, Sequence[Any]]

    def __post_init__(self) -> None:
        lengths = {path: len(column) for path, column in self.columns.items()}
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{path} {length}" for path, length in lengths.items())
            raise CaseError(f"the columns of a table of cases have different lengths: {listed}")
        object.__setattr__(self, "columns", {path: tuple(own) for path, own in self.columns.items()})

    def __len__(self) -> int:
        return next((len(column) for column in self.columns.values()), 0)

    def row(self, case: int) -> dict[str, Any]:
        """The values of a case, by path."""
        return {path: column[case] for path, column in self.columns.items()}


class Distribution(Protocol):
    """What a sampled parameter is drawn from."""

    def quantiles(self, shares: Array, /) -> Array:
        """Values below which these shares of all draws lie."""
        ...


@dataclass(frozen=True)
class Uniform:
    """Evenly between two values."""

    low: float
    high: float

    def quantiles(self, shares: Array) -> Array:
        """At x = low + (high - low) p."""
        return self.low + (self.high - self.low) * shares


@dataclass(frozen=True)
class Normal:
    """Of a mean and a standard deviation."""

    mean: float
    deviation: float

    def quantiles(self, shares: Array) -> Array:
        """At x = mean + deviation Phi^-1(p)."""
        return stats.norm.ppf(shares, self.mean, self.deviation)


class Sampling(Protocol):
    """How points of a unit cube are drawn."""

    def points(self, dimensions: int, /) -> Array:
        """(number, dimensions), each between 0 and 1."""
        ...


@dataclass(frozen=True)
class LatinHypercube:
    """One point in each of `number` slices of every parameter (`scipy.stats.qmc.LatinHypercube`)."""

    number: int
    seed: int = 0

    def points(self, dimensions: int) -> Array:
        """(number, dimensions)."""
        return qmc.LatinHypercube(dimensions, rng=self.seed).random(self.number)


@dataclass(frozen=True)
class Sobol:
    """Sobol's sequence, scrambled (`scipy.stats.qmc.Sobol`); balanced where the number is a power of two."""

    number: int
    seed: int = 0

    def points(self, dimensions: int) -> Array:
        """(number, dimensions)."""
        if self.number & (self.number - 1):
            raise CaseError(
                f"Sobol's sequence is balanced for powers of two: give number = "
                f"{2 ** (self.number.bit_length() - 1)} or {2 ** self.number.bit_length()}, not {self.number}"
            )
        return qmc.Sobol(dimensions, rng=self.seed).random(self.number)


def full_factorial(values: Mapping[str, Sequence[Any]]) -> CaseTable:
    """Every combination of the values; the last path varies fastest."""
    rows = list(product(*values.values()))
    return CaseTable({path: [row[i] for row in rows] for i, path in enumerate(values)})


def sampled(of: Mapping[str, Distribution], sampling: Sampling) -> CaseTable:
    """Points drawn together of the distributions of some parameters."""
    points = sampling.points(len(of))
    columns = zip(of.items(), points.T, strict=True)
    return CaseTable({path: own.quantiles(column).tolist() for (path, own), column in columns})


def crossed(*tables: CaseTable) -> CaseTable:
    """Every row of the first with every row of the second, and so on; the last varies fastest.

    Raises CaseError where two tables vary the same path.
    """
    columns: dict[str, Sequence[Any]] = {}
    for table in tables:
        if twice := columns.keys() & table.columns.keys():
            raise CaseError(f"{', '.join(sorted(twice))} is varied twice: once is enough")
        n, m = max(len(next(iter(columns.values()), ())), 1), len(table)
        repeated = {path: [value for value in own for _ in range(m)] for path, own in columns.items()}
        columns = repeated | {path: [*own] * n for path, own in table.columns.items()}
    return CaseTable(columns)
