"""Frames, strains and bases that the benchmarks of [Wu2019] compare, by their names in the reports.

Bases have the default stiffness tensors or those of published work. A basis without the necessary derivatives
may fail to converge; its run then ends early.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from supple.body import FlexibleBody, Frame, MeanAxisFrame, NodalFixedFrame, RayleighDamping
from supple.errors import LockingWarning
from supple.fem import GREEN_LAGRANGE, VON_KARMAN, ShellKinematics
from supple.integrate import Run, Solution
from supple.machine import System
from supple.reduction import (
    CondensedQuartic,
    CraigBampton,
    DerivativeChoice,
    LinearBasisRecipe,
    NoLoads,
    PlainQuartic,
    QuarticChoice,
    ReducedBody,
    Rubin,
    reduce,
)
from supple.simulation import simulate
from supple_benchmarks.progress import Progress

__all__ = [
    "FRAMES",
    "KINEMATICS",
    "ROOT",
    "STRAINS",
    "FixedBasis",
    "linear_basis",
    "reduce_to_compare",
    "turned_axes",
    "until_early_end",
]

ROOT = "root"
FRAMES: dict[str, Frame] = {"nodal-fixed": NodalFixedFrame(ROOT), "mean-axis": MeanAxisFrame()}
KINEMATICS: dict[str, ShellKinematics] = {"green-lagrange": GREEN_LAGRANGE, "von-karman": VON_KARMAN}
STRAINS = {"green-lagrange": "GL", "von-karman": "vK"}
"""Names of the kinematics in tables."""
TENSORS: dict[str, QuarticChoice] = {"condensed": CondensedQuartic(), "plain": PlainQuartic()}
"""Condensed: the default of `reduce`; plain: a body that moves only in its basis, as in [Wu2019]."""


@dataclass(frozen=True, eq=False)
class FixedBasis:
    """A basis of fixed size, and its names and numbers in the report.

    frame, tensors : keys of `FRAMES` and `TENSORS`
    """

    frame: str
    recipe: LinearBasisRecipe
    name: str
    derivatives: DerivativeChoice
    derivatives_name: str
    tensors: str
    n_linear: int
    n_added: int

    @property
    def columns(self) -> str:
        """The columns as text."""
        if not self.n_added:
            return f"{self.n_linear}"
        plain = ", plain" if self.tensors == "plain" else ""
        return f"{self.n_linear}+{self.n_added} {self.derivatives_name}{plain}"

    @property
    def label(self) -> str:
        """Name and columns."""
        return f"{self.name} {self.columns}"


def linear_basis(frame: str, n_columns: int) -> LinearBasisRecipe:
    """The basis of [Wu2019] in a frame: Craig-Bampton modes if it is fixed at the root, else Rubin's."""
    return CraigBampton(n_modes=n_columns) if frame == "nodal-fixed" else Rubin(n_columns=n_columns)


def reduce_to_compare(
    body: FlexibleBody, basis: FixedBasis, damping: RayleighDamping | None = None
) -> tuple[ReducedBody, float]:
    """The reduced body, and the time of the reduction in seconds.

    There is no LockingWarning, because locking is one of the compared properties.
    """
    began = perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LockingWarning)
        reduced = reduce(
            body,
            FRAMES[basis.frame],
            basis.recipe,
            derivatives=basis.derivatives,
            damping=damping,
            quartic=TENSORS[basis.tensors],
            loads=NoLoads,
        )
    return reduced, perf_counter() - began


def until_early_end(system: System, run: Run, *, progress: Progress) -> tuple[Solution, float | None]:
    """The motion, and the last time of a run that ended early; None for a complete run."""
    solution = simulate(system, run, progress=progress, check=False)
    progress(1.0)
    return solution, None if solution.stopped is None else float(solution.times[-1])


def turned_axes(axis: ArrayLike, angle: ArrayLike) -> NDArray[np.float64]:
    """Axes (t, 3, 3), as columns, turned about a unit vector by angles (t,)."""
    return Rotation.from_rotvec(np.multiply.outer(np.asarray(angle), np.asarray(axis))).as_matrix()
