"""Consistent start: positions and velocities that satisfy the joints, redundant equations left out.

Positions are corrected until `g(q, t_0) = 0` by the least rigid motion of the bodies in the mass norm. Bodies
deform only where no rigid motion closes the joints, because bent bodies would store unintended energy.
Velocities are corrected likewise until `dg/dt = 0` (`start_velocity`). All methods start in this way; they
differ in how the least motion is computed.
Redundant constraint equations are found by orthogonalising the rows of the Jacobian, and reported by name.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Generic, NamedTuple, TypeVar

import jax.numpy as jnp
import numpy as np
import scipy.linalg
from scipy.spatial.transform import Rotation

from supple.equations.build_model import row_scales
from supple.equations.configuration import Configuration
from supple.equations.joint_closure import check_joints_finite, joints_closed, row_labels
from supple.equations.machine_model import Model
from supple.equations.start_change import StartChange, StartEnergies
from supple.equations.start_velocity import velocity_change
from supple.equations.starting_machine import StartingMachine
from supple.errors import ConvergenceError, ModelError, RedundantConstraintWarning
from supple.machine import GROUND, JointFriction, PrescribedRotation, System
from supple.machine.forces.relative_motion import wrapped

_REDUNDANT = 1e-9
"""Largest part of a redundant row of the Jacobian that is independent of earlier rows, relative to the row,
in the norm of `StartingMachine.metric`."""
_OPEN = 1e-3
"""Constraint residual, relative to the system's size or in rad, above which the model is in error."""
_MOVED_BY = 1e-3
"""Size of a motion to a neighbouring configuration, relative to the system's size or in rad; a residual
quadratic in the motion is then 1e-6."""
_OPENED_BY = 1e-8
"""Largest residual there of a truly redundant equation, relative to the system's size or in rad."""
_DIRECTIONS = 3
"""Number of random combinations of the free motions, because a single motion may not open the joint."""


M = TypeVar("M", bound=StartingMachine)


class ConsistentStart(NamedTuple, Generic[M]):
    """A machine without redundant constraints, in a state that satisfies its joints."""

    machine: M
    configuration: Configuration
    velocity: np.ndarray
    change: StartChange
    """Difference of this state from the one given"""


def consistent_start(machine: M, time: float) -> ConsistentStart[M]:
    """The machine without redundant constraints, and a configuration and velocities that satisfy its joints.

    Raises
    ------
    ModelError          a law of a joint without a finite value at the start; a constraint residual above a
                        thousandth (of the size, or in rad); joints that contradict each other; a mechanism at
                        a singular position (dead point); friction that depends on the multiplier of a
                        redundant equation
    ConvergenceError    joints that cannot be closed

    Warns
    -----
    RedundantConstraintWarning
    """
    every, system = machine, machine.system
    configuration, velocity = placed_configuration(system), placed_velocity(system)
    terms = machine.joint_terms(time, configuration, velocity)
    check_joints_finite(system, terms.residual, terms.rate)
    _check_joints_closed(system, machine.model, terms.residual, time)
    gaps = terms.residual
    active = independent_constraints(system, terms.jacobian, machine.metric(configuration))
    if active != machine.model.active:
        machine = machine.restricted(active)
    check_friction_known(system, active)
    configuration = joints_closed(machine, time, configuration, velocity)
    closed = every.joint_terms(time, configuration, velocity)
    left = closed.residual
    _check_redundant_closed(system, active, left)
    if len(active) < len(left):
        _check_nearby(every, machine, time, configuration, velocity)
    terms = machine.joint_terms(time, configuration, velocity)
    change = velocity_change(machine, configuration, velocity, terms)
    found = velocity + change.rigid + change.deforming
    frames = np.array([np.arange(part.start, part.start + 6) for part in machine.slices])
    unmet = np.zeros(len(closed.rate))
    unmet[list(machine.model.active)] = change.fit.unmet
    return ConsistentStart(
        machine,
        configuration,
        found,
        StartChange.of_positions_and_velocities(
            system,
            residual=gaps,
            closed=configuration,
            rates=closed.rate,
            unmet=unmet,
            largest_rate=change.fit.largest,
            velocities=(velocity[frames], found[frames]),
            energies=StartEnergies(
                *(
                    machine.kinetic_energies(configuration, each)
                    for each in (velocity, found, change.against, change.deforming)
                )
            ),
        ),
    )


def _check_nearby(
    every: M, machine: M, time: float, configuration: Configuration, velocity: np.ndarray
) -> None:
    """Raise ModelError if the equations left out are redundant only in the initial configuration.

    In a singular position, constraint equations of a mechanism depend on each other; in other positions they
    do not. Examples are a flat parallelogram, a folded slider-crank, and a taut chain between two pins. If
    such an equation is left out of the run, its joint opens as soon as the mechanism moves. Here the
    mechanism is moved a little along the motions that the remaining equations allow, and these equations are
    solved again; a truly redundant equation is then still satisfied.
    """
    labels, scales = row_labels(machine.system), row_scales(machine.system)
    left_out = sorted(set(every.model.active) - set(machine.model.active))
    frames = np.array([np.arange(part.start, part.start + 6) for part in machine.slices])
    jacobian = machine.joint_terms(time, configuration, velocity).jacobian
    for motion in _neighbours(float(machine.model.length), machine.joint_slices, jacobian):
        increment = np.zeros_like(velocity)
        increment[frames] = motion
        try:
            moved = machine.moved(configuration, increment)
            closed = joints_closed(machine, time, moved, velocity)
        except ConvergenceError:
            continue  # the remaining equations do not allow this configuration
        opened = np.abs(every.joint_terms(time, closed, velocity).residual / scales)[left_out]
        worst = int(np.argmax(opened))
        if opened[worst] > _OPENED_BY:
            names = ", ".join(labels[index] for index in left_out)
            raise ModelError(
                f"the mechanism starts in a dead point: {names} depend(s) on the other joints in the initial "
                f"configuration, but not beside it, where {labels[left_out[worst]]} would open by "
                f"{opened[worst]:.2g} of the machine's size, or rad. The motion out of a dead point is "
                "undetermined: place the bodies beside it, with all joints closed; it is enough to give a "
                "driving joint an initial angle that is not at the dead point"
            )


def _neighbours(length: float, parts: Sequence[slice], jacobian: np.ndarray) -> np.ndarray:
    """Small motions of the bodies' frames (k, nb, 6) that the joints allow to first order.

    length : size of the system
    parts : positions of the velocities of each body in the columns of the jacobian, its frame's six first
    jacobian : (m, n)   of the remaining constraint equations
    """
    scale = np.tile(np.concatenate([np.full(3, length), np.ones(3)]), len(parts))
    columns = [jacobian[:, part.start : part.start + 6] for part in parts]
    free = scipy.linalg.null_space(np.hstack(columns) * scale, rcond=1e-9)
    if not free.shape[1]:
        return np.zeros((0, len(parts), 6))
    random = np.random.default_rng(0).standard_normal((_DIRECTIONS, free.shape[1]))
    moves = random @ free.T
    moves *= _MOVED_BY / np.abs(moves).max(axis=1, keepdims=True)
    return (moves * scale).reshape(_DIRECTIONS, len(parts), 6)


def placed_configuration(system: System) -> Configuration:
    """Configuration in which the system's bodies were placed."""
    return Configuration(
        origins=np.array([placed.position for placed in system.bodies]),
        rotations=np.array([placed.rotation for placed in system.bodies]),
        coordinates=np.concatenate([placed.coordinates for placed in system.bodies]),
    )


def placed_velocity(system: System) -> np.ndarray:
    """Initial velocities of all bodies, (n,); zero by default."""
    parts = [(placed.twist, placed.coordinate_rates) for placed in system.bodies]
    return np.concatenate([item for part in parts for item in part])


def _check_joints_closed(system: System, model: Model, residuals: np.ndarray, time: float) -> None:
    """Raise ModelError for a joint whose ends lie apart in the initial configuration."""
    rows = system.constraint_slices
    for joint in system.joints:
        own = list(zip(joint.rows, residuals[rows[joint.name]], strict=True))
        if isinstance(joint, PrescribedRotation):
            behind = angle_behind(system, joint, time)
            # The residual is its sine, which is zero at half a revolution.
            own += [("rotation z", behind)] if abs(behind) > np.pi / 2 else []
        for row, residual in own:
            scale = float(model.length) if row.startswith("position") else 1.0
            if abs(residual) > _OPEN * scale:
                raise ModelError(
                    f"joint '{joint.name}' is open in the initial configuration: {row} is off by "
                    f"{residual:.3g}. "
                    "Place the bodies so that both ends meet, let the prescribed motion start at zero, or "
                    "have the machine assembled: assemble(system); in a case file, assemble = true in "
                    "[simulation]"
                )


def angle_behind(system: System, joint: PrescribedRotation, time: float) -> float:
    """Angle from the prescribed to the actual rotation of the bodies, as if undeformed; in (-pi, pi]."""
    turned = [np.eye(3), np.eye(3)]
    for k, end in enumerate((joint.first, joint.second)):
        if end != GROUND:
            placed = system.placed(end.body, f"joint '{joint.name}'")
            turned[k] = placed.rotation @ placed.assembly.rotation.T
    axis = np.asarray(joint.axis, dtype=float) / np.linalg.norm(joint.axis)
    angle = Rotation.from_matrix(turned[0].T @ turned[1]).as_rotvec() @ axis
    return float(wrapped(angle - jnp.asarray(joint.law(time))))


def check_friction_known(system: System, active: tuple[int, ...]) -> None:
    """Raise ModelError if friction depends on the multiplier of an omitted equation."""
    rows = system.constraint_slices
    for load in system.loads:
        if not isinstance(load, JointFriction):
            continue
        first = rows[load.joint.name].start
        if not {first, first + 1} <= set(active):
            raise ModelError(
                f"{load.label}: the distribution of joint forces normal to its axis is not unique, because "
                "some constraint equations are redundant. Make a body flexible, use a joint with more "
                "freedom, or use friction of a given preload (RevoluteFriction, PrismaticFriction)"
            )


def _check_redundant_closed(system: System, active: tuple[int, ...], residuals: np.ndarray) -> None:
    """Raise ModelError if an omitted equation is violated: the joints then contradict each other."""
    labels, scales = row_labels(system), row_scales(system)
    for index in sorted(set(range(len(residuals))) - set(active)):
        if abs(residuals[index]) > 1e-9 * scales[index]:
            raise ModelError(
                f"the joints contradict each other at the start: with all others closed, {labels[index]} is "
                f"off by {residuals[index]:.3g}. Correct the placement, or start away from a dead point"
            )


def independent_constraints(system: System, jacobian: np.ndarray, metric: np.ndarray) -> tuple[int, ...]:
    """Indices of a largest set of independent constraint equations; a warning lists the redundant ones.

    Joints are processed in order, so that a closed loop loses rows of the joint that closes it. Pivoting is
    avoided, because the best conditioned rows of all joints could become dependent as soon as the mechanism
    moves.
    """
    if not len(jacobian):
        return ()
    scaled = scipy.linalg.solve_triangular(np.linalg.cholesky(metric), jacobian.T, lower=True)
    kept = _independent_columns(scaled)
    if kept.size == len(jacobian):
        return tuple(range(len(jacobian)))
    labels = row_labels(system)
    redundant = [labels[i] for i in np.setdiff1d(np.arange(len(jacobian)), kept)]
    warnings.warn(
        f"{len(redundant)} redundant constraint equation(s) left out: {', '.join(redundant)}. The motion is "
        "the same without them, but the forces of the joints concerned are not unique; a flexible body, or "
        "a joint with more freedom, removes the redundancy",
        RedundantConstraintWarning,
        stacklevel=4,
    )
    return tuple(int(i) for i in kept)


def _independent_columns(columns: np.ndarray) -> np.ndarray:
    """Indices of the columns that are linearly independent of the columns before them.

    Gram-Schmidt, orthogonalised twice.
    """
    basis = np.zeros((len(columns), 0))
    kept = []
    for index, column in enumerate(columns.T):
        new = column - basis @ (basis.T @ column)
        new = new - basis @ (basis.T @ new)
        size = np.linalg.norm(new)
        if size > _REDUNDANT * np.linalg.norm(column):
            basis = np.column_stack([basis, new / size])
            kept.append(index)
    return np.array(kept, dtype=int)
