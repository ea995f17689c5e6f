"""Forces on the explicit nodes at one instant: elements, contact, weight and loads."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from supple.equations.nodal_load import nodal_forces
from supple.methods.explicit.elements import BlockState, ElementInstant
from supple.methods.explicit.march.frame_forces import gravity_at
from supple.methods.explicit.march.march_model import MarchModel, ObstacleState
from supple.methods.explicit.march.touching_surface import surface_penalty


class AssembledForces(NamedTuple):
    """Forces at t_n.

    forces : (4, 3, N) internal, hourglass, contact, external;   blocks : state of each block
    on_obstacles : (o, 3) forces on the obstacles;   moments : (3, r) on the triads of shells
    plastic, viscous : work of the step that led here, J;   smallest : smallest det F of remaining elements
    """

    forces: Array
    blocks: tuple[BlockState, ...]
    on_obstacles: Array
    moments: Array
    plastic: Array
    viscous: Array
    smallest: Array


def explicit_forces(
    model: MarchModel,
    time: Array,
    at: ElementInstant,
    blocks: tuple[BlockState, ...],
    obstacles: tuple[ObstacleState, ...],
) -> AssembledForces:
    """Forces at an instant. If the increment `at.dx` is zero, the step `at.h` may be any positive number."""
    x = at.x
    internal, hourglass = jnp.zeros_like(x), jnp.zeros_like(x)
    plastic, viscous, smallest = jnp.zeros(()), jnp.zeros(()), jnp.ones(())
    moments, reached = jnp.zeros((3, at.triads.shape[2])), []
    for block, state in zip(model.blocks, blocks, strict=True):
        out = block.force(at, state)
        reached.append(out.state)
        internal = internal + out.force
        hourglass = hourglass if out.hourglass is None else hourglass + out.hourglass
        moments = moments if out.moment is None else moments + out.moment
        plastic = plastic if out.plastic is None else plastic + out.plastic
        viscous = viscous if out.viscous is None else viscous + out.viscous
        smallest = smallest if out.smallest is None else jnp.minimum(smallest, out.smallest)
    contact, on_obstacles = jnp.zeros_like(x), jnp.zeros((len(obstacles), 3))
    for touching in model.touching:
        push = touching.push(obstacles, x[:, touching.nodes])
        contact = contact.at[:, touching.nodes].add(push)
        on_obstacles = on_obstacles.at[touching.number].add(-push.sum(axis=1))
    for surface in model.surfaces:
        contact = contact + surface_penalty(surface, x)
    external = model.mass * gravity_at(model, time)[:, None]
    for nodes, shared, law in model.loaded:
        external = external.at[:, nodes].add(jnp.broadcast_to(law(time) / shared, (len(nodes), 3)).T)
    for nodes, load in model.pressed:
        external = external.at[:, nodes].add(nodal_forces(load, x[:, nodes].T, jnp.eye(3), time).T)
    return AssembledForces(
        jnp.stack([internal, hourglass, contact, external]),
        tuple(reached),
        on_obstacles,
        moments,
        plastic,
        viscous,
        smallest,
    )
