"""Conversion of a machine of intrinsic bodies to a system of lines, and of its results back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.cross import cross_matrices, cross_matrix
from supple.algebra.rotation import euler_parameters
from supple.arrays import AnyArray
from supple.equations.compiler_options import STARTING
from supple.errors import ModelError
from supple.integrate import Solution, Statistics
from supple.machine import Placed, System
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody, body_of
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.methods.intrinsic.line_march import full_leg
from supple.methods.intrinsic.line_model import LineModel, LineState
from supple.methods.intrinsic.line_system import LineSystem, RootDrive, States, reactions
from supple.methods.intrinsic.station_loads import machine_loads
from supple.methods.intrinsic.strain_integration import rotation_of, station_places
from supple.methods.intrinsic.supported_root import SupportedRoot, is_joined, supported_root
from supple.programs.program_cache import CachedProgram

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

    def solution(
        self,
        times: Array,
        states: States,
        statistics: Statistics,
        rates: Sequence[Array] | None = None,
        *,
        length: int = 1,
        engine_state: Mapping[str, Array] = MappingProxyType({}),
    ) -> Solution:
        """Stacked states (leading axis: time) as a solution, joint forces from the balance of the bodies.

        rates : q_1' (t, m) of each line; by default those of the equations of motion
        length : least number of instants of the compiled program
        """
        n, filled = len(times), full_leg((times, states), length)
        found, of_equations = jax.device_get(reactions(self.lines, *filled))
        motions = self.motions(times, states, rates or [rate[:n] for rate in of_equations])
        return Solution(
            times=times,
            bodies=motions,
            joint_forces=self.joint_forces(found[:n], motions),
            statistics=statistics,
            engine_state=engine_state,
            multipliers={joint.name: np.zeros((n, 0)) for joint in self.system.joints},
        )

    def motions(self, times: Array, states: States, rates: Sequence[Array]) -> dict[str, IntrinsicMotion]:
        """Motions by body name from states and rates q_1' (t, m) of each line, stacked over time."""
        each = zip(self.system.bodies, self.lines.lines, self.lines.drives, states, rates, strict=True)
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
    """Lines, loads and initial states of a machine.

    Raises ModelError unless each body is an intrinsic one whose root is free or supported by the ground.
    """
    for placed in system.bodies:
        body_of(placed)
    if is_joined(system):
        raise ModelError(
            "this analysis supports only intrinsic bodies whose root is free or supported by one joint to "
            "the ground. The machine also has a joint between two bodies, a joint on a released body, "
            "friction that depends on a joint force, or a controller. Use a time integration instead, with "
            "damping to reach equilibrium"
        )
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


def rigid_motion(body: IntrinsicBody, q2: Array) -> Array:
    """Velocities (6 n, 6) of the stations, along their own axes, for each unit component of the root's twist.

    With rotation R and position p of a station relative to the root:  v = R^T (v_0 + w_0 x p),  w = R^T w_0
    q2 : (e,)   constant amplitudes of forces and strains
    """
    if not q2.any():
        return body.line.twists
    rotations, positions = (np.asarray(each) for each in _from_root(body.model, q2))
    motion = np.zeros((len(positions), 6, 6))
    turned = rotations.transpose(0, 2, 1)
    motion[:, :3, :3] = motion[:, 3:, 3:] = turned
    motion[:, :3, 3:] = -turned @ cross_matrices(positions)
    return motion.reshape(-1, 6)


def amplitudes_of(body: IntrinsicBody, velocities: Array) -> Array:
    """Amplitudes q_1 (m, ...) of velocities (6 n, ...): `Phi_1^T M x_1`, nearest in kinetic energy."""
    return body.modes.velocities.reshape(len(velocities), -1).T @ (body.line.mass @ velocities)


def _places_from_root(model: LineModel, q2: jax.Array) -> tuple[jax.Array, jax.Array]:
    return station_places(model, q2, jnp.eye(3), jnp.zeros(3))


def line_motion(
    placed: Placed, model: LineModel, drive: RootDrive | None, state: LineState, rate: AnyArray, times: Array
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
    model: LineModel, drive: RootDrive | None, states: LineState, rates: jax.Array, times: jax.Array
) -> tuple[jax.Array, ...]:
    """Rotations, positions and twists of a root, and the rates of the twists."""

    def at(state: LineState, rate: jax.Array, time: jax.Array) -> tuple[jax.Array, ...]:
        twist, faster = model.velocities[:6] @ state.q1, model.velocities[:6] @ rate
        if drive is None:
            return rotation_of(state.quaternion), state.position, twist, faster
        driven = drive.twist(time)
        return *drive.pose(time), twist + driven.twist, faster + driven.rate

    return jax.vmap(at)(states, rates, times)


_from_root = CachedProgram(_places_from_root, STARTING)
_roots = CachedProgram(_roots_over_time)
