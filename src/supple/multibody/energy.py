"""Energies and momenta of a simulated system of rigid and reduced bodies, at every output time."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.errors import ModelError
from supple.integrate import Solution
from supple.multibody.equations import AnyArray
from supple.multibody.floating_inertia import FloatingMotion, frame_momenta, kinetic_energy
from supple.multibody.full_body import FullBody
from supple.multibody.model import BodyArrays, build_model
from supple.multibody.polynomial_force import polynomial_energy
from supple.multibody.system import System

__all__ = ["Balances", "balances"]


class Balances(NamedTuple):
    """What a free conservative system keeps, (t,) or (t, 3)."""

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


class _Motion(NamedTuple):
    """The parts of a `BodyMotion` that energies need, as a pytree."""

    position: jax.Array
    rotation: jax.Array
    coordinates: jax.Array
    velocity: jax.Array
    angular_velocity: jax.Array
    coordinate_rates: jax.Array


@jax.jit
def _of_body(body: BodyArrays, gravity: jax.Array, motion: _Motion) -> Balances:
    def at_one_time(now: _Motion) -> Balances:
        position, rotation, coordinates = now.position, now.rotation, now.coordinates
        floating = FloatingMotion(
            coordinates,
            now.angular_velocity,
            now.coordinate_rates,
            jnp.zeros(3),
            jnp.zeros(3),
            jnp.zeros_like(coordinates),
        )
        local_velocity = rotation.T @ now.velocity
        linear, angular = frame_momenta(body.gram, floating, local_velocity)
        mass = body.gram[0, 0]
        # The row of the Gram matrix for translations against turning holds the first moments, skewed.
        centre = _first_moment(body.gram, coordinates)
        return Balances(
            kinetic=kinetic_energy(body.gram, floating, local_velocity),
            strain=polynomial_energy(body.stiffness, body.cubic, body.quartic, coordinates),
            potential=-gravity @ (mass * position + rotation @ centre),
            momentum=rotation @ linear,
            angular_momentum=rotation @ angular + jnp.cross(position, rotation @ linear),
        )

    return jax.vmap(at_one_time)(motion)


def _first_moment(gram: jax.Array, coordinates: jax.Array) -> jax.Array:
    """`sum m (x + u)` in body components, (3,), from `Phi_t^T M (Phi_w0 + g_k Phi_k) = -(m c)~`."""
    r = coordinates.shape[0]
    coupling = gram[:3, 6 : 6 + 3 * r].reshape(3, r, 3)
    block = gram[:3, 3:6] + jnp.einsum("ikj,k->ij", coupling, coordinates)
    return jnp.stack([block[1, 2], block[2, 0], block[0, 1]])


def balances(system: System, solution: Solution) -> Balances:
    """Energies and momenta of the whole system at the output times.

    Raises
    ------
    ModelError      a body with all its finite-element freedoms: only rigid and reduced bodies are supported
    """
    for placed in system.bodies:
        if isinstance(placed.body, FullBody):
            raise ModelError(f"energies of the full body '{placed.body.name}' are not available: reduce it")
    model = build_model(system)
    parts = []
    for placed, body in zip(system.bodies, model.bodies, strict=True):
        motion = solution.bodies[placed.body.name]
        parts.append(
            _of_body(
                body,
                jnp.asarray(system.gravity),
                _Motion(*(jnp.asarray(getattr(motion, name)) for name in _Motion._fields)),
            )
        )
    return Balances(*(np.asarray(sum(items)) for items in zip(*parts, strict=True)))
