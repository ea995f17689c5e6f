"""Velocities and accelerations of stations: time derivatives of their positions."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.algebra.rotation import rotation_exp
from supple.equations.compiler_options import STARTING
from supple.equations.places import AnyArray
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.methods.intrinsic.line_equations import force_rates, section_strains, station_velocities
from supple.methods.intrinsic.line_model import LineModel
from supple.methods.intrinsic.strain_integration import StationPlaces, station_places
from supple.programs.program_cache import CachedProgram

__all__ = ["StationMotion", "driven_twists", "station_motion"]

Array = NDArray[np.float64]


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


class _Now(NamedTuple):
    """A line at an instant: q_1, q_2, its root, the drive's part of the root's twist, and rates."""

    q1: AnyArray
    q2: AnyArray
    rotation: AnyArray
    position: AnyArray
    velocity: AnyArray
    acceleration: AnyArray
    angular_velocity: AnyArray
    angular_acceleration: AnyArray
    driven: AnyArray
    q1_rate: AnyArray
    driven_rate: AnyArray


def station_motion(model: LineModel, root: Array, q2: Array, motion: IntrinsicMotion) -> StationMotion:
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
    driven, driven_rate = _driven(model, root, motion)
    now = _Now(
        motion.rates,
        q2,
        A,
        motion.position + arm,
        motion.velocity + np.einsum("tij,tj->ti", A, arm_rate),
        motion.acceleration + np.einsum("tij,tj->ti", A, np.cross(dw, root) + np.cross(w, arm_rate)),
        w,
        dw,
        driven,
        motion.accelerations,
        driven_rate,
    )
    found: StationMotion = jax.device_get(_motion(model, now))
    if unknown:
        none = jax.tree.map(lambda each: np.full_like(each, np.nan), found.accelerations)
        found = found._replace(accelerations=none)
    return found


def driven_twists(model: LineModel, root: Array, motion: IntrinsicMotion) -> Array:
    """x_1 = Phi_1 q_1 + T t_d (t, n, 6): velocities of stations along their axes, by modes and a drive."""
    driven, _ = _driven(model, root, motion)
    return (motion.rates @ np.asarray(model.velocities).T + driven @ np.asarray(model.twists).T).reshape(
        len(driven), -1, 6
    )


def _driven(model: LineModel, root: Array, motion: IntrinsicMotion) -> tuple[Array, Array]:
    """Part (t, 6) of the root's twist due to a drive, not to modes, along the root's axes; and its rate."""
    w, dw = motion.angular_velocity, motion.angular_acceleration
    velocity = np.einsum("tji,tj->ti", motion.rotation, motion.velocity) + np.cross(w, root)
    acceleration = np.einsum("tji,tj->ti", motion.rotation, motion.acceleration)
    acceleration += np.cross(dw, root) + np.cross(w, np.cross(w, root))
    # Rate of components along rotating axes.
    rate = np.hstack([acceleration - np.cross(w, velocity), dw])
    own = np.asarray(model.velocities)[:6].T
    return np.hstack([velocity, w]) - motion.rates @ own, rate - motion.accelerations @ own


def _motion_over_time(model: LineModel, over_time: _Now) -> StationMotion:
    def at(now: _Now) -> StationMotion:
        def strain_rate(q1: AnyArray, q2: AnyArray, driven: AnyArray) -> AnyArray:
            x1 = station_velocities(model, q1) + (model.twists @ driven).reshape(-1, 6)
            return force_rates(model, x1, q1, section_strains(model, q2))

        here = now.q1, now.q2, now.driven
        first = strain_rate(*here)
        second = jax.jvp(strain_rate, here, (now.q1_rate, first, now.driven_rate))[1]

        def places(s: AnyArray) -> StationPlaces:
            """Positions to second order in the time s from now."""
            turn = s * now.angular_velocity + s**2 / 2 * now.angular_acceleration
            return station_places(
                model,
                now.q2 + s * first + s**2 / 2 * second,
                now.rotation @ rotation_exp(turn),
                now.position + s * now.velocity + s**2 / 2 * now.acceleration,
            )

        def rates(s: AnyArray) -> tuple[StationPlaces, StationPlaces]:
            return jax.jvp(places, (s,), (jnp.ones(()),))

        (where, velocities), (_, accelerations) = jax.jvp(rates, (jnp.zeros(()),), (jnp.ones(()),))
        return StationMotion(where, velocities, accelerations, first, second)

    return jax.vmap(at)(over_time)


_motion = CachedProgram(_motion_over_time, STARTING)
