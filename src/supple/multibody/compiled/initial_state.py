"""A consistent start: positions and velocities on the joints, first accelerations and multipliers.

Positions are corrected by the least motion in the mass norm until `g(q, t_0) = 0`, velocities likewise until
`dg/dt = 0`; then accelerations and multipliers follow from the equations of motion together with
`d2g/dt2 = 0`. Joints that constrain the same motion twice are found by orthogonalising the rows of
`G M^{-1/2}` and named.
"""

from __future__ import annotations

import warnings
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import scipy.linalg

from supple.errors import ConvergenceError, ModelError, RedundantConstraintWarning
from supple.machine.system import System
from supple.multibody.compiled.compiler_options import STARTING
from supple.multibody.compiled.time_step import State, position_rounding
from supple.multibody.equations.balance import (
    Configuration,
    Motion,
    advance,
    balance,
    constraint_jacobian,
    constraints,
    mass_matrix,
)
from supple.multibody.equations.model import Model, build_model

__all__ = ["consistent_start"]

_REDUNDANT = 1e-9
"""A constraint row of which those before it leave less than this part adds nothing."""
_OPEN = 1e-3
"""A joint open by more than this part of the system's size is a mistake, not a rounding error."""


def placed_configuration(system: System) -> Configuration:
    """Where the system's bodies were placed."""
    return Configuration(
        origins=jnp.array([placed.position for placed in system.bodies]),
        rotations=jnp.array([placed.rotation for placed in system.bodies]),
        coordinates=tuple(jnp.array(placed.coordinates) for placed in system.bodies),
    )


def placed_velocity(system: System) -> np.ndarray:
    """Initial velocities of all bodies, (n,)."""
    parts = [(b.velocity, b.angular_velocity, b.coordinate_rates) for b in system.bodies]
    return np.concatenate([item for part in parts for item in part])


class JointTerms(NamedTuple):
    """The constraints at one position and velocity."""

    gap: jax.Array
    """`g`, (m,)"""
    jacobian: jax.Array
    """`G`, (m, n)"""
    rate: jax.Array
    """`dg/dt`, (m,)"""
    bending: jax.Array
    """`d2g/dt2` while the velocities stay constant, (m,)"""


@partial(jax.jit, compiler_options=STARTING)
def joint_terms(
    model: Model, time: jax.Array, configuration: Configuration, velocity: jax.Array
) -> JointTerms:
    """Constraints, their Jacobian, and their first two time derivatives at constant velocity."""

    def gap_after(duration: jax.Array) -> jax.Array:
        return constraints(model, time + duration, advance(model, configuration, duration * velocity))

    def rate_after(duration: jax.Array) -> jax.Array:
        return jax.jvp(gap_after, (duration,), (jnp.ones(()),))[1]

    rate, bending = jax.jvp(rate_after, (jnp.zeros(()),), (jnp.ones(()),))
    return JointTerms(
        gap=constraints(model, time, configuration),
        jacobian=constraint_jacobian(model, time, configuration),
        rate=rate,
        bending=bending,
    )


@partial(jax.jit, compiler_options=STARTING)
def _mass_and_forces(
    model: Model, time: jax.Array, configuration: Configuration, velocity: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Mass matrix (n, n), and the residual without accelerations and multipliers (n,)."""
    still = Motion(time, configuration, velocity, jnp.zeros_like(velocity), jnp.zeros(len(model.active)))
    return mass_matrix(model, configuration), balance(model, still).residual


def check_joints_closed(system: System, model: Model, gaps: np.ndarray) -> None:
    """Raise ModelError for a joint whose ends lie apart in the initial configuration."""
    start = 0
    for joint in system.joints:
        own = gaps[start : start + joint.n_constraints]
        start += joint.n_constraints
        for row, gap in zip(joint.rows, own, strict=True):
            scale = float(model.length) if row.startswith("position") else 1.0
            if abs(gap) > _OPEN * scale:
                raise ModelError(
                    f"joint '{joint.name}' is open in the initial configuration: {row} is off by {gap:.3g}. "
                    "Place the bodies so that both ends meet, or let the prescribed motion start at zero"
                )


def check_redundant_closed(system: System, model: Model, active: tuple[int, ...], gaps: np.ndarray) -> None:
    """Raise ModelError when an equation left out is not met by the others: joints that contradict."""
    labels = _row_labels(system)
    for index in sorted(set(range(len(gaps))) - set(active)):
        if abs(gaps[index]) > 1e-9 * max(float(model.length), 1.0):
            raise ModelError(
                f"the joints contradict each other at the start: with all others closed, {labels[index]} is "
                f"off by {gaps[index]:.3g}. Correct the placement, or start away from a dead point"
            )


def _row_labels(system: System) -> list[str]:
    return [f"'{joint.name}' ({row})" for joint in system.joints for row in joint.rows]


def independent_constraints(system: System, jacobian: np.ndarray, mass: np.ndarray) -> tuple[int, ...]:
    """Indices of a largest set of independent constraint equations; the others are named in a warning.

    Joints are taken in their order, so that a closed loop loses rows of the joint that closes it. (The best
    conditioned rows of several joints may turn dependent as soon as the mechanism moves.)
    """
    if not len(jacobian):
        return ()
    scaled = scipy.linalg.solve_triangular(np.linalg.cholesky(mass), jacobian.T, lower=True)
    kept = _independent_columns(scaled)
    if kept.size == len(jacobian):
        return tuple(range(len(jacobian)))
    labels = _row_labels(system)
    redundant = [labels[i] for i in np.setdiff1d(np.arange(len(jacobian)), kept)]
    warnings.warn(
        f"{len(redundant)} redundant constraint equation(s) left out: {', '.join(redundant)}. The motion is "
        "the same without them, but how the joints share these forces is undetermined; a flexible body, or "
        "a joint with more freedom, removes the redundancy",
        RedundantConstraintWarning,
        stacklevel=3,
    )
    return tuple(int(i) for i in kept)


def _independent_columns(columns: np.ndarray) -> np.ndarray:
    """Indices of the columns that those before them do not span (Gram-Schmidt, orthogonalised twice)."""
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


def _bordered_solve(
    mass: np.ndarray, jacobian: np.ndarray, top: np.ndarray, bottom: np.ndarray
) -> np.ndarray:
    m = len(jacobian)
    scale = np.trace(mass) / len(mass)
    matrix = np.block([[mass, scale * jacobian.T], [scale * jacobian, np.zeros((m, m))]])
    solution = np.linalg.solve(matrix, np.concatenate([top, scale * bottom]))
    solution[len(mass) :] *= scale
    return solution


_moved = jax.jit(advance, compiler_options=STARTING)


def consistent_start(system: System, time: float, first_step: float) -> tuple[Model, State]:
    """The compiled model (redundant constraints left out) and the consistent state at the initial time."""
    model = every = build_model(system)
    now = jnp.asarray(float(time))
    configuration = placed_configuration(system)
    velocity = placed_velocity(system)
    mass, _ = map(np.asarray, _mass_and_forces(model, now, configuration, jnp.asarray(velocity)))
    terms = joint_terms(model, now, configuration, jnp.asarray(velocity))
    check_joints_closed(system, model, np.asarray(terms.gap))
    active = independent_constraints(system, np.asarray(terms.jacobian), mass)
    if active != model.active:
        model = build_model(system, active=active)
    configuration = _close_joints(model, now, configuration, velocity)
    terms = joint_terms(every, now, configuration, jnp.asarray(velocity))
    check_redundant_closed(system, every, active, np.asarray(terms.gap))

    mass, _ = map(np.asarray, _mass_and_forces(model, now, configuration, jnp.asarray(velocity)))
    _, jacobian, drift, _ = map(np.asarray, joint_terms(model, now, configuration, jnp.asarray(velocity)))
    velocity = velocity + _bordered_solve(mass, jacobian, np.zeros(len(mass)), -drift)[: len(mass)]
    moving = jnp.asarray(velocity)
    bending = np.asarray(joint_terms(model, now, configuration, moving).bending)
    _, forces = map(np.asarray, _mass_and_forces(model, now, configuration, moving))
    solution = _bordered_solve(mass, jacobian, -forces, -bending)
    acceleration = jnp.asarray(solution[: len(mass)])
    count = jnp.zeros((), dtype=int)
    return model, State(
        time=now,
        step=jnp.asarray(float(first_step)),
        configuration=configuration,
        velocity=moving,
        acceleration=acceleration,
        auxiliary=acceleration,
        multipliers=jnp.asarray(solution[len(mass) :]),
        steps=count,
        iterations=count,
        rejected_steps=count,
        failed=jnp.zeros((), dtype=bool),
        relative_residual=jnp.zeros(4),
    )


def _close_joints(
    model: Model, time: jax.Array, configuration: Configuration, velocity: np.ndarray
) -> Configuration:
    """Project the configuration on the joints by Newton's method."""
    largest = 0.0
    gap = np.zeros(0)
    for _ in range(20):
        gap, jacobian, _, _ = map(np.asarray, joint_terms(model, time, configuration, jnp.asarray(velocity)))
        largest = np.max(abs(gap), initial=0.0)
        if largest <= model.length * position_rounding(model.length, configuration.origins):
            return configuration
        mass, _ = map(np.asarray, _mass_and_forces(model, time, configuration, jnp.asarray(velocity)))
        step = _bordered_solve(mass, jacobian, np.zeros(len(mass)), -gap)[: len(mass)]
        configuration = _moved(model, configuration, jnp.asarray(step))
    raise ConvergenceError(
        f"the joints could not be closed at the start: largest gap {largest:.3g} after 20 iterations. "
        "Place the bodies closer to a configuration in which every joint fits"
    )
