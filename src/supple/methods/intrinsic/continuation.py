"""Placement of an intrinsic body at an instant of a motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from supple.machine import Placed
from supple.methods.intrinsic.intrinsic_body import body_of
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.methods.intrinsic.machine_of_lines import frame_to_root
from supple.methods.intrinsic.rigid_motion import amplitudes_of, rigid_motion

__all__ = ["placed_at_instant"]


def placed_at_instant(placed: Placed, motion: IntrinsicMotion, row: int) -> Placed:
    """The body placed as in a row of its motion; its first state (`line_start`) is the state of this row.

        q_1 = Phi_1^T M ( R(q_2) (d + F c) - T d ) + (0, rates)

    Phi_1 are the modes, M is the mass, d the twist of a driven root, and F the free twists of the root. R and
    T are the rigid motions of the stations in the bent line and in the line at rest. The rigid modes give the
    coefficients c, the elastic modes the coordinate rates `rates`.
    """
    body, q1 = body_of(placed), motion.rates[row]
    moved = placed.moved_to(motion.position[row], motion.rotation[row])
    moved = replace(moved, coordinates=motion.coordinates[row])
    n, from_frame = body.modes.n_rigid, frame_to_root(moved)
    twist = from_frame @ np.concatenate([motion.velocity[row], motion.angular_velocity[row]])
    driven = twist - body.modes.velocities[0] @ q1
    bent = rigid_motion(body, np.asarray(body.forces_of(moved.coordinates)))
    free = body.modes.velocities[0][:, :n]
    own = amplitudes_of(body, bent @ driven - body.line.twists @ driven)
    by_free = amplitudes_of(body, bent @ free)
    c = np.linalg.solve(by_free[:n], q1[:n] - own[:n])
    rates = q1 - own - by_free @ c
    if n == 0:  # the joint or drive determines the motion of the root
        return replace(moved, velocity=None, angular_velocity=None, coordinate_rates=rates)
    velocity, angular = np.split(np.linalg.solve(from_frame, driven + free @ c), 2)
    return replace(moved, velocity=velocity, angular_velocity=angular, coordinate_rates=rates[n:])
