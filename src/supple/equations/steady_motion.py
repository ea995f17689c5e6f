"""Machines in steady rotation: their motion at one time, and their equations in co-rotating axes.

A body that rotates about a fixed axis has constant velocities in its own axes. Small motions about that state
are measured in these axes: `p = (A^T dR, psi, e)`, with the velocities and accelerations

    V = dp/dt + S p,        a = dV/dt + S_R V,

with `S` the operator `w x` for the translation and rotation of each frame, `S_R` for translation only; `w`
in the body's axes. Linear equations `M a + C V + K p` then have constant coefficients,

    M p'' + [ C + M (S + S_R) ] p' + [ K + C S + M S_R S ] p.

The last bracket is also the derivative of the unbalanced force of a steady state by its configuration.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.cross import cross_matrices
from supple.arrays import AnyArray
from supple.equations.balance import Balance, Linearization, tangent
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import Configuration, SystemMotion
from supple.equations.control_force import resting_control
from supple.equations.control_linearization import LinearControl, control_at_rest
from supple.equations.joint_force import joint_rows
from supple.equations.machine_model import Model
from supple.integrate import StepFactors
from supple.machine import GROUND
from supple.programs.program_cache import CachedProgram

_LARGE = 2.0**300
"""A power of two: scaling by it causes no rounding."""


class SteadyRotation(NamedTuple):
    """Steady rotation of all bodies."""

    angular_velocities: AnyArray
    """(nb, 3), global"""
    point: AnyArray
    """(3,), on the axis"""

    def by_body(self, names: Sequence[str]) -> dict[str, np.ndarray]:
        """Angular velocity (3,) of each body, by name, and that of the ground, zero."""
        rates = dict(zip(names, np.asarray(self.angular_velocities), strict=True))
        return rates | {GROUND.body: np.zeros(3)}


@dataclass(frozen=True, eq=False)
class SteadyEquations:
    """Data of the `Equations` of all methods: a machine, its start, its rotation, and subtracted forces.

    machine : Any               prepared for its method, with independent equations
    begin : Any                 state with bodies as placed
    turning : SteadyRotation | None      rotation of the bodies in their order; None at rest
    held : (n,)                 forces subtracted during the search
    """

    machine: Any
    begin: Any
    turning: SteadyRotation | None = None
    held: np.ndarray | float = 0.0

    def at_rest(self) -> Self:
        """The machine without its rotation."""
        return replace(self, turning=None)

    def eased(self, share: float, held: np.ndarray) -> Self:
        """The machine at a share of its angular velocity; the forces `held` (n,) are subtracted."""
        turning = self.turning
        if turning is not None:
            turning = turning._replace(angular_velocities=share * np.asarray(turning.angular_velocities))
        return replace(self, turning=turning, held=held)

    @property
    def model(self) -> Model:
        """The model for joints and forces."""
        return self.machine.model

    @property
    def slices(self) -> tuple[slice, ...]:
        """Positions of the motions of each body in the linear equations."""
        return self.machine.slices

    def moved(self, configuration: Any, increment: np.ndarray) -> Any:
        """The configuration after an increment (n,)."""
        return self.machine.moved(configuration, increment)

    def bodies_at(self, configuration: Any) -> Configuration:
        """The configuration of the bodies; here the configuration itself."""
        return configuration


class LinearEquations(NamedTuple):
    """`M p'' + C p' + K p + G^T l = H z`, `G p = 0`, in axes that rotate with the bodies."""

    mass: AnyArray
    """(n, n)"""
    damping: AnyArray
    """(n, n), with the gyroscopic terms"""
    stiffness: AnyArray
    """(n, n), with the centrifugal terms and those of the internal and joint forces"""
    constraint: AnyArray
    """`G` (m, n)"""
    control: LinearControl
    """States z of controllers: `z' = E_p p + E_v p' + E_z z`"""

    def damped(self, motions: AnyArray) -> AnyArray:
        """`C p` of motions (n, k)."""
        return self.damping @ motions


def steady_motion(
    model: Model,
    turning: SteadyRotation,
    time: float,
    configuration: Configuration,
    multipliers: AnyArray,
    states: AnyArray,
) -> SystemMotion:
    """The motion of bodies in steady rotation, with constant coordinates.

    states : of all controllers, one after the other
    """
    velocity, acceleration = turning_velocities(
        turning, configuration, model.frames.starts, model.n_velocities
    )
    control = resting_control(model, states)
    return SystemMotion(np.asarray(float(time)), configuration, velocity, acceleration, multipliers, control)


def work_of_turning(model: Model, turning: SteadyRotation) -> float:
    """Work of the inertia forces of a rotating machine, as if all its mass were at a radius of its size."""
    rate = np.max(np.linalg.norm(turning.angular_velocities, axis=1))
    return float(model.mass * (rate * model.length) ** 2)


def turning_velocities(
    turning: SteadyRotation, configuration: Configuration, frame_starts: Sequence[int], n: int
) -> tuple[np.ndarray, np.ndarray]:
    """Velocities and accelerations (n,) of bodies in steady rotation; `frame_starts` locates their frames.

    The angular velocities are constant, in space and in the body's axes.
    """
    w = turning.angular_velocities
    velocity, acceleration = np.zeros((2, n))
    places = np.array(frame_starts)[:, None] + np.arange(3)
    moving = np.cross(w, configuration.origins - turning.point)
    velocity[places] = moving
    velocity[places + 3] = np.einsum("bji,bj->bi", configuration.rotations, w)
    acceleration[places] = np.cross(w, moving)
    return velocity, acceleration


def linear_equations(
    model: Model, turning: SteadyRotation, motion: SystemMotion, terms: Balance
) -> LinearEquations:
    """The equations of motion, linearised about a steady motion; `terms` were evaluated there."""
    mass = dynamic_stiffness(model, motion, terms, 0.0, 0.0)
    # The factor is so large that adding the mass does not change the product, in any unit of time.
    damping = (dynamic_stiffness(model, motion, terms, 0.0, _LARGE) - mass) / _LARGE
    stiffness = (dynamic_stiffness(model, motion, terms, _LARGE, 0.0) - mass) / _LARGE
    axes = in_turning_axes(model, motion.configuration)
    mass, damping, stiffness = (axes.T @ each @ axes for each in (mass, damping, stiffness))
    frames, translations = _spins(model, turning, motion.configuration)
    control = control_at_rest(model, motion).linear.along(axes)
    return LinearEquations(
        mass=mass,
        damping=damping + mass @ (frames + translations),
        stiffness=stiffness + damping @ frames + mass @ translations @ frames,
        constraint=np.asarray(joint_rows(model, terms.linearization.joints)) @ axes,
        control=control._replace(by_position=control.by_position + control.by_velocity @ frames),
    )


def dynamic_stiffness(
    model: Model, motion: SystemMotion, terms: Balance, by_position: float, by_velocity: float
) -> np.ndarray:
    """`M + by_velocity C + by_position K` (n, n), by one compiled program for all factors."""
    factors = StepFactors(np.asarray(by_position), np.asarray(by_velocity))
    return np.asarray(_tangent(model, motion, terms.linearization, factors))


def _tangent_of_step(
    model: Model, motion: SystemMotion, linearization: Linearization, factors: StepFactors
) -> jax.Array:
    return tangent(model, motion, linearization, jnp.zeros(model.n_velocities), factors)


_tangent = CachedProgram(_tangent_of_step, STARTING)


def in_turning_axes(model: Model, configuration: Configuration) -> np.ndarray:
    """Matrix (n, n) from small motions in the bodies' axes to increments of the configuration."""
    return frame_axes(model.n_velocities, model.frames.starts, np.asarray(configuration.rotations))


def frame_axes(n: int, starts: Iterable[int], rotations: np.ndarray) -> np.ndarray:
    """Matrix (n, n) that rotates the translational velocities of frames, from `starts` on, to global axes."""
    axes = np.eye(n)
    for start, rotation in zip(starts, rotations, strict=True):
        axes[start : start + 3, start : start + 3] = rotation
    return axes


def _spins(
    model: Model, turning: SteadyRotation, configuration: Configuration
) -> tuple[np.ndarray, np.ndarray]:
    """`S` and `S_R`, (n, n)."""
    frames, translations = np.zeros((2, model.n_velocities, model.n_velocities))
    in_body = np.einsum("bji,bj->bi", configuration.rotations, turning.angular_velocities)
    for start, spin in zip(model.frames.starts, cross_matrices(in_body), strict=True):
        first, second = slice(start, start + 3), slice(start + 3, start + 6)
        translations[first, first] = frames[first, first] = frames[second, second] = spin
    return frames, translations
