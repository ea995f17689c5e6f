"""Whirl of rotating bodies, forward or backward, and its frequency in space.

A motion `Re( a e^(i w t) )` normal to the axis has two parts: `a_1 + i a_2` rotates with the spin, `a_1 - i
a_2` against it. In axes that rotate at the rate W both parts have the frequency w; in space they have the
frequencies w + W and w - W.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from supple.linearization.linear_machine import Array, LinearMachine, rigid_motions
from supple.linearization.machine_modes import MachineModes
from supple.machine import Placed

__all__ = ["Whirl", "whirl"]

LEAST = 1e-6
"""Share of the kinetic energy of a mode below which motion normal to the axis is not whirl."""
ROUND, TURNING_ROUND = 1e-3, 0.5
"""Difference of the squares of both parts, relative to their sum, above which an orbit has a sense: `ROUND`
in standing axes; `TURNING_ROUND` in co-rotating axes, where a flat orbit is a sum of two motions in space."""
ALIKE = 1e-6
"""Relative difference of two frequencies in co-rotating axes up to which the sense is unknown: the modes are
then arbitrary combinations."""
ON_AXIS = 1e-6
"""Allowed distance from the axis of an interface on the axis, relative to the size of the body."""


class Whirl(NamedTuple):
    """Whirl of each mode.

    sense : (k,)            1 forward, -1 backward, 0 for neither, or unknown
    frequencies : (k,)      rad per unit of time, in space; NaN without a coherent motion normal to the axis
    """

    sense: Array
    frequencies: Array


def whirl(modes: MachineModes) -> Whirl:
    """Whirl of the rotating bodies in each mode; without spin there is no forward or backward whirl."""
    machine, w = modes.machine, modes.frequencies
    if machine.spin is None:
        return Whirl(np.zeros(len(w), dtype=int), np.full(len(w), np.nan))
    across = _across(machine, modes.shapes)
    forward, backward = (np.sum(abs(across[0] + sign * 1j * across[1]) ** 2, axis=0) for sign in (1, -1))
    both = forward + backward
    moves = (both > LEAST) & (w > 0)
    part = (forward - backward) / np.where(both > 0, both, 1.0)
    rate = abs(machine.spin.rate)
    if machine.is_in_space or not rate:
        sense = np.where(moves & (abs(part) > ROUND) & (rate > 0), np.sign(part), 0.0)
        return Whirl(sense.astype(int), np.where(moves, w, np.nan))
    apart = abs(w[:, None] - w) + np.diag(np.full(len(w), np.inf))
    known = moves & (abs(part) > TURNING_ROUND) & (apart.min(axis=1, initial=np.inf) > ALIKE * w)
    signed = np.where(part > 0, rate + w, rate - w)
    # What grows or decays in turning axes without oscillation goes round with the rotor.
    carried = (both > LEAST) & (w == 0) & (modes.eigenvalues != 0)
    known, signed = known | carried, np.where(carried, rate, signed)
    return Whirl(np.where(known, np.sign(signed), 0.0).astype(int), np.where(known, abs(signed), np.nan))


def _across(machine: LinearMachine, shapes: Array) -> tuple[Array, Array]:
    """Motions (j, k) along two directions normal to the axis: of the rotor as a whole, of points on the axis.

    The motions are scaled such that their squares have the unit of the modes' kinetic energy norm.
    """
    spin = machine.spin
    assert spin is not None
    axis = spin.axis * (np.sign(spin.rate) or 1.0)
    first = np.cross(axis, np.eye(3)[np.argmin(abs(axis))])
    first = first / np.linalg.norm(first)
    directions = np.array([first, np.cross(axis, first)])
    bodies = zip(machine.system.bodies, machine.slices, strict=True)
    turning = [each for each in bodies if spin.bodies is None or each[0].body.name in spin.bodies]
    frames = ((own.start, placed.rotation, placed.position - spin.point) for placed, own in turning)
    rigid = rigid_motions(len(shapes), frames)
    # Columns: translation along both, rotation about both.
    whole = np.hstack([rigid[:, :3] @ directions.T, rigid[:, 3:] @ directions.T])
    squares = np.einsum("nj,nj->j", whole, machine.full_mass @ whole)
    sizes = np.sqrt(np.repeat(squares.reshape(2, 2).mean(axis=1), 2))
    moments = (whole / sizes).T @ (machine.full_mass @ shapes)
    moments = moments.reshape(2, 2, -1).transpose(1, 0, 2)
    points = [_on_axis(machine, placed, shapes, directions) for placed, _ in turning]
    found = np.concatenate([moments, *points], axis=1)
    return found[0], found[1]


def _on_axis(machine: LinearMachine, placed: Placed, shapes: Array, directions: Array) -> Array:
    """Motions (2, p, k) of a body's interfaces on the axis, each times the square root of mass / p."""
    spin, body = machine.spin, placed.body
    assert spin is not None
    arms = [placed.position + placed.rotation @ end.position - spin.point for end in body.interfaces]
    size = float(np.ptp(body.nodes, axis=0).max(initial=0.0)) or 1.0
    off = [float(np.linalg.norm(arm - (arm @ spin.axis) * spin.axis)) for arm in arms]
    ends = [end.name for end, apart in zip(body.interfaces, off, strict=True) if apart < ON_AXIS * size]
    if not ends:
        return np.zeros((2, 0, shapes.shape[1]))
    motion = machine.moving_at(np.concatenate([shapes.real.T, shapes.imag.T])).bodies[body.name]
    moved = np.array([body.interface_motion(motion, end).velocity @ directions.T for end in ends])
    real, imaginary = np.split(moved.transpose(2, 0, 1), 2, axis=2)
    return np.sqrt(body.mass / len(ends)) * (real + 1j * imaginary)
