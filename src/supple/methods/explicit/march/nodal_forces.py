"""Forces on the explicit nodes at one instant: elements, contact, weight and loads."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import Array

from supple.machine.obstacles import Obstacle
from supple.methods.explicit.elements import block_force, layered_force, shell_force
from supple.methods.explicit.march.frame_forces import gravity_at
from supple.methods.explicit.march.model import MarchModel, Methods, NodesTouching, ObstacleState
from supple.methods.explicit.march.touching_surface import surface_penalty
from supple.methods.explicit.materials.plane_stress import LayerState

__all__ = ["NodalForces", "nodal_forces", "penalty"]


class NodalForces(NamedTuple):
    """At t_n.

    forces : (4, 3, N) internal, hourglass, contact, external
    materials, ratios, alive : of the blocks;   layers, shells_alive : of those of shells
    on_obstacles : (o, 3);   moments : (3, r) on the triads of shells
    plastic, viscous : work of the step that led here, J;   smallest : det F of the worst point
    """

    forces: Array
    materials: tuple[Any, ...]
    ratios: tuple[Array, ...]
    alive: tuple[Array, ...]
    layers: tuple[LayerState | None, ...]
    shells_alive: tuple[Array, ...]
    on_obstacles: Array
    moments: Array
    plastic: Array
    viscous: Array
    smallest: Array


def nodal_forces(
    model: MarchModel,
    methods: Methods,
    time: Array,
    x: Array,
    dx: Array,
    h: Array,
    materials: tuple[Any, ...],
    ratios: tuple[Array, ...],
    alive: tuple[Array, ...],
    layers: tuple[LayerState | None, ...],
    shells_alive: tuple[Array, ...],
    obstacles: tuple[ObstacleState, ...],
    triads: Array,
) -> NodalForces:
    """At positions x (3, N), reached by the increment dx in a step h (any number where dx is zero)."""
    internal, hourglass = jnp.zeros_like(x), jnp.zeros_like(x)
    plastic, viscous, smallest = jnp.zeros(()), jnp.zeros(()), jnp.ones(())
    states, reached, living = [], [], []
    for law, limit, block, beta, state, ratio, live in zip(
        methods.laws, methods.deletions, model.blocks, model.betas, materials, ratios, alive, strict=True
    ):
        out = block_force(law, block, x, dx, state, ratio, live, beta, h)
        internal, hourglass = internal + out.force, hourglass + out.hourglass
        plastic, viscous = plastic + out.plastic, viscous + out.viscous
        smallest = jnp.minimum(smallest, out.smallest)
        states.append(out.state)
        reached.append(out.ratios)
        strain = law.plastic_strain(out.state)
        if strain is not None and limit != float("inf"):
            live = live * (strain.max(axis=0) < limit)  # noqa: PLW2901 - the next step's
        living.append(live)
    moments = jnp.zeros((3, triads.shape[2]))
    bent, standing = [], []
    for law, limit, shell, state, live in zip(
        methods.shell_laws, methods.shell_deletions, model.shells, layers, shells_alive, strict=True
    ):
        if law is None or state is None:
            pull = shell_force(shell, x, triads)
            bent.append(None)
        else:
            pull = layered_force(law, shell, x, triads, state, live)
            plastic = plastic + pull.plastic
            bent.append(pull.state)
            if limit != float("inf"):
                live = live * (pull.state.strain.max(axis=(0, 1)) < limit)  # noqa: PLW2901 - the next step's
        standing.append(live)
        internal, moments = internal + pull.force, moments + pull.moment
    contact, on_obstacles = jnp.zeros_like(x), jnp.zeros((len(methods.obstacles), 3))
    for touching, number in zip(model.touching, methods.obstacle_of, strict=True):
        push = penalty(methods.obstacles[number], obstacles[number], touching, x[:, touching.nodes])
        contact = contact.at[:, touching.nodes].add(push)
        on_obstacles = on_obstacles.at[number].add(-push.sum(axis=1))
    for surface in model.surfaces:
        contact = contact + surface_penalty(surface, x)
    external = model.mass * gravity_at(model, time)[:, None]
    for nodes, shared, law in model.loaded:
        external = external.at[:, nodes].add(jnp.broadcast_to(law(time) / shared, (len(nodes), 3)).T)
    return NodalForces(
        jnp.stack([internal, hourglass, contact, external]),
        tuple(states),
        tuple(reached),
        tuple(living),
        tuple(bent),
        tuple(standing),
        on_obstacles,
        moments,
        plastic,
        viscous,
        smallest,
    )


def penalty(obstacle: Obstacle, at: ObstacleState, touching: NodesTouching, x: Array) -> Array:
    """Forces (3, n) of an obstacle on points x (3, n)."""
    gap, normal = obstacle.gap(x - at.offset[:, None])
    return touching.stiffness * jnp.maximum(-gap, 0.0) * normal
