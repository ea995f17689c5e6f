"""Forces of contacts at one instant, their points of action, and the energy stored in penalties."""

from __future__ import annotations

from collections.abc import Iterator

import jax.numpy as jnp
from jax import Array

from supple.methods.explicit.frame_model import material_points
from supple.methods.explicit.march.march_model import MarchModel, MarchState
from supple.methods.explicit.march.touching_surface import projected, pushes


def march_contact_forces(model: MarchModel, state: MarchState) -> Array:
    """Force on the nodes of each contact, N, and their mean position weighted by the size of their forces.

    Returns (c, 6), contacts with rigid obstacles first, then those between parts. Without contact, the
    position is the mean of the nodes.
    """
    found: dict[int, Array] = {}
    for number, push, x, _ in _pushes(model, state):
        size = jnp.sqrt((push * push).sum(axis=0))
        share = jnp.where(size.sum() > 0, size, 1.0)
        place = (share * x).sum(axis=1) / share.sum()
        found[number] = jnp.concatenate([push.sum(axis=1), place])
    if not found:
        return jnp.zeros((0, 6))
    return jnp.stack([found[number] for number in range(len(found))])


def contact_energy(model: MarchModel, state: MarchState) -> Array:
    """Energy stored in all penalties at an instant, J."""
    own = (0.5 * jnp.sum(push * push / k) for _, push, _, k in _pushes(model, state))
    return sum(own, jnp.zeros(()))


def _pushes(model: MarchModel, state: MarchState) -> Iterator[tuple[int, Array, Array, Array]]:
    """Number of each contact, forces (3, n) on its nodes, their positions (3, n) and stiffness (n,)."""
    touching = [(each, state.x[:, each.nodes]) for each in model.touching]
    for arrays, own in zip(model.frames, state.frames, strict=True):
        touching += [
            (each, material_points(each.weights, each.shapes, own.p, own.y).T) for each in arrays.touching
        ]
    for each, x in touching:
        yield each.number, each.push(state.obstacles, x), x, each.stiffness
    for number, surface in enumerate(model.surfaces, len(state.obstacles)):
        push = pushes(surface, projected(surface, state.x))
        yield number, push, state.x[:, surface.nodes], surface.stiffness
