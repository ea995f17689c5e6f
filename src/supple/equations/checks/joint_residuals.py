"""How far the joints of a system stand open over a run: what the integrator leaves of g = 0."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from supple.equations.build_model import build_model, seen_coordinates
from supple.equations.configuration import Configuration
from supple.equations.joint_force import constraints
from supple.equations.model import Model
from supple.integrate import Solution
from supple.machine import System

__all__ = ["joint_residuals"]


@jax.jit
def _residuals(model: Model, times: jax.Array, configurations: Configuration) -> jax.Array:
    return jax.vmap(lambda time, at: constraints(model, time, at))(times, configurations)


def joint_residuals(system: System, solution: Solution) -> np.ndarray:
    """Constraint equations g (t, m) of all joints at the output times: m and rad, zero where exact."""
    motions = [solution.bodies[placed.body.name] for placed in system.bodies]
    configurations = Configuration(
        origins=jnp.stack([jnp.asarray(motion.position) for motion in motions], axis=1),
        rotations=jnp.stack([jnp.asarray(motion.rotation) for motion in motions], axis=1),
        coordinates=jnp.concatenate(
            [
                jnp.asarray(seen_coordinates(placed.body, motion.coordinates))
                for placed, motion in zip(system.bodies, motions, strict=True)
            ],
            axis=1,
        ),
    )
    return np.asarray(_residuals(build_model(system), jnp.asarray(solution.times), configurations))
