"""Machines that turn steadily: their motion at one instant, and their equations seen in axes that turn along.

A body that turns about an axis fixed in space has constant velocities in its own axes. Small motions about
that state are measured there as well: `p = (A^T dR, psi, e)`, with the velocities and accelerations

    V = dp/dt + S p,        a = dV/dt + S_R V,

`S` holding `w x` for the translation and the rotation of each frame, `S_R` for the translation alone; `w` in
the body's axes. Linear equations `M a + C V + K p` then have constant coefficients,

    M p'' + [ C + M (S + S_R) ] p' + [ K + C S + M S_R S ] p.

The last bracket is also the derivative of the unbalanced force of a steady state for its configuration.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from supple.algebra.rotation import skew
from supple.integrate import StepFactors
from supple.multibody.equations.balance import Balance, tangent
from supple.multibody.equations.configuration import AnyArray, Configuration, SystemMotion
from supple.multibody.equations.joint_force import constraint_rows
from supple.multibody.equations.model import Model
from supple.multibody.equations.places import Block, Places, assembled_matrix, assembled_vector, over

__all__ = ["LinearEquations", "Turning", "in_turning_axes", "linear_equations", "steady_motion"]


class Turning(NamedTuple):
    """How every body turns."""

    angular_velocities: AnyArray
    """(nb, 3), global"""
    point: AnyArray
    """(3,), on the axis"""


class LinearEquations(NamedTuple):
    """`M p'' + C p' + K p + G^T l = B u`, `G p = 0`, in axes that turn with the bodies."""

    mass: AnyArray
    """(n, n)"""
    damping: AnyArray
    """(n, n), with the gyroscopic terms"""
    stiffness: AnyArray
    """(n, n), with the centrifugal terms and those of the forces that are carried"""
    jacobian: AnyArray
    """(m, n)"""


def steady_motion(
    model: Model, turning: Turning, time: AnyArray, configuration: Configuration, multipliers: AnyArray
) -> SystemMotion:
    """The motion of bodies that turn without any other change of what they see."""
    w = turning.angular_velocities
    velocity = jnp.cross(w, configuration.origins - turning.point)
    in_body = jnp.einsum("bji,bj->bi", configuration.rotations, w)
    acceleration = jnp.cross(w, velocity)

    def of_frames(translation: jax.Array, rotation: jax.Array) -> jax.Array:
        frames = jnp.concatenate([translation, rotation], axis=1)
        return assembled_vector(model.n_velocities, [(model.frames, frames)])

    still = jnp.zeros_like(in_body)
    return SystemMotion(
        time, configuration, of_frames(velocity, in_body), of_frames(acceleration, still), multipliers
    )


def linear_equations(model: Model, turning: Turning, motion: SystemMotion, terms: Balance) -> LinearEquations:
    """The equations of motion, linearised about a steady motion, at which `terms` were evaluated."""
    mass, by_velocity, by_position = (
        _tangent(model, motion, terms, StepFactors(jnp.asarray(p), jnp.asarray(v)))
        for p, v in ((0.0, 0.0), (0.0, 1.0), (1.0, 0.0))
    )
    damping, stiffness = by_velocity - mass, by_position - mass
    axes = in_turning_axes(model, motion.configuration)
    mass, damping, stiffness = (axes.T @ each @ axes for each in (mass, damping, stiffness))
    frames, translations = _spins(model, turning, motion.configuration)
    return LinearEquations(
        mass=mass,
        damping=damping + mass @ (frames + translations),
        stiffness=stiffness + damping @ frames + mass @ translations @ frames,
        jacobian=constraint_rows(model, terms.linearization.joints) @ axes,
    )


def in_turning_axes(model: Model, configuration: Configuration) -> jax.Array:
    """Matrix (n, n) from small motions in the bodies' axes to increments of the configuration."""
    first, _ = _frame_places(model)
    rest = jnp.ones(model.n_velocities).at[first.index].set(0.0)
    turned = Block(first, first, configuration.rotations)
    return assembled_matrix((model.n_velocities, model.n_velocities), [turned]) + jnp.diag(rest)


def _tangent(model: Model, motion: SystemMotion, terms: Balance, factors: StepFactors) -> jax.Array:
    return tangent(model, motion, terms.linearization, jnp.zeros(model.n_velocities), factors)


def _spins(model: Model, turning: Turning, configuration: Configuration) -> tuple[jax.Array, jax.Array]:
    """`S` and `S_R`, (n, n)."""
    shape = model.n_velocities, model.n_velocities
    first, second = _frame_places(model)
    cross = over(skew, jnp.einsum("bji,bj->bi", configuration.rotations, turning.angular_velocities))
    translations = assembled_matrix(shape, [Block(first, first, cross)])
    return translations + assembled_matrix(shape, [Block(second, second, cross)]), translations


def _frame_places(model: Model) -> tuple[Places, Places]:
    """Where translations and rotations of the frames stand."""
    starts = model.frames.starts
    return Places(starts, 3), Places(tuple(start + 3 for start in starts), 3)
