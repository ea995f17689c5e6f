"""Force of each contact on its nodes at one instant: the sum of its penalties, and its point of action."""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array

from supple.methods.explicit.frame_model import material_points
from supple.methods.explicit.march.march_model import MarchModel, MarchState, Methods
from supple.methods.explicit.march.nodal_forces import penalty
from supple.methods.explicit.march.touching_surface import projected, pushes

__all__ = ["march_contact_forces"]


def march_contact_forces(model: MarchModel, methods: Methods, state: MarchState) -> Array:
    """Force on the nodes of each contact, N, and their mean position weighted by the size of their forces.

    Returns (c, 6), contacts with rigid obstacles first, then those between parts. Without contact, the
    position is the mean of the nodes.
    """
    found: dict[int, Array] = {}

    def add(number: int, push: Array, x: Array) -> None:
        size = jnp.sqrt((push * push).sum(axis=0))
        share = jnp.where(size.sum() > 0, size, 1.0)
        place = (share * x).sum(axis=1) / share.sum()
        found[number] = jnp.concatenate([push.sum(axis=1), place])

    for touching, number in zip(model.touching, methods.obstacle_of, strict=True):
        x = state.x[:, touching.nodes]
        add(number, penalty(methods.obstacles[number], state.obstacles[number], touching, x), x)
    for arrays, own, numbers in zip(model.frames, state.frames, methods.frame_obstacles, strict=True):
        for touching, number in zip(arrays.touching, numbers, strict=True):
            assert touching.weights is not None
            assert touching.shapes is not None
            x = material_points(touching.weights, touching.shapes, own.p, own.y).T
            add(number, penalty(methods.obstacles[number], state.obstacles[number], touching, x), x)
    for number, surface in enumerate(model.surfaces, len(methods.obstacles)):
        add(number, pushes(surface, projected(surface, state.x)), state.x[:, surface.nodes])
    if not found:
        return jnp.zeros((0, 6))
    return jnp.stack([found[number] for number in range(len(found))])
