"""How far the joints of a system stand open over a run: what the integrator leaves of g = 0."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from supple.body.full_body import FullBody
from supple.integrate import Solution
from supple.machine.system import System
from supple.multibody.equations.balance import Configuration, constraints
from supple.multibody.equations.model import Model, build_model

__all__ = ["joint_residuals"]


@jax.jit
def _gaps(model: Model, times: jax.Array, configurations: Configuration) -> jax.Array:
    return jax.vmap(lambda time, at: constraints(model, time, at))(times, configurations)


def joint_residuals(system: System, solution: Solution) -> np.ndarray:
    """Constraint equations g (t, m) of all joints at the output times: m and rad, zero where exact."""
    motions = [solution.bodies[placed.body.name] for placed in system.bodies]
    fulls = system.bodies_of(FullBody)

    def seen_by_joints(body: str) -> np.ndarray:
        # Of a full body the motions of its interfaces, which stand for it in the compiled equations.
        coordinates = solution.bodies[body].coordinates
        return coordinates @ fulls[body].interface_motions.T if body in fulls else coordinates

    configurations = Configuration(
        origins=jnp.stack([jnp.asarray(motion.position) for motion in motions], axis=1),
        rotations=jnp.stack([jnp.asarray(motion.rotation) for motion in motions], axis=1),
        coordinates=tuple(jnp.asarray(seen_by_joints(placed.body.name)) for placed in system.bodies),
    )
    return np.asarray(_gaps(build_model(system), jnp.asarray(solution.times), configurations))
