"""Conversion of a machine of intrinsic bodies to a system of lines, and of its results back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.cross import cross_matrix
from supple.algebra.rotation import euler_parameters
from supple.errors import ModelError
from supple.machine import Placed, System
from supple.methods.intrinsic.intrinsic_body import body_of
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.methods.intrinsic.line_model import LineModel, LineState
from supple.methods.intrinsic.line_system import LineSystem, States
from supple.methods.intrinsic.machine_loads import machine_loads
from supple.methods.intrinsic.rigid_motion import amplitudes_of, rigid_motion
from supple.methods.intrinsic.root_drive import RootDrive
from supple.methods.intrinsic.strain_integration import rotation_of
from supple.methods.intrinsic.supported_root import SupportedRoot, is_joined, supported_root
from supple.programs.program_cache import CachedProgram

__all__ = [
    "MachineOfLines",
    "check_held_by_ground",
    "frame_to_root",
    "line_motion",
    "line_start",
    "machine_of_lines",
]

Array = np.ndarray

_quaternion = CachedProgram(euler_parameters)

SAME_VELOCITY = 1e-6
"""Tolerance for the part of a root's twist that its support excludes, relative to the largest component."""


@dataclass(frozen=True, eq=False)
class MachineOfLines:
    """A machine as arrays for compiled code.

    system : System
    lines : LineSystem
    start : States              initial states of the bodies as placed
    roots : joint and drive of each root
    """

    system: System
    lines: LineSystem
    start: States
    roots: tuple[SupportedRoot, ...]

    def motions(
        self, times: Array, states: States, rates: Sequence[Any] | None = None
    ) -> dict[str, IntrinsicMotion]:
        """Motions by body name from stacked states (leading axis: time).

        rates : q_1' (t, m) of each line; without them, accelerations are unknown (nan)
        """
        known = rates or [np.full(np.shape(state.q1), np.nan) for state in states]
        each = zip(self.system.bodies, self.lines.lines, self.lines.drives, states, known, strict=True)
        return {
            placed.body.name: line_motion(placed, model, drive, state, rate, times)
            for placed, model, drive, state, rate in each
        }

    def joint_forces(self, reactions: Array, motions: Mapping[str, IntrinsicMotion]) -> Mapping[str, Array]:
        """Force and moment (t, 6) of each joint on its second end, about the point of this end.

        reactions : (t, b, 6)   forces and moments on the roots, along their own axes

        Components are along the joint axes, as in `joint_wrenches`. Those along free directions are set to
        zero: the computed reactions contain only discretisation errors there.
        """
        found = {}
        for number, (placed, root) in enumerate(zip(self.system.bodies, self.roots, strict=True)):
            if root.joint is None:
                continue
            free = body_of(placed).support.free
            held = np.eye(6) - free @ np.linalg.pinv(free)
            own = (reactions[:, number] @ held).reshape(-1, 2, 3)
            axes, motion = root.joint.initial_axes, motions[placed.body.name]
            if root.joint.second.body == placed.body.name:
                space = np.einsum("tij,twj->twi", motion.rotation, own)
                found[root.joint.name] = (space @ axes).reshape(-1, 6)
            else:
                # The ground end is at the position of the root at assembly.
                (position, rotation), point = placed.assembly, body_of(placed).line.tree.points[0]
                there = motion.position + motion.rotation @ point - position - rotation @ point
                own[:, 1] += np.cross(np.einsum("tij,ti->tj", motion.rotation, there), own[:, 0])
                found[root.joint.name] = -(own @ (placed.assembly.rotation.T @ axes)).reshape(-1, 6)
        return found


def machine_of_lines(system: System, time: float) -> MachineOfLines:
    """Lines, loads and initial states of a machine; ModelError for features that lines do not support."""
    check_held_by_ground(system)
    roots = tuple(supported_root(system, placed) for placed in system.bodies)
    lines = LineSystem(
        tuple(body_of(placed).model for placed in system.bodies),
        tuple(root.drive for root in roots),
        machine_loads(system),
    )
    start = tuple(
        line_start(placed, root.drive, time) for placed, root in zip(system.bodies, roots, strict=True)
    )
    return MachineOfLines(system, lines, start, roots)


def check_held_by_ground(system: System) -> None:
    """Raise ModelError unless each body is an intrinsic one whose root is free or supported by the ground."""
    for placed in system.bodies:
        body_of(placed)
    if is_joined(system):
        raise ModelError(
            "this analysis supports only intrinsic bodies whose root is free or supported by one joint to "
            "the ground. The machine also has a joint between two bodies, a joint on a released body, "
            "friction that depends on a joint force, or a controller. Use a time integration instead, with "
            "damping to reach equilibrium"
        )


def line_start(placed: Placed, drive: RootDrive | None, time: float) -> LineState:
    """Initial state of a body as placed: rigid motion of its frame, strains, and rates of its modes.

    Velocities that are not given follow from the support or drive of the root.
    """
    body = body_of(placed)
    q2 = np.asarray(body.forces_of(placed.coordinates))
    driven = np.zeros(6) if drive is None else np.asarray(drive.twist(time).twist)
    if not np.isfinite(driven).all():
        raise ModelError(
            f"body '{body.name}': the law of the joint at its root has no finite value or rate at the start: "
            "write it without a division by zero there"
        )
    own = rigid_motion(body, q2) @ _root_twist(placed, driven) - body.line.twists @ driven
    q1 = amplitudes_of(body, own)
    q1[body.modes.n_rigid :] += placed.coordinate_rates
    return LineState(
        q1=jnp.asarray(q1),
        q2=jnp.asarray(q2),
        quaternion=_quaternion(placed.rotation),
        position=jnp.asarray(placed.position + placed.rotation @ body.line.tree.points[0]),
    )


def _root_twist(placed: Placed, driven: Array) -> Array:
    """Initial twist (6,) of the root, along its axes; ModelError if the root support excludes it.

    driven : (6,)   twist of the root by its drive
    """
    given = np.array([placed.velocity is not None, placed.angular_velocity is not None])
    if not given.any():
        return driven
    body = body_of(placed)
    from_frame = frame_to_root(placed)
    twist = from_frame @ placed.twist
    allowed = body.modes.velocities[0, :, : body.modes.n_rigid]
    left_out = from_frame[:, np.repeat(~given, 3)]
    # Velocities that are not given are zero, if the root support allows this.
    for ways in (allowed, np.hstack([allowed, left_out])):
        found = np.linalg.lstsq(ways, twist - driven, rcond=None)[0] if ways.size else np.zeros(0)
        missed = twist - driven - ways @ found
        if np.abs(missed).max() <= SAME_VELOCITY * max(np.abs(twist).max(), np.abs(driven).max()):
            return driven + allowed @ found[: allowed.shape[1]]
    raise ModelError(
        f"body '{body.name}' has an initial velocity that its root cannot have: velocity and angular "
        f"velocity are {np.round(twist, 6).tolist()} along its axes, but the root support excludes "
        f"{np.round(missed, 6).tolist()}. Give the velocity of its joint, or none"
    )


def frame_to_root(placed: Placed) -> Array:
    """Map (6, 6) from velocity (global) and angular velocity of the frame to the root's twist, own axes."""
    found = np.zeros((6, 6))
    found[:3, :3] = placed.rotation.T
    found[:3, 3:] = -cross_matrix(body_of(placed).line.tree.points[0])
    found[3:, 3:] = np.eye(3)
    return found


def line_motion(
    placed: Placed, model: LineModel, drive: RootDrive | None, state: LineState, rate: Any, times: Array
) -> IntrinsicMotion:
    """The motion of a body from states of its line and their rates q_1' (leading axis: time)."""
    body = body_of(placed)
    found = _roots(model, drive, state, rate, jnp.asarray(times))
    rotation, position, twist, faster = (np.asarray(each) for each in found)
    root = body.line.tree.points[0]
    w, dw = twist[:, 3:], faster[:, 3:]
    # Velocity of the body's origin, along rotating axes.
    velocity = twist[:, :3] - np.cross(w, root)
    acceleration = faster[:, :3] - np.cross(dw, root) + np.cross(w, velocity)
    omega = body.modes.omega[body.modes.n_rigid :]
    return IntrinsicMotion(
        position=position - rotation @ root,
        rotation=rotation,
        coordinates=-np.asarray(state.q2) / omega,
        velocity=np.einsum("tij,tj->ti", rotation, velocity),
        angular_velocity=w,
        rates=np.asarray(state.q1),
        acceleration=np.einsum("tij,tj->ti", rotation, acceleration),
        angular_acceleration=dw,
        accelerations=np.asarray(rate),
    )


def _roots_over_time(
    model: LineModel, drive: RootDrive | None, states: LineState, rates: Any, times: Any
) -> Any:
    """Rotations, positions and twists of a root, and the rates of the twists."""

    def at(state: LineState, rate: Any, time: Any) -> Any:
        twist, faster = model.velocities[:6] @ state.q1, model.velocities[:6] @ rate
        if drive is None:
            return rotation_of(state.quaternion), state.position, twist, faster
        driven = drive.twist(time)
        return *drive.pose(time), twist + driven.twist, faster + driven.rate

    return jax.vmap(at)(states, rates, times)


_roots = CachedProgram(_roots_over_time)
