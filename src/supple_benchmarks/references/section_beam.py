"""A clamped beam of 6 x 6 sections, by integration of its equations: linear, or exact for a straight beam."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq, root
from scipy.spatial.transform import Rotation

__all__ = ["SectionAt", "bent_tip", "clamped_frequencies", "clamped_rest"]

Array = NDArray[np.float64]


class SectionAt(NamedTuple):
    """A section at a length s along the curve.

    axes : (3, 3)       unit vectors x, y, z as columns, z the tangent
    stiffness, inertia : (6, 6)     along these axes, as of `SectionTable`
    """

    axes: Array
    stiffness: Array
    inertia: Array


Beam = Callable[[float], SectionAt]


def clamped_rest(beam: Beam, steps: ArrayLike, gravity: ArrayLike, tip: ArrayLike = (0.0,) * 6) -> Array:
    """Displacement and rotation (6,) of the tip, then force and moment (6,) at the root, linear.

    steps : lengths along the curve, from 0 to the tip, between which the equations are integrated
    gravity : (3,)      acceleration of the weight
    tip : (6,)          force and moment on the tip
    """
    elastic, inert = _rates(beam, np.asarray(steps))
    load = np.zeros((*elastic.shape[:2], 13, 13))
    load[..., :12, :12] = elastic
    load[..., :12, 12] = inert[..., :3] @ np.asarray(gravity, dtype=float)
    whole = _transfer(load, np.diff(steps))
    root = np.linalg.solve(whole[6:12, 6:12], np.asarray(tip) - whole[6:12, 12])
    return np.concatenate([whole[:6, 6:12] @ root + whole[:6, 12], root], dtype=np.float64)


def clamped_frequencies(beam: Beam, steps: ArrayLike, grid: ArrayLike) -> Array:
    """Angular frequencies within a grid of frequencies: zeros of the tip force of the clamped beam."""
    elastic, inert = _rates(beam, np.asarray(steps))

    def determinant(omega: float) -> float:
        transfer = _transfer(elastic + omega**2 * inert, np.diff(steps))
        return float(np.linalg.det(transfer[6:, 6:]))

    grid = np.asarray(grid)
    values = [determinant(omega) for omega in grid]
    turns = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
    return np.array([float(brentq(determinant, grid[k], grid[k + 1], rtol=1e-9)) for k in turns])


def bent_tip(stiffness: Array, length: float, force: ArrayLike) -> Array:
    """Displacement and rotation vector (6,) of the tip of a straight uniform beam along z, for any bending.

    The unknown is the rotation of the tip under a dead force F, integrated from the tip to the clamp:

        R' = R kappa~,  d' = -R (gamma + e_z),  K (gamma, kappa) = R^T (F, d x F),

    with d from the section to the tip.
    """
    force = np.asarray(force, dtype=float)

    def rates(_s: float, y: Array) -> Array:
        turn, d = y[:9].reshape(3, 3), y[9:]
        strain = np.linalg.solve(stiffness, np.concatenate([turn.T @ force, turn.T @ np.cross(d, force)]))
        bend = turn @ np.cross(strain[3:], np.eye(3)).T
        return np.concatenate([bend.ravel(), -turn @ (strain[:3] + np.eye(3)[2])])

    def clamp(tip: Array) -> Array:
        start = np.append(Rotation.from_rotvec(tip).as_matrix(), np.zeros(3))
        return solve_ivp(rates, (length, 0.0), start, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]

    found = root(lambda tip: Rotation.from_matrix(clamp(tip)[:9].reshape(3, 3)).as_rotvec(), np.zeros(3))
    return np.concatenate([clamp(found.x)[9:] - [0, 0, length], found.x])


def _rates(beam: Beam, steps: Array) -> tuple[Array, Array]:
    """A and B (n, 2, 12, 12) of y' = (A + w^2 B) y, y = (u, theta, F, M), at two Gauss points of each step.

    u' = theta x t + gamma,  theta' = kappa,  F' = -w^2 p,  M' = F x t - w^2 l,  (p, l) = M (u, theta)
    """
    middle, half = 0.5 * (steps[1:] + steps[:-1]), 0.5 * np.diff(steps)
    gauss = np.column_stack([middle - half / np.sqrt(3), middle + half / np.sqrt(3)])
    elastic, inert = (np.zeros((*gauss.shape, 12, 12)) for _ in range(2))
    for at in np.ndindex(gauss.shape):
        axes, stiffness, inertia = beam(float(gauss[at]))
        turn = np.kron(np.eye(2), axes)
        across = np.cross(np.eye(3), axes[:, 2]).T
        elastic[at][:6, 6:] = turn @ np.linalg.solve(stiffness, turn.T)
        elastic[at][:3, 3:6] = elastic[at][9:, 6:9] = across
        inert[at][6:, :6] = -turn @ inertia @ turn.T
    return elastic, inert


def _transfer(rates: Array, steps: Array) -> Array:
    """State at the tip from that at the root: Magnus' method of fourth order."""
    h, (first, second) = steps[:, None, None], (rates[:, 0], rates[:, 1])
    turned = second @ first - first @ second
    parts = expm(h / 2 * (first + second) + np.sqrt(3) / 12 * h**2 * turned)
    whole = np.eye(rates.shape[-1])
    for part in parts:
        whole = part @ whole
    return whole
