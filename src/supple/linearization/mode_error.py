"""Basis errors of reduced bodies in the modes of a machine, by comparison with all coordinates."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy  # its parts are imported when first used

from supple.errors import BasisWarning
from supple.linearization.linear_machine import FullMachine, likeness
from supple.simulation.equilibrium import LARGEST_ERROR, REMEDY

MORE = 4
"""Number of modes of the full machine that are computed for matching, in addition to those to be matched."""
UNLIKE = 0.5
"""MAC below which modes of the reduced and the full machine match only if their eigenvalues differ by less
than `LARGEST_ERROR`."""
STILL = 1e-6
"""Smallest reference value of relative differences, as a fraction of the largest |eigenvalue|: slower motions
count as rigid."""


@dataclass(frozen=True, eq=False)
class ModeError:
    """Modes of a reduced machine, compared with the modes in all coordinates.

    eigenvalues : complex (k,)      eigenvalue of each mode with all coordinates; NaN without a matching mode
    relative : (k,)                 |s - s_full| / |s_full|; infinite without a matching mode
    missed : complex (m,)           eigenvalues of the full machine below that of the fastest mode, without a
        matching mode of the reduced machine
    fields : (n, j), by body        deformation of the full machine's modes, matched and missed
    """

    eigenvalues: np.ndarray
    relative: np.ndarray
    missed: np.ndarray
    fields: Mapping[str, np.ndarray]

    def warn(self, values: np.ndarray) -> None:
        """BasisWarning of modes that are off by 1 % or more, and of missing modes."""
        messages = [
            f"mode {number + 1} is off by {100 * self.relative[number]:.2g} %"
            if np.isfinite(self.relative[number])
            else f"mode {number + 1} is not a mode of the full machine"
            for number in np.flatnonzero(self.relative >= LARGEST_ERROR)
        ]
        if len(self.missed):
            rates = ", ".join(f"{abs(value):.4g}" for value in self.missed)
            limit = abs(values).max()
            messages.append(f"modes at {rates} rad per unit of time, below {limit:.4g}, are missing")
        if messages:
            message = f"the bases of the bodies: {'; '.join(messages)}. {REMEDY}"
            warnings.warn(message, BasisWarning, stacklevel=4)


def mode_error(
    full: FullMachine,
    values: np.ndarray,
    shapes: np.ndarray,
    exact: np.ndarray,
    motions: np.ndarray,
) -> ModeError:
    """Errors of the slowest modes, by comparison with those of the full machine.

    values, shapes : eigenvalues (k,) and shapes (n, k) of the reduced machine
    exact, motions : eigenvalues and shapes of the full one, with `MORE` modes, or all of a small machine
    Modes are matched by the highest MAC; among similar shapes, by the nearest frequency.
    """
    alike = likeness(full.expansion @ shapes, motions, full.machine.equations.mass)
    largest = max(float(abs(exact).max(initial=0.0)), 1e-300)
    apart = abs(values[:, None] - exact) / (abs(values)[:, None] + abs(exact) + STILL * largest)
    rows, columns = scipy.optimize.linear_sum_assignment(apart - alike)
    found = np.full(len(values), np.nan, dtype=complex)
    found[rows] = exact[columns]
    relative = np.full(len(values), np.inf)
    relative[rows] = abs(values[rows] - exact[columns]) / np.maximum(abs(exact[columns]), STILL * largest)
    # If one shape belongs to several modes, only their frequencies separate them.
    near = relative < LARGEST_ERROR
    unlike = np.ones(len(values), dtype=bool)
    unlike[rows] = alike[rows, columns] < UNLIKE
    lost = unlike & ~near
    found[lost], relative[lost] = np.nan, np.inf
    taken = np.zeros(len(exact), dtype=bool)
    taken[columns[~lost[rows]]] = True
    slow = abs(exact) <= abs(values).max(initial=0.0) * (1 - LARGEST_ERROR)
    missed = np.flatnonzero(~taken & slow)
    wanted = np.concatenate([columns[~lost[rows]], missed])
    return ModeError(
        eigenvalues=found,
        relative=relative,
        missed=exact[missed],
        fields={
            name: np.hstack([motions[part][:, wanted].real, motions[part][:, wanted].imag])
            for name, part in full.bodies.items()
        },
    )
