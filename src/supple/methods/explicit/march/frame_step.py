"""A step of the modal sub-domains, with what the explicit nodes that hang on them pass on."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from supple.methods.explicit.frame_model import (
    FrameState,
    Generalized,
    Steps,
    elastic_force,
    gravity_force,
    material_points,
    point_forces,
    spin_force,
)
from supple.methods.explicit.frame_moments import arms, spread
from supple.methods.explicit.march.model import FrameArrays, MarchModel, MarchState, Methods
from supple.methods.explicit.march.nodal_forces import penalty
from supple.methods.explicit.projected_difference import ProjectedDifference

__all__ = ["FrameStep", "frame_step", "hanging"]


class FrameStep(NamedTuple):
    """Frames after the step, and works over it, J: internal, damping, external, contact, from nodes, turning.

    on_obstacles : (o, 3) forces at t_n
    """

    frames: tuple[FrameState, ...]
    internal: Array
    damping: Array
    external: Array
    contact: Array
    from_nodes: Array
    turning: Array
    on_obstacles: Array


def frame_step(model: MarchModel, methods: Methods, state: MarchState, h: Array) -> FrameStep:
    """All frames from t_n to t_n + h; their forces are those of t_n."""
    steps = Steps(state.frame_before, h)
    forces = []
    on_obstacles = jnp.zeros((len(methods.obstacles), 3))
    # Weight of the nodes that hang on a frame is in the frame's own mass already.
    pulls = state.forces.sum(axis=0) - model.mass * model.gravity[:, None]
    for arrays, own, numbers in zip(model.frames, state.frames, methods.frame_obstacles, strict=True):
        sums = spread(arrays.model.moments, own.y)
        external = gravity_force(sums, own.p, model.gravity)
        for weights, shapes, shared, law, own_axes in arrays.loaded:
            share = law(state.time) / shared
            if own_axes is not None:
                share = arms(own.p) @ (own_axes @ share) / jnp.sqrt(arrays.model.squared_lengths[0])
            pushes = jnp.broadcast_to(share, (len(weights), 3))
            external = external + point_forces(weights, shapes, own.p, own.y, pushes)
        contact = Generalized(jnp.zeros((4, 3)), jnp.zeros_like(own.y))
        for touching, number in zip(arrays.touching, numbers, strict=True):
            assert touching.weights is not None
            assert touching.shapes is not None
            x = material_points(touching.weights, touching.shapes, own.p, own.y)
            push = penalty(methods.obstacles[number], state.obstacles[number], touching, x.T)
            contact = contact + point_forces(touching.weights, touching.shapes, own.p, own.y, push.T)
            on_obstacles = on_obstacles.at[number].add(-push.sum(axis=1))
        pulled = point_forces(arrays.weights, arrays.shapes, own.p, own.y, pulls[:, arrays.nodes].T)
        forces.append((external, contact, pulled))
    frames, turning = _advanced(model, methods, state.frames, [a + b + c for a, b, c in forces], steps)
    works = jnp.zeros(5)
    for arrays, own, new, force in zip(model.frames, state.frames, frames, forces, strict=True):
        works = works + _works(arrays, own, new, force, steps)
    internal, damping, external, contact, from_nodes = works
    return FrameStep(frames, internal, damping, external, contact, from_nodes, turning, on_obstacles)


def _advanced(
    model: MarchModel,
    methods: Methods,
    frames: tuple[FrameState, ...],
    forces: list[Generalized],
    steps: Steps,
) -> tuple[tuple[FrameState, ...], Array]:
    """The frames after the step, those that are tied to each other together; and their turning work, J."""
    scheme = methods.explicit.scheme
    after, links = list(frames), [jnp.zeros(6)] * len(frames)
    tied = sorted({number for pair in methods.tied for number in pair})
    for number in range(len(frames)):
        if number not in tied:
            after[number], links[number] = scheme.step(
                model.frames[number].model, frames[number], forces[number], steps
            )
    turning = jnp.zeros(())
    if tied:
        assert isinstance(scheme, ProjectedDifference)  # checked when built
        pairs = tuple((tied.index(a), tied.index(b)) for a, b in methods.tied)
        new, pulled, pulls = scheme.step_tied(
            tuple(model.frames[number].model for number in tied),
            tuple(frames[number] for number in tied),
            tuple(forces[number] for number in tied),
            model.ties,
            pairs,
            steps,
        )
        for number, state, link in zip(tied, new, pulled, strict=True):
            after[number], links[number] = state, link
        first = 0
        for tie, (a, b) in zip(model.ties, methods.tied, strict=True):
            own = pulls[first : first + len(tie.first.weights)]
            turning = turning + scheme.tied_work(
                tie, (frames[a], frames[b]), (after[a], after[b]), own, steps
            )
            first += len(own)
    for arrays, old, new, link in zip(model.frames, frames, after, links, strict=True):
        turning = turning + scheme.turning_work(arrays.model, old, new, link, steps)
    return tuple(after), turning


def hanging(arrays: FrameArrays, frame: FrameState) -> Array:
    """Positions (3, n) of the explicit nodes that hang on a frame."""
    return material_points(arrays.weights, arrays.shapes, frame.p, frame.y).T


def _works(
    arrays: FrameArrays, old: FrameState, new: FrameState, forces: tuple[Generalized, ...], steps: Steps
) -> Array:
    """Internal, damping, external, contact, from the nodes: force times mean rate times mean step."""
    vp, vy = 0.5 * (old.vp + new.vp), 0.5 * (old.vy + new.vy)
    model = arrays.model
    elastic = (elastic_force(model, old.y, jnp.zeros_like(old.y)) + spin_force(model, old, new)) @ vy
    drag = model.mass_damping * vy @ vy - elastic_force(model, jnp.zeros_like(old.y), old.vy) @ vy
    rates = [jnp.sum(force.p * vp) + force.y @ vy for force in forces]
    return steps.mean * jnp.stack([-elastic, drag, rates[0], -rates[1], rates[2]])
