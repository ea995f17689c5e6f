"""What the joints changed of the initial state: how far bodies were moved, and the energy that went."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from supple.machine import System
from supple.multibody.equations.build_model import row_scales, system_length
from supple.multibody.equations.configuration import Configuration

__all__ = ["Moved", "Open", "Slowed", "StartChange"]

OPEN = 1e-6
"""Of the machine's size, and rad: placements written with six digits pass."""
SLOWED = 1e-5
"""Of the kinetic energy: velocities written with three digits pass."""
NAMED = 0.1
"""Of the largest change: bodies and joints with less are not named."""


@dataclass(frozen=True)
class Open:
    """A constraint equation of a joint that was not met, by `gap` (length or rad; its rate, per time)."""

    joint: str
    row: str
    gap: float


@dataclass(frozen=True)
class Moved:
    """A body that was moved by a distance, and turned by an angle (rad), to close the joints."""

    body: str
    distance: float
    angle: float


@dataclass(frozen=True)
class Slowed:
    """A body whose given velocity was changed: speeds and angular speeds before and after."""

    body: str
    speeds: tuple[float, float]
    spins: tuple[float, float]


@dataclass(frozen=True)
class StartChange:
    """What was changed of an initial state; empty where it was nothing but rounding.

    open, moved : joints that did not meet, the worst first; bodies moved to close them
    against, slowed : joints that did not allow the velocities, the worst first; bodies whose velocity, given
        and not zero, was changed. A body at rest that a joint drives is not among them
    energies : kinetic energy of the velocities as given, and as changed
    """

    open: tuple[Open, ...]
    moved: tuple[Moved, ...]
    against: tuple[Open, ...]
    slowed: tuple[Slowed, ...]
    energies: tuple[float, float]

    @classmethod
    def of_positions_and_velocities(
        cls,
        system: System,
        *,
        residual: np.ndarray,
        closed: Configuration,
        rates: np.ndarray,
        velocities: tuple[np.ndarray, np.ndarray],
        energies: tuple[np.ndarray, np.ndarray, np.ndarray],
    ) -> StartChange:
        """Compare the state given with the state found.

        residual, rates : (m,)      of all constraint equations before, their rates at the velocities given
        closed : Configuration      with the joints closed
        velocities : (nb, 6) each   of the frames, given and found
        energies : (nb,) each       kinetic energies of the bodies: as given, as found, of the difference
        """
        scales = row_scales(system)
        gaps = _open(system, np.abs(residual), np.abs(residual) / scales > OPEN)
        given, found, lost = (np.asarray(each) for each in energies)
        total = float(given.sum())
        changed = np.flatnonzero((given > 0) & (lost > SLOWED * total))
        largest = float(np.max(lost[changed], initial=0.0))
        rate = np.abs(rates) / scales
        against = rate > NAMED * np.max(rate, initial=0.0)
        names = [placed.body.name for placed in system.bodies]
        before, after = velocities
        return cls(
            open=gaps,
            moved=_moved(system, closed) if gaps else (),
            against=_open(system, np.abs(rates), against) if changed.size else (),
            slowed=tuple(
                Slowed(
                    names[i],
                    (float(np.linalg.norm(before[i, :3])), float(np.linalg.norm(after[i, :3]))),
                    (float(np.linalg.norm(before[i, 3:])), float(np.linalg.norm(after[i, 3:]))),
                )
                for i in changed
                if lost[i] >= NAMED * largest
            ),
            energies=(total, float(found.sum())),
        )


def _open(system: System, gaps: np.ndarray, which: np.ndarray) -> tuple[Open, ...]:
    """The worst equation of each joint that has any among `which`, the worst joint first."""
    relative = gaps / row_scales(system)
    worst, stands = [], system.constraint_slices
    for joint in system.joints:
        rows = np.arange(system.n_constraints)[stands[joint.name]]
        own = rows[which[rows]]
        if own.size:
            row = own[np.argmax(relative[own])]
            worst.append((relative[row], Open(joint.name, joint.rows[row - rows[0]], float(gaps[row]))))
    return tuple(each for _, each in sorted(worst, key=lambda pair: -pair[0]))


def _moved(system: System, closed: Configuration) -> tuple[Moved, ...]:
    """Bodies moved by a tenth of the largest motion or more, an angle at the arm of the machine's size."""
    distances = np.linalg.norm(
        np.asarray(closed.origins) - [placed.position for placed in system.bodies], axis=1
    )
    turns = [
        placed.rotation.T @ rotation
        for placed, rotation in zip(system.bodies, np.asarray(closed.rotations), strict=True)
    ]
    angles = Rotation.from_matrix(np.array(turns)).magnitude()
    motions = distances + system_length(system) * angles
    far = motions >= NAMED * motions.max()
    return tuple(
        Moved(placed.body.name, float(distances[i]), float(angles[i]))
        for i, placed in enumerate(system.bodies)
        if far[i]
    )
