"""Velocities that satisfy the joints: by rigid motions, and by deformation only where rigid motions fail.

With velocities `v` as given, rates `r = G v + dg/dt` of the joints' equations, and rigid motions `R w` of the
bodies,

    G R w = - r,        least  w^T (R^T M R) w / 2

A given velocity is changed only if the velocities not given cannot satisfy the joints. Three levels exist:
bodies without any given velocity; the missing velocity, or angular velocity, of other bodies; given values.
Velocities of a level are changed only to cancel rates that earlier levels cannot cancel, with the least
kinetic energy. Rates that no rigid motion cancels are cancelled by a motion `x` of least kinetic energy, in
addition to the best rigid motion:

    G x = - (r + G R w),    least over x and w of  x^T M x / 2

Velocities of an earlier motion (`Placed.is_moving`) are those of deformable bodies. Joints that do not allow
them, such as a latch that engages, act as an impact without rebound. It changes all velocities by the motion
of least kinetic energy, without a rigid motion before:

    G x = - r,      least  x^T M x / 2
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import scipy.linalg

from supple.equations.build_model import row_scales
from supple.equations.configuration import Configuration
from supple.equations.starting_machine import JointTerms, StartingMachine
from supple.machine import System

_RANK = 1e-9
"""Relative effect on the joints below which a motion depends on others and is ignored."""
_MET = 1e-9
"""Remaining rate that counts as rounding, relative to the rates due to all velocities."""


class RigidFit(NamedTuple):
    """The rigid motion that cancels the joints' rates, or as much of them as possible."""

    by_level: list[np.ndarray]
    """Velocities (n,) that each level adds"""
    left: np.ndarray
    """Remaining rates (m,), with rounding"""
    unmet: np.ndarray
    """Remaining rates (m,); zeros if all of them are rounding"""
    largest: float
    """Largest rate of an equation due to all velocities, relative to the equation's scale"""


class VelocityChange(NamedTuple):
    """Changes of velocities that satisfy the joints, vectors (n,); their sum is `rigid + deforming`."""

    rigid: np.ndarray
    """Rigid motion of the frames"""
    against: np.ndarray
    """The part of the sum that changes given velocities"""
    deforming: np.ndarray
    """The motion beyond rigid motion, of least kinetic energy; rounding if there is none"""
    fit: RigidFit


def velocity_change(
    machine: StartingMachine, configuration: Configuration, velocity: np.ndarray, terms: JointTerms
) -> VelocityChange:
    """The change of velocities after which the joints' rates vanish: `G change = - rate`.

    machine : without redundant equations, its joints closed
    velocity : (n,)  as given, zero by default
    """
    if has_motion(machine.system):
        fit = impact_fit(terms.rate)
        change = machine.least_change(configuration, velocity, terms, fit.left)
        return VelocityChange(np.zeros_like(change), change, change, fit)
    frames = np.concatenate([np.arange(part.start, part.start + 6) for part in machine.joint_slices])
    motions = zip(given_parts(machine.system), machine.frame_masses(configuration), strict=True)
    by_body = [levels_of_body(given, mass) for given, mass in motions]
    fit = rigid_fit(
        [np.asarray(scipy.linalg.block_diag(*own)) for own in zip(*by_body, strict=True)],
        np.asarray(terms.jacobian)[:, frames],
        np.asarray(terms.rate),
        row_scales(machine.system)[list(machine.model.active)],
        lambda: machine.joint_masses(configuration, terms),
    )
    own_frames = np.concatenate([np.arange(part.start, part.start + 6) for part in machine.slices])
    rigid, against = np.zeros((2, machine.slices[-1].stop))
    rigid[own_frames], against[own_frames] = np.sum(fit.by_level, axis=0), fit.by_level[-1]
    deforming = machine.least_change(configuration, velocity + rigid, terms, fit.left)
    return VelocityChange(rigid, against, deforming, fit)


def rigid_fit(
    levels: Sequence[np.ndarray],
    rows: np.ndarray,
    rates: np.ndarray,
    scales: np.ndarray,
    joint_masses: Callable[[], np.ndarray],
) -> RigidFit:
    """The rigid motion that cancels the joints' rates, level by level.

    levels : (n, k) each    rigid motions, orthonormal in the mass norm
    rows : (m, n)           derivatives of the rates
    rates, scales : (m,)    rates to cancel, and the scale of each
    joint_masses : function for (m, m), called if no rigid motion cancels all rates: the motion that cancels
        the remainder then has the least kinetic energy
    """
    effects = [rows @ own for own in levels]

    def moving(weights: np.ndarray) -> tuple[list[np.ndarray], np.ndarray]:
        found = change_by_levels([weights @ own for own in effects], -weights @ rates)
        return found, rates + sum(own @ by for own, by in zip(effects, found, strict=True))

    found, left = moving(np.diag(1 / scales))
    sizes = np.abs(rates) + sum(np.abs(own) @ np.abs(by) for own, by in zip(effects, found, strict=True))
    largest = float(np.max(sizes / scales, initial=0.0))
    fits = bool(np.all(np.abs(left) / scales <= _MET * largest))
    if not fits:
        masses = joint_masses()
        found, left = moving(scipy.linalg.cholesky((masses + masses.T) / 2))
    by_level = [own @ by for own, by in zip(levels, found, strict=True)]
    return RigidFit(by_level, left, np.zeros_like(left) if fits else left, largest)


def has_motion(system: System) -> bool:
    """Whether the velocities are those of an earlier motion, which joints change by an impact."""
    return any(placed.is_moving for placed in system.bodies)


def impact_fit(rates: np.ndarray) -> RigidFit:
    """No rigid motion, for an impact: all rates (m,) of the joints are left to the least motion."""
    return RigidFit([], np.asarray(rates), np.zeros(len(rates)), 0.0)


def given_parts(system: System) -> np.ndarray:
    """Whether velocity and angular velocity of each body are given, (nb, 2)."""
    return np.array(
        [[own is not None for own in (body.velocity, body.angular_velocity)] for body in system.bodies]
    )


def change_by_levels(effects: Sequence[np.ndarray], wanted: np.ndarray) -> list[np.ndarray]:
    """Least squares in levels: each level contributes only where the earlier levels cannot.

    effects : (m, k) each, in coordinates of unit mass
    wanted : (m,)       `sum effects x = wanted` in the least squares; among all solutions the x of the last
        level is smallest, then that of the level before

    Returns x (k,) of each level.
    """
    found: list[np.ndarray] = []
    for level in reversed(range(len(effects))):
        own, before = effects[level], np.hstack([np.zeros((len(wanted), 0)), *effects[:level]])
        spanned = scipy.linalg.orth(before, rcond=_RANK)
        alone = own - spanned @ (spanned.T @ own)
        rest = wanted - spanned @ (spanned.T @ wanted)
        found.append(_least_squares(alone, rest, own))
        wanted = wanted - own @ found[-1]
    return found[::-1]


def _least_squares(alone: np.ndarray, rest: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Least squares of a level; the rank decision is relative to the level without projection."""
    if not alone.size:
        return np.zeros(alone.shape[1])
    left, sizes, right = np.linalg.svd(alone, full_matrices=False)
    kept = sizes > _RANK * np.linalg.norm(own, 2)
    return right[kept].T @ ((left[:, kept].T @ rest) / sizes[kept])


def levels_of_body(given: np.ndarray, mass: np.ndarray) -> list[np.ndarray]:
    """Rigid motions (6, k) of one body, of unit mass, for each of the three levels.

    given : (2,)        whether its velocity and angular velocity are given
    mass : (6, 6)       of its rigid motion
    """
    level_of = np.where(given, 2, 1 if given.any() else 0)
    levels = []
    for level in range(3):
        rows = np.flatnonzero(np.repeat(level_of == level, 3))
        own = np.zeros((6, len(rows)))
        own[rows] = np.linalg.inv(np.linalg.cholesky(mass[np.ix_(rows, rows)])).T
        levels.append(own)
    return levels
