"""Velocities and accelerations of stations: time derivatives of their positions."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.rotation import rotation_exp
from supple.arrays import AnyArray, FloatArray
from supple.equations.compiler_options import STARTING
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.methods.intrinsic.line_equations import force_rates, section_strains, station_velocities
from supple.methods.intrinsic.line_model import LineModel
from supple.methods.intrinsic.strain_integration import StationPlaces, station_places
from supple.programs.program_cache import CachedProgram


class StationMotion(NamedTuple):
    """Stations over time, and their first and second derivatives.

    places, velocities, accelerations : rotations (t, n, 3, 3) and positions (t, n, 3), and their derivatives
    strain_rates, strain_accelerations : (t, e)     first and second derivatives of the amplitudes q_2
    """

    places: StationPlaces
    velocities: StationPlaces
    accelerations: StationPlaces
    strain_rates: AnyArray
    strain_accelerations: AnyArray


_Derivatives = tuple[AnyArray, ...]
"""A quantity and its time derivatives."""


def station_motion(
    model: LineModel, root: FloatArray, q2: FloatArray, motion: IntrinsicMotion
) -> StationMotion:
    """Positions of the stations from the strains, and time derivatives; q_2' follows from the velocities.

    The velocities are thus derivatives of the reported positions. The modal velocities, whose energy and
    momentum the time integration conserves, differ by terms of second order in the segment length.

    root : (3,)     position of the root in the body's axes
    q2 : (t, e)     amplitudes of the strains in the motion
    """
    unknown = np.isnan(motion.accelerations).any()
    if unknown:  # velocities do not depend on accelerations
        names = ("acceleration", "angular_acceleration", "accelerations")
        motion = replace(motion, **{name: np.zeros_like(getattr(motion, name)) for name in names})
    A, w, dw = motion.rotation, motion.angular_velocity, motion.angular_acceleration
    arm, arm_rate = np.einsum("tij,j->ti", A, root), np.cross(w, root)
    root_motion = (
        motion.position + arm,
        motion.velocity + np.einsum("tij,tj->ti", A, arm_rate),
        motion.acceleration + np.einsum("tij,tj->ti", A, np.cross(dw, root) + np.cross(w, arm_rate)),
    )
    amplitudes, driven = (motion.rates, motion.accelerations), _driven(model, root, motion)
    found: StationMotion = jax.device_get(_motion(model, q2, amplitudes, root_motion, (A, w, dw), driven))
    if unknown:
        none = jax.tree.map(lambda each: np.full_like(each, np.nan), found.accelerations)
        found = found._replace(accelerations=none)
    return found


def driven_twists(model: LineModel, root: FloatArray, motion: IntrinsicMotion) -> FloatArray:
    """x_1 = Phi_1 q_1 + T t_d (t, n, 6): velocities of stations along their axes, by modes and a drive."""
    driven, _ = _driven(model, root, motion)
    return (motion.rates @ np.asarray(model.velocities).T + driven @ np.asarray(model.twists).T).reshape(
        len(driven), -1, 6
    )


def _driven(model: LineModel, root: FloatArray, motion: IntrinsicMotion) -> tuple[FloatArray, FloatArray]:
    """Part (t, 6) of the root's twist due to a drive, not to modes, along the root's axes; and its rate."""
    w, dw = motion.angular_velocity, motion.angular_acceleration
    velocity = np.einsum("tji,tj->ti", motion.rotation, motion.velocity) + np.cross(w, root)
    acceleration = np.einsum("tji,tj->ti", motion.rotation, motion.acceleration)
    acceleration += np.cross(dw, root) + np.cross(w, np.cross(w, root))
    # Rate of components along rotating axes.
    rate = np.hstack([acceleration - np.cross(w, velocity), dw])
    own = np.asarray(model.velocities)[:6].T
    return np.hstack([velocity, w]) - motion.rates @ own, rate - motion.accelerations @ own


def _motion_at(
    model: LineModel,
    q2: AnyArray,
    amplitudes: _Derivatives,
    root: _Derivatives,
    rotation: _Derivatives,
    driven: _Derivatives,
) -> StationMotion:
    """Stations at an instant, from q_2; q_1; position and rotation of the root; twist of its drive."""
    (q1, q1_rate), (twist, twist_rate) = amplitudes, driven
    (position, velocity, acceleration), (turned, w, dw) = root, rotation

    def strain_rate(q1: AnyArray, q2: AnyArray, driven: AnyArray) -> AnyArray:
        x1 = station_velocities(model, q1) + (model.twists @ driven).reshape(-1, 6)
        return force_rates(model, x1, q1, section_strains(model, q2))

    here = q1, q2, twist
    first = strain_rate(*here)
    second = jax.jvp(strain_rate, here, (q1_rate, first, twist_rate))[1]

    def places(s: AnyArray) -> StationPlaces:
        """Positions to second order in the time s from now."""
        strains = q2 + s * first + s**2 / 2 * second
        place = position + s * velocity + s**2 / 2 * acceleration
        return station_places(model, strains, turned @ rotation_exp(s * w + s**2 / 2 * dw), place)

    def rates(s: AnyArray) -> tuple[StationPlaces, StationPlaces]:
        return jax.jvp(places, (s,), (jnp.ones(()),))

    (where, velocities), (_, accelerations) = jax.jvp(rates, (jnp.zeros(()),), (jnp.ones(()),))
    return StationMotion(where, velocities, accelerations, first, second)


def _motion_over_time(model: LineModel, *known: AnyArray | _Derivatives) -> StationMotion:
    return jax.vmap(partial(_motion_at, model))(*known)


_motion = CachedProgram(_motion_over_time, STARTING)
