"""Corrections of the initial state: motions, velocities, energies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from supple.equations.build_model import row_scales, system_length
from supple.equations.configuration import Configuration
from supple.equations.start_velocity import given_parts, has_motion
from supple.machine import Placed, System

OPEN = 1e-6
"""Largest residual of a closed joint, relative to the machine's size or in rad; placements with six digits
have smaller residuals."""
SLOWED = 1e-5
"""Largest kinetic energy of an unreported change of a body's given velocity, relative to that of all bodies
with a given velocity; velocities with three digits have smaller changes."""
UNMET = 1e-3
"""Largest unreported rate that no rigid motion cancels, relative to the largest rate of an equation;
placements with three digits have smaller rates."""
NAMED = 0.1
"""Smallest reported change of a body or joint, relative to the largest change."""
ROUNDING = 1e-9
"""Velocity that counts as rounding, relative to the largest velocity."""


@dataclass(frozen=True)
class ConstraintViolation:
    """A violated constraint equation of a joint, with its residual `gap` (length or rad; or its rate)."""

    joint: str
    row: str
    gap: float


@dataclass(frozen=True)
class PositionCorrection:
    """A body moved by a distance, and rotated by an angle (rad), to close the joints."""

    body: str
    distance: float
    angle: float

    @classmethod
    def of(cls, placed: Placed, position: np.ndarray, rotation: np.ndarray) -> PositionCorrection:
        """The motion of a body to another position and rotation."""
        angle = Rotation.from_matrix(placed.rotation.T @ rotation).magnitude()
        return cls(placed.body.name, float(np.linalg.norm(position - placed.position)), float(angle))


@dataclass(frozen=True)
class VelocityCorrection:
    """A body whose given velocity was changed: speed and angular speed before and after."""

    body: str
    speeds: tuple[float, float]
    spins: tuple[float, float]


@dataclass(frozen=True)
class VelocityFromJoints:
    """A body without a given velocity that moves with its driving joints: speed and angular speed."""

    body: str
    speed: float
    spin: float


@dataclass(frozen=True)
class DeformingStart:
    """A body that starts with a deformation rate, as no rigid motion suffices; kinetic energy of the rate."""

    body: str
    energy: float


class StartEnergies(NamedTuple):
    """Kinetic energies (nb,) of the bodies at the velocities of a start."""

    given: np.ndarray
    found: np.ndarray
    against: np.ndarray
    """Energies of the change of given velocities"""
    deforming: np.ndarray
    """Energies of the motion beyond rigid motion"""


@dataclass(frozen=True)
class StartChange:
    """Corrections of an initial state; those below the limits of this module are left out.

    open, moved : open joints, the worst first; bodies moved to close them
    against, slowed : joints violated by the velocities, the worst first; bodies whose given velocity was
        changed
    energies : kinetic energy of the bodies with a given velocity, as given, and as changed
    taken : bodies without a given velocity that start with one
    unmet, deforming : joints whose rates no rigid motion of the bodies satisfies, the worst first; bodies
        that start with a deformation rate for this reason
    is_impact : whether the given velocities are those of an earlier motion, which joints change by an impact
    """

    open: tuple[ConstraintViolation, ...]
    moved: tuple[PositionCorrection, ...]
    against: tuple[ConstraintViolation, ...]
    slowed: tuple[VelocityCorrection, ...]
    energies: tuple[float, float]
    taken: tuple[VelocityFromJoints, ...]
    unmet: tuple[ConstraintViolation, ...]
    deforming: tuple[DeformingStart, ...]
    is_impact: bool = False

    @classmethod
    def of_positions_and_velocities(
        cls,
        system: System,
        *,
        residual: np.ndarray,
        closed: Configuration,
        rates: np.ndarray,
        unmet: np.ndarray,
        largest_rate: float,
        velocities: tuple[np.ndarray, np.ndarray],
        energies: StartEnergies,
    ) -> StartChange:
        """Compare the given state with the corrected one.

        residual : (m,)             of all constraint equations in the given state
        rates : (m,)                of these equations at the given velocities
        closed : Configuration      with the joints closed
        unmet : (m,)                rates that no rigid motion satisfies
        largest_rate : largest rate of an equation, relative to its scale
        velocities : (nb, 6) each   of the frames, given and corrected
        """
        scales = row_scales(system)
        gaps = _open(system, np.abs(residual), np.abs(residual) / scales > OPEN)
        names = [placed.body.name for placed in system.bodies]
        before, after = velocities
        is_given = given_parts(system).any(axis=1)
        of_given = float(energies.given[is_given].sum()), float(energies.found[is_given].sum())
        slowed = _largest(energies.against, SLOWED * (of_given[0] or of_given[1]))
        misfits = np.abs(unmet) / scales > UNMET * largest_rate
        deforming = _largest(energies.deforming, 0.0) if misfits.any() else ()
        return cls(
            open=gaps,
            moved=_moved(system, closed) if gaps else (),
            against=_open(system, np.abs(rates), _are_largest(rates / scales)) if slowed.size else (),
            slowed=tuple(
                VelocityCorrection(
                    names[i],
                    (float(np.linalg.norm(before[i, :3])), float(np.linalg.norm(after[i, :3]))),
                    (float(np.linalg.norm(before[i, 3:])), float(np.linalg.norm(after[i, 3:]))),
                )
                for i in slowed
            ),
            energies=of_given,
            taken=velocities_taken(system, after),
            unmet=_open(system, np.abs(unmet), misfits & _are_largest(unmet / scales)),
            deforming=tuple(DeformingStart(names[i], float(energies.deforming[i])) for i in deforming),
            is_impact=has_motion(system),
        )


def velocities_taken(system: System, velocities: np.ndarray) -> tuple[VelocityFromJoints, ...]:
    """Bodies without a given velocity that move with the velocities (nb, 6) of their frames."""
    sizes = np.linalg.norm(velocities.reshape(-1, 2, 3), axis=2)
    least = ROUNDING * np.max(sizes, axis=0, initial=0.0)
    return tuple(
        VelocityFromJoints(placed.body.name, float(speed), float(spin))
        for placed, given, (speed, spin) in zip(system.bodies, given_parts(system), sizes, strict=True)
        if not given.any() and (speed > least[0] or spin > least[1])
    )


def _largest(energies: np.ndarray, least: float) -> np.ndarray:
    """Numbers of the bodies whose energy exceeds `least` and is at least a tenth of the largest energy."""
    return np.flatnonzero((energies > least) & (energies >= NAMED * np.max(energies, initial=0.0)))


def _are_largest(rates: np.ndarray) -> np.ndarray:
    return np.abs(rates) > NAMED * np.max(np.abs(rates), initial=0.0)


def _open(system: System, gaps: np.ndarray, which: np.ndarray) -> tuple[ConstraintViolation, ...]:
    """The worst of the selected equations of each joint, the worst joint first."""
    relative = gaps / row_scales(system)
    worst, stands = [], system.constraint_slices
    for joint in system.joints:
        rows = np.arange(system.n_constraints)[stands[joint.name]]
        own = rows[which[rows]]
        if own.size:
            row = own[np.argmax(relative[own])]
            worst.append(
                (relative[row], ConstraintViolation(joint.name, joint.rows[row - rows[0]], float(gaps[row])))
            )
    return tuple(each for _, each in sorted(worst, key=lambda pair: -pair[0]))


def _moved(system: System, closed: Configuration) -> tuple[PositionCorrection, ...]:
    """Bodies moved by a tenth of the largest motion or more; angles are multiplied by the machine's size."""
    poses = np.asarray(closed.origins), np.asarray(closed.rotations)
    every = [PositionCorrection.of(*each) for each in zip(system.bodies, *poses, strict=True)]
    length = system_length(system)
    motions = np.array([each.distance + length * each.angle for each in every])
    return tuple(every[i] for i in np.flatnonzero(motions >= NAMED * motions.max()))
