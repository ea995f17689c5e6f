"""Velocities that fit the joints: rigid motions of the bodies first, deformation only where none fits.

With velocities `v` as given, rates `r = G v + dg/dt` of the joints' equations, and rigid motions `R w` of the
bodies,

    G R w = - r,        least  w^T (R^T M R) w / 2

A body keeps a velocity that is given while those that are not given can meet the joints. Levels are bodies
without any velocity; the velocity, or angular velocity, that other bodies were not given; what was given. A
level changes only by what those before it cannot meet, each by the least in kinetic energy. What no
rigid motion meets is met by the motion `x` of least kinetic energy beside the best rigid one:

    G x = - (r + G R w),    least over x and w of  x^T M x / 2
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.linalg

from supple.machine import System
from supple.multibody.equations.build_model import row_scales
from supple.multibody.equations.configuration import Configuration
from supple.multibody.equations.starting_machine import JointTerms, StartingMachine

__all__ = ["VelocityChange", "change_by_levels", "given_parts", "velocity_change"]

_RANK = 1e-9
"""Of a motion's effect on the joints: what is left of it by others counts for nothing below this part."""
_MET = 1e-9
"""Of the rates from all velocities: what is left of them below this part is rounding."""
_PARTS = (slice(0, 3), slice(3, 6))


class VelocityChange(NamedTuple):
    """By what velocities are changed to fit the joints, vectors (n,); `rigid + deforming` is all of it."""

    rigid: np.ndarray
    """Of the frames"""
    against: np.ndarray
    """The part of `rigid` that changes velocities that were given"""
    deforming: np.ndarray
    """For what no rigid motion meets, of least kinetic energy; rounding where there is none"""
    left: np.ndarray
    """Rates (m,) that no rigid motion meets; zero where one does"""
    largest: float
    """Rate of an equation from all velocities, over what counts as one of it"""


def velocity_change(
    machine: StartingMachine, configuration: Configuration, velocity: np.ndarray, terms: JointTerms
) -> VelocityChange:
    """The change of velocities after which the joints' rates vanish: `G change = - rate`.

    machine : without redundant equations, its joints closed
    velocity : (n,)  as given, zero where not
    """
    rates = np.asarray(terms.rate)
    scales = row_scales(machine.system)[list(machine.model.active)]
    levels = _levels(machine, configuration)
    effects = [np.asarray(terms.jacobian) @ _on_frames(machine.model.slices, own) for own in levels]

    def moving(weights: np.ndarray) -> tuple[list[np.ndarray], np.ndarray]:
        found = change_by_levels([weights @ own for own in effects], -weights @ rates)
        met = sum((own @ by for own, by in zip(effects, found, strict=True)), np.zeros(len(rates)))
        return found, rates + met

    found, left = moving(np.diag(1 / scales))
    sizes = sum((np.abs(own) @ np.abs(by) for own, by in zip(effects, found, strict=True)), np.abs(rates))
    largest = float(np.max(sizes / scales, initial=0.0))
    fits = bool(np.all(np.abs(left) / scales <= _MET * largest))
    if not fits:
        # Least in the kinetic energy of what remains: as long as in the norm of the joints' masses.
        masses = machine.joint_masses(configuration, terms)
        found, left = moving(scipy.linalg.cholesky((masses + masses.T) / 2))
    by_level = [own @ by for own, by in zip(levels, found, strict=True)]
    rigid, against = (
        _on_frames(machine.slices, frames) for frames in (np.sum(by_level, axis=0), by_level[-1])
    )
    deforming = machine.least_change(configuration, velocity + rigid, terms, left)
    return VelocityChange(rigid, against, deforming, np.zeros_like(left) if fits else left, largest)


def given_parts(system: System) -> np.ndarray:
    """Whether velocity and angular velocity of each body are given, (nb, 2)."""
    return np.array(
        [[own is not None for own in (body.velocity, body.angular_velocity)] for body in system.bodies]
    )


def change_by_levels(effects: Sequence[np.ndarray], wanted: np.ndarray) -> list[np.ndarray]:
    """Least squares in which each level does only what those before it cannot.

    effects : (m, k) each, in coordinates of unit mass
    wanted : (m,)       `sum effects x = wanted` in the least squares; of all such the last level's x is
        least, then that of the one before it

    Returns x (k,) of each level.
    """
    found: list[np.ndarray] = []
    for level in reversed(range(len(effects))):
        own, before = effects[level], np.hstack([np.zeros((len(wanted), 0)), *effects[:level]])
        spanned = _range(before)
        alone = own - spanned @ (spanned.T @ own)
        rest = wanted - spanned @ (spanned.T @ wanted)
        found.append(_least_squares(alone, rest, own))
        wanted = wanted - own @ found[-1]
    return found[::-1]


def _range(matrix: np.ndarray) -> np.ndarray:
    """Orthonormal columns that span those of a matrix."""
    if not matrix.size:
        return np.zeros((len(matrix), 0))
    left, sizes, _ = np.linalg.svd(matrix, full_matrices=False)
    return left[:, sizes > _RANK * sizes[0]]


def _least_squares(alone: np.ndarray, rest: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Least squares of a level; singular values are compared with those it has without the levels before."""
    if not alone.size:
        return np.zeros(alone.shape[1])
    left, sizes, right = np.linalg.svd(alone, full_matrices=False)
    kept = sizes > _RANK * np.linalg.norm(own, 2)
    return right[kept].T @ ((left[:, kept].T @ rest) / sizes[kept])


def _levels(machine: StartingMachine, configuration: Configuration) -> list[np.ndarray]:
    """Rigid motions (nb, 6, k) of unit mass, level by level."""
    given = given_parts(machine.system)
    masses = machine.frame_masses(configuration)
    level_of = np.where(given, 2, np.where(given.any(axis=1, keepdims=True), 1, 0))
    levels: list[list[np.ndarray]] = [[], [], []]
    for index, mass in enumerate(masses):
        for level in range(3):
            parts = [part for part, own in zip(_PARTS, level_of[index], strict=True) if own == level]
            if parts:
                rows = np.concatenate([np.arange(6)[part] for part in parts])
                motion = np.zeros((len(masses), 6, len(rows)))
                motion[index, rows] = np.linalg.inv(np.linalg.cholesky(mass[np.ix_(rows, rows)])).T
                levels[level].append(motion)
    return [np.concatenate([np.zeros((len(masses), 6, 0)), *own], axis=2) for own in levels]


def _on_frames(slices: Sequence[slice], frames: np.ndarray) -> np.ndarray:
    """Vectors (n, ...) of motions (nb, 6, ...) of the frames."""
    vectors = np.zeros((slices[-1].stop, *frames.shape[2:]))
    for part, own in zip(slices, frames, strict=True):
        vectors[part.start : part.start + 6] = own
    return vectors
