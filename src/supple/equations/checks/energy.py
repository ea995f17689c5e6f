"""Energies and momenta of a simulated system, at every output time."""

from __future__ import annotations

from functools import singledispatch
from typing import NamedTuple
from weakref import WeakKeyDictionary

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray
from supple.body import BodyForm, FullBody, RigidBody
from supple.equations.build_model import build_model
from supple.equations.floating_inertia import frame_momenta, kinetic_energy, velocity_fields
from supple.equations.full_inertia import FullInertia
from supple.equations.polynomial_force import Quartic, polynomial_energy
from supple.errors import ModelError
from supple.integrate import FloatingMotion, Motion, Solution
from supple.machine import Placed, System
from supple.programs.program_cache import CachedProgram
from supple.reduction import ReducedBody

__all__ = ["Balances", "balances"]

# Largest number of nodal values of a full body in memory at a time (8 MiB), for long runs of large bodies.
_FIELD_NUMBERS = 2**20


class Balances(NamedTuple):
    """Energies (t,) and momenta (t, 3) of the bodies; the energies of force elements are not included.

    Without damping, loads and prescribed motions `total` is constant; the momenta are constant only without
    gravity and without joints to the ground.
    """

    kinetic: AnyArray
    strain: AnyArray
    potential: AnyArray
    """In the uniform gravity field, zero at the global origin."""
    momentum: AnyArray
    """Linear momentum, global."""
    angular_momentum: AnyArray
    """About the global origin, global."""

    @property
    def total(self) -> AnyArray:
        """Kinetic, strain and potential energy together."""
        return self.kinetic + self.strain + self.potential


def balances(system: System, solution: Solution) -> Balances:
    """Energies and momenta of the whole system at the output times: the sum over its bodies."""
    system.check_has_frames()
    every = [
        body_balances(placed.body, solution.bodies[placed.body.name], system.gravity)
        for placed in system.bodies
    ]
    return Balances(*(np.asarray(sum(items)) for items in zip(*every, strict=True)))


@singledispatch
def body_balances(body: BodyForm, _motion: Motion, _gravity: np.ndarray) -> Balances:
    """Energies and momenta of one body; ModelError for a form of body without a registered function."""
    raise ModelError(f"body '{body.name}': the energies of a body of kind '{body.kind}' are not available")


@body_balances.register(RigidBody | ReducedBody)
def _(body: RigidBody | ReducedBody, motion: Motion, gravity: np.ndarray) -> Balances:
    """Energies and momenta of a rigid or reduced body, from its Gram matrix and tensors."""
    if body not in _ARRAYS:
        (group,) = build_model(System((Placed(body),))).groups
        arrays = _Arrays(group.gram, group.stiffness, group.cubic, group.quartic)
        _ARRAYS[body] = jax.tree.map(lambda leaf: np.asarray(leaf)[0], arrays)
    own = motion.of_type(FloatingMotion)
    velocities = own.velocity, own.angular_velocity, own.coordinate_rates
    places = own.position, own.rotation, own.coordinates
    return Balances(*map(np.asarray, _of_reduced_body(_ARRAYS[body], gravity, places, velocities)))


class _Arrays(NamedTuple):
    """Arrays of a rigid or reduced body."""

    gram: jax.Array
    stiffness: jax.Array
    cubic: jax.Array | None
    quartic: Quartic | None


_ARRAYS: WeakKeyDictionary[BodyForm, _Arrays] = WeakKeyDictionary()
"""Cache per body in use: cases of a sweep share bodies, and evaluate energies thousands of times."""


_Three = tuple[jax.Array, jax.Array, jax.Array]


def _over_time(body: _Arrays, gravity: jax.Array, places: _Three, velocities: _Three) -> Balances:
    """Energies and momenta of a rigid or reduced body at t times.

    places : position (t, 3) and rotation of its frame, and its coordinates (t, r)
    velocities : velocity and angular velocity (t, 3) of its frame, and the rates (t, r) of its coordinates
    """

    def at_one_time(places: _Three, velocities: _Three) -> Balances:
        (position, rotation, coordinates), (velocity, spin, rates) = places, velocities
        z = velocity_fields(coordinates, rotation.T @ velocity, spin, rates)
        linear, angular = frame_momenta(body.gram, coordinates, z)
        mass = body.gram[0, 0]
        centre = _first_moment(body.gram, coordinates)
        return Balances(
            kinetic=kinetic_energy(body.gram, z),
            strain=polynomial_energy(body.stiffness, body.cubic, body.quartic, coordinates),
            potential=-gravity @ (mass * position + rotation @ centre),
            momentum=rotation @ linear,
            angular_momentum=rotation @ angular + jnp.cross(position, rotation @ linear),
        )

    return jax.vmap(at_one_time)(places, velocities)


_of_reduced_body = CachedProgram(_over_time)


def _first_moment(gram: jax.Array, coordinates: jax.Array) -> jax.Array:
    """`sum m (x + u)` in body components, (3,): from `Phi_t^T M Phi_w(0) = -(m c)~`, and `Phi_t^T M V g`."""
    block = gram[:3, 3:6]
    rest = jnp.stack([block[1, 2], block[2, 0], block[0, 1]])
    return rest + gram[:3, 6 + 3 * coordinates.shape[0] :] @ coordinates


@body_balances.register
def _(full: FullBody, motion: FloatingMotion, gravity: np.ndarray) -> Balances:
    """Energies and momenta of a full body: `T = V^T M V / 2` of its nodes, and the strain energy."""
    inertia = FullInertia(full.body)
    size = max(1, _FIELD_NUMBERS // full.body.n_nodal)
    parts = [
        _at_instants(inertia, gravity, motion.at(slice(start, start + size)))
        for start in range(0, len(motion.position), size)
    ]
    return Balances(*(np.concatenate(items) for items in zip(*parts, strict=True)))


def _at_instants(inertia: FullInertia, gravity: np.ndarray, motion: FloatingMotion) -> Balances:
    """Energies and momenta of a full body, at times whose coordinates (n, t) fit in memory together."""
    rotation = motion.rotation
    local = inertia.momenta(
        motion.coordinates.T,
        motion.coordinate_rates.T,
        motion.angular_velocity.T,
        np.einsum("tji,tj->it", rotation, motion.velocity),
    )
    centre, linear, angular = (
        np.einsum("tij,jt->ti", rotation, vectors)
        for vectors in (inertia.first_moment(motion.coordinates.T), local.linear, local.angular)
    )
    return Balances(
        kinetic=local.kinetic,
        strain=inertia.body.force.energies(motion.coordinates.T),
        potential=-(inertia.mass * motion.position + centre) @ gravity,
        momentum=linear,
        angular_momentum=angular + np.cross(motion.position, linear),
    )
