"""Report of a reduction: columns kept and dropped, cost, and locking."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from supple.algebra import ReadOnlyArrays
from supple.arrays import FloatArray
from supple.reduction.eigenvalues.eigenvalue_certificate import EigenvalueCertificate

__all__ = ["Locking", "ReductionReport"]

ROTATION = 0.1
"""Largest rotation, rad, of the softest response in linear theory, relative to the fixed interface."""


@dataclass(frozen=True, eq=False)
class Locking(ReadOnlyArrays):
    """Relative deficit of the static response of a reduced body to k loads, see `locking`.

        1 - f.gamma / f.gamma_free,   f : load,   gamma : static response,
        gamma_free : static response with all motion outside the columns included

    loads : names of the loads; all have the energy at which the softest response rotates by 0.1 rad
    plain : (k,)        deficit with the tensors of the columns alone; nan without equilibrium (buckling)
    remaining : (k,)    deficit with the tensors of the reduced body
    """

    loads: tuple[str, ...]
    plain: FloatArray
    remaining: FloatArray

    @property
    def largest_plain(self) -> float:
        """The largest deficit with the columns alone, at least zero; nan values are ignored."""
        return _largest(self.plain)

    @property
    def largest_remaining(self) -> float:
        """The largest deficit of the reduced body, at least zero; nan values are ignored."""
        return _largest(self.remaining)

    def __str__(self) -> str:
        if not self.loads:
            return "not known: no load bends the body"
        worst = self.loads[int(np.argmax(np.nan_to_num(self.plain, nan=-1.0)))]
        return (
            f"{in_percent(self.largest_remaining)} of the response at {ROTATION:g} rad; without condensation "
            f"{in_percent(self.largest_plain)}, under {worst}"
        )


@dataclass(frozen=True, eq=False)
class ReductionReport(ReadOnlyArrays):
    """Origin of a basis: columns kept, columns dropped, and cost.

    linear : labels of the linear columns (modes and static columns) that span the linear subspace
    derivatives : labels of the columns from modal derivatives, added for the quadratic motion
    corrections : labels of the columns that `enrich` added
    dropped : labels of the columns left out because other columns, or the frame, contain their motion
    singular_values_kept, singular_values_dropped : of the weighted derivatives, relative to the first
        (both empty unless the derivatives were compressed)
    seconds : wall time of each offline step, s
    certificate : proven accuracy of the body's eigenvalues; None without an ErrorControlled basis
    locking : deficit due to missing stiff motion, without and with condensation; None if not computed, as for
        a linear body
    """

    linear: tuple[str, ...]
    derivatives: tuple[str, ...] = ()
    corrections: tuple[str, ...] = ()
    dropped: tuple[str, ...] = ()
    singular_values_kept: FloatArray = field(default_factory=lambda: np.empty(0))
    singular_values_dropped: FloatArray = field(default_factory=lambda: np.empty(0))
    seconds: Mapping[str, float] = field(default_factory=dict)
    certificate: EigenvalueCertificate | None = None
    locking: Locking | None = None

    def __str__(self) -> str:
        counts = [f"{len(self.linear)} linear columns", f"{len(self.derivatives)} derivatives"]
        counts += [f"{len(self.corrections)} corrections"] if self.corrections else []
        left_out = f"; left out: {', '.join(self.dropped)}" if self.dropped else ""
        return ", ".join(counts) + left_out


def _largest(shares: FloatArray) -> float:
    return float(np.max(np.nan_to_num(shares, nan=0.0), initial=0.0))


def in_percent(share: float) -> str:
    """A share as text in per cent with two digits, for tables and warnings; 'none' below 1e-4."""
    return f"{100 * share:.2g} %" if share >= 1e-4 else "none"


@contextmanager
def timed(seconds: dict[str, float], step: str) -> Iterator[None]:
    """Record the wall time of the block in `seconds[step]`."""
    start = perf_counter()
    yield
    seconds[step] = perf_counter() - start
