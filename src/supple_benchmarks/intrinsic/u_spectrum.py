"""Stiffness pattern and elastic eigenvalues of the U, as in figures 12 and 13 of [Wang2015]."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from supple.body import FlexibleBody
from supple.methods.intrinsic import CondensedLine, IntrinsicBody
from supple_benchmarks.table import Row

__all__ = ["eigenvalue_differences", "stiffness_pattern"]

N_EIGENVALUES = 40
N_RIGID = 6
ZERO = 1e-10
"""Ratio of an entry to the largest entry; entries up to it are round-off."""


def eigenvalue_differences(
    solid: FlexibleBody, bodies: Mapping[int, IntrinsicBody], beams: IntrinsicBody
) -> Row:
    """Relative differences of the elastic eigenvalues of the free U; every set is in ascending order.

    bodies : number of stations -> condensed body, the largest number last
    beams : beam elements between the stations of the last condensed body

    Returns
    -------
    solid : lowest elastic eigenvalues of the solid elements, rad^2/s^2
    stations : number of stations -> eigenvalues of the condensed body / those of the solid - 1
    beam_elements : eigenvalues of the beam elements / those of the solid - 1
    beside_beam_elements : eigenvalues of the last condensed body / those of the beam elements - 1, as in the
        paper
    """
    solid_ones = solid.lowest_modes(N_EIGENVALUES + N_RIGID).values[N_RIGID:]
    own = {str(n): _elastic(body) for n, body in bodies.items()}
    of_beams = _elastic(beams)
    last = list(own.values())[-1]
    return {
        "solid": _digits(solid_ones),
        "stations": {n: _difference(values, solid_ones) for n, values in own.items()},
        "beam_elements": _difference(of_beams, solid_ones),
        "beside_beam_elements": _difference(last, of_beams),
    }


def stiffness_pattern(line: CondensedLine) -> list[list[float | None]]:
    """Log10 of the largest stiffness entry of each pair of stations, over the largest entry of all.

    None for entries that are round-off. Rotations are scaled by the mean length of a segment, so that all
    entries have the same unit.
    """
    scale = np.tile(np.repeat([1.0, 1.0 / line.tree.lengths.mean()], 3), line.n)
    scaled = np.abs(line.stiffness * np.outer(scale, scale)).reshape(line.n, 6, line.n, 6)
    largest = scaled.max(axis=(1, 3)) / scaled.max()
    return [[round(float(np.log10(x)), 2) if x > ZERO else None for x in row] for row in largest]


def _elastic(body: IntrinsicBody) -> np.ndarray:
    return body.modes.omega[N_RIGID : N_RIGID + N_EIGENVALUES] ** 2


def _difference(values: np.ndarray, others: np.ndarray) -> list[float]:
    n = min(len(values), len(others))
    return _digits(values[:n] / others[:n] - 1)


def _digits(values: np.ndarray) -> list[float]:
    return [float(f"{value:.6g}") for value in values]
