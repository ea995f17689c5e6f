"""Condensed line from a section table, without mesh or elements."""

from __future__ import annotations

import numpy as np
from scipy import linalg

from supple.arguments import checked_arguments
from supple.arrays import FloatArray
from supple.body.rigid_motion import nodal_rigid_modes
from supple.errors import ModelError
from supple.importers import SectionTable
from supple.methods.intrinsic.condensed_line import CondensedLine, condensed_line
from supple.methods.intrinsic.lumped_inertia import arm_terms, with_shorter_arms

__all__ = ["section_line"]


POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)


@checked_arguments
def section_line(name: str, table: SectionTable, n_stations: int) -> CondensedLine:
    """Line of a beam given by its sections, on stations at equal distances along its curve.

    Between two stations, a and b, the flexibility follows from equilibrium with the force W at the middle of
    the segment. It is exact for sections that vary along a curve:

        C = integral of T^T K^-1 T ds,    T W = the force W at s, along the axes of the section
        K_ab = B^T C^-1 B,                B u = motion of b relative to a, both moved to the middle

    The inertia of each piece of the curve is attached to the two nearest stations, with linear weights
    between them and shorter arms (`with_shorter_arms`): mass, first and second moments are exact.

    Parameters
    ----------
    table : SectionTable    sections from the root to the tip
    n_stations : int        including both ends, at least 2

    Raises
    ------
    ModelError      fewer than two stations; and as `condensed_line`
    """
    if n_stations < 2:
        raise ModelError(f"line '{name}': it needs at least two stations, its ends, not {n_stations}")
    stations = np.linspace(0, table.lengths[-1], n_stations)
    points = table.at(stations)[0]
    breaks = np.union1d(stations, table.lengths)
    breaks = breaks[np.append(True, np.diff(breaks) > 1e-12 * breaks[-1])]
    half = 0.5 * np.diff(breaks)
    s = (0.5 * (breaks[1:] + breaks[:-1])[:, None] + half[:, None] * POINTS).ravel()
    ds = (half[:, None] * WEIGHTS).ravel()
    segment = np.clip(np.searchsorted(stations, s) - 1, 0, n_stations - 2)
    places, axes, stiffness, inertia = table.at(s)
    turned = np.zeros((len(s), 6, 6))
    turned[:, :3, :3] = turned[:, 3:, 3:] = axes.swapaxes(1, 2)

    middles = 0.5 * (points[1:] + points[:-1])
    T = turned @ _moved(middles[segment] - places).swapaxes(1, 2)  # of forces: the transpose
    C = np.zeros((n_stations - 1, 6, 6))
    np.add.at(C, segment, ds[:, None, None] * (T.swapaxes(1, 2) @ np.linalg.solve(stiffness, T)))
    B = np.concatenate([-_moved(middles - points[:-1]), _moved(middles - points[1:])], axis=2)
    K = np.zeros((6 * n_stations, 6 * n_stations))
    for k, own in enumerate(B.swapaxes(1, 2) @ np.linalg.solve(C, B)):
        K[6 * k : 6 * k + 12, 6 * k : 6 * k + 12] += 0.5 * (own + own.T)

    share = (s - stations[segment]) / stations[1]
    feet = (1 - share)[:, None] * points[segment] + share[:, None] * points[segment + 1]
    rigid, change = np.zeros((n_stations, 6, 6)), np.zeros((n_stations, 6, 6))
    for end, weight in enumerate((1 - share, share)):
        X = turned @ _moved(places - points[segment + end])
        own = (weight * ds)[:, None, None] * (X.swapaxes(1, 2) @ inertia @ X)
        np.add.at(rigid, segment + end, own)
        np.add.at(change, segment + end, arm_terms(own, feet - points[segment + end]))
    mass = with_shorter_arms(rigid, change, float(stations[1]))
    return condensed_line(name, points, K, linalg.block_diag(*mass))


def _moved(arms: FloatArray) -> FloatArray:
    """Map (n, 6, 6) from the motion of reference points to that of points at arms (n, 3) from them."""
    return nodal_rigid_modes(arms, 6).reshape(-1, 6, 6)
