"""Sobol indices: contributions of parameters to the variance of an output."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import ArrayLike

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.sweeps.case_table import CaseTable, Distribution

__all__ = ["SaltelliDesign", "SobolIndices"]


_RESAMPLES = 200


@dataclass(frozen=True, eq=False)
class SobolIndices:
    """Fractions of the variance of outputs, by parameter.

    parameters : d paths
    first : (d, ...) first-order indices;   total : (d, ...) total indices, with all interactions
    first_interval, total_interval : (2, d, ...) 95 % confidence intervals, by the bootstrap
    """

    parameters: tuple[str, ...]
    first: FloatArray
    total: FloatArray
    first_interval: FloatArray
    total_interval: FloatArray


@dataclass(frozen=True, eq=False)
class SaltelliDesign:
    """Saltelli's design: n (d + 2) cases from which Sobol indices of d parameters are estimated.

    Two samples A and B of n points each come from one scrambled Sobol sequence. Then sample A is repeated for
    each parameter, with the column of this parameter from B.

        design = SaltelliDesign({"load[0].law.amplitude": Uniform(1e3, 5e3), ...}, 256)
        sp.sweep("blade.toml", design.table, "results/sobol")
        tip = sp.read_sweep("results/sobol").statistics.sel(channel="tip.z", statistic="maximum")
        design.indices(tip.values).total

    of : distribution of each parameter, by path;   number : n, a power of two

    Source: Saltelli et al., Computer Physics Communications 181 (2010), 259-270; `scipy.stats.sobol_indices`.
    """

    of: Mapping[str, Distribution]
    number: int
    seed: int = 0

    def __post_init__(self) -> None:
        if self.number < 2 or self.number & (self.number - 1):
            raise ModelError(f"SaltelliDesign: number must be a power of two, 2 or more, got {self.number}")
        if not self.of:
            raise ModelError("SaltelliDesign: give the distribution of at least one parameter")

    @property
    def n_cases(self) -> int:
        """Number of cases, n (d + 2)."""
        return self.number * (len(self.of) + 2)

    @cached_property
    def table(self) -> CaseTable:
        """The table of cases: A, B, then for each parameter A with its column of B."""
        d, n = len(self.of), self.number
        points = scipy.stats.qmc.Sobol(2 * d, rng=self.seed).random(n)
        shares = np.tile(points[:, :d], (d + 2, 1)).reshape(d + 2, n, d)
        shares[1] = points[:, d:]
        for parameter in range(d):
            shares[2 + parameter, :, parameter] = points[:, d + parameter]
        columns = zip(self.of.items(), shares.reshape(-1, d).T, strict=True)
        return CaseTable({path: own.quantiles(column).tolist() for (path, own), column in columns})

    def indices(self, values: ArrayLike) -> SobolIndices:
        """Sobol indices of outputs (n (d + 2), ...) of the cases, in the order of the table.

            S_i = V(E(y | x_i)) / V(y),    S_Ti = E(V(y | x_others)) / V(y)

        Raises ModelError for a wrong number of outputs, and for outputs that are not finite or do not vary.
        """
        outputs = np.asarray(values, dtype=np.float64)
        if outputs.shape[:1] != (self.n_cases,):
            raise ModelError(
                f"Sobol indices: outputs of shape {outputs.shape} for {self.n_cases} cases; give a row for "
                "each case, in the order of the table"
            )
        rows = outputs.reshape(self.n_cases, -1)
        missing = int((~np.isfinite(rows)).any(axis=1).sum())
        if missing:
            raise ModelError(
                f"Sobol indices: {missing} cases have no finite output, and all are needed; run them again "
                "or narrow the distributions"
            )
        if (np.ptp(rows, axis=0) == 0).any():
            raise ModelError(
                "Sobol indices: an output is the same in all cases and has no variance; leave it out"
            )
        d = len(self.of)
        blocks = rows.reshape(d + 2, self.number, -1).transpose(0, 2, 1)
        known = {"f_A": blocks[0], "f_B": blocks[1], "f_AB": blocks[2:]}
        found = scipy.stats.sobol_indices(func=known, n=self.number, rng=self.seed)
        spread = found.bootstrap(confidence_level=0.95, n_resamples=_RESAMPLES)
        intervals = (spread.first_order.confidence_interval, spread.total_order.confidence_interval)

        def shaped(indices: FloatArray) -> FloatArray:
            """Indices (d, ...) from an array (s, d), or (d,) for one output."""
            return np.atleast_2d(indices).T.reshape(d, *outputs.shape[1:])

        return SobolIndices(
            tuple(self.of),
            shaped(found.first_order),
            shaped(found.total_order),
            *(np.stack([shaped(own.low), shaped(own.high)]) for own in intervals),
        )
