"""A step of the modal sub-domains, with the forces of the explicit nodes tied to them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeVar

import jax
import jax.numpy as jnp
from jax import Array

from supple.methods.explicit.frame_model import (
    FrameState,
    Generalized,
    StepLengths,
    elastic_force,
    gravity_force,
    material_points,
    point_forces,
    spin_force,
)
from supple.methods.explicit.frame_moments import spread
from supple.methods.explicit.march.frame_forces import frame_forces, gravity_at, joint_gaps, joint_rows
from supple.methods.explicit.march.march_model import FrameArrays, MarchModel, MarchState, Methods
from supple.methods.explicit.modal_tie import tied_gap, tied_rows
from supple.methods.explicit.projected_difference import ProjectedDifference

T = TypeVar("T")


class FrameStep(NamedTuple):
    """Frames after the step, and works in it, J: internal, damping, external, contact, from nodes, rotation.

    on_obstacles : (o, 3) forces at t_n;   pulls : (m,) multipliers of the joints at t_n
    """

    frames: tuple[FrameState, ...]
    internal: Array
    damping: Array
    external: Array
    contact: Array
    from_nodes: Array
    turning: Array
    on_obstacles: Array
    pulls: Array


def frame_step(model: MarchModel, methods: Methods, state: MarchState, h: Array) -> FrameStep:
    """All frames from t_n to t_n + h, under the forces at t_n."""
    steps = StepLengths(state.frame_before, h)
    forces = []
    on_obstacles = jnp.zeros_like(state.obstacle_forces)
    gravity = gravity_at(model, state.time)
    # The weight of the nodes tied to a frame is included in the frame's own mass.
    pulls = state.forces.sum(axis=0) - model.mass * gravity[:, None]
    assert model.machine is not None
    acting = frame_forces(
        model.machine, methods.stores, model.frames, state.frames, state.time, state.control
    )
    for arrays, own, given, stored, dragged in zip(model.frames, state.frames, *acting, strict=True):
        external = gravity_force(spread(arrays.model.moments, own.y), own.p, gravity) + given
        contact = Generalized(jnp.zeros((4, 3)), jnp.zeros_like(own.y))
        for touching in arrays.touching:
            points = touching.weights, touching.shapes, own.p, own.y
            push = touching.push(state.obstacles, material_points(*points).T)
            contact = contact + point_forces(*points, push.T)
            on_obstacles = on_obstacles.at[touching.number].add(-push.sum(axis=1))
        pulled = point_forces(arrays.weights, arrays.shapes, own.p, own.y, pulls[:, arrays.nodes].T)
        forces.append((external, contact, pulled, stored, dragged))
    total = [a + b + c + d + e for a, b, c, d, e in forces]
    frames, turning, driving, joints = _advanced(model, methods, state, total, steps)
    works = jnp.zeros(5)
    for arrays, own, new, force in zip(model.frames, state.frames, frames, forces, strict=True):
        works = works + _works(arrays, own, new, force, steps)
    internal, damping, external, contact, from_nodes = works
    return FrameStep(
        frames, internal, damping, external + driving, contact, from_nodes, turning, on_obstacles, joints
    )


def _advanced(
    model: MarchModel, methods: Methods, state: MarchState, forces: list[Generalized], steps: StepLengths
) -> tuple[tuple[FrameState, ...], Array, Array, Array]:
    """The frames after the step; joined frames are solved together.

    Also returns the works by finite rotation and by joint laws, J, and the joint multipliers (m,).
    """
    scheme, frames, joined = methods.explicit.scheme, state.frames, methods.joined
    after, links = list(frames), [jnp.zeros(6)] * len(frames)
    for number in range(len(frames)):
        if number not in joined:
            after[number], links[number] = scheme.step(
                model.frames[number].model, frames[number], forces[number], steps
            )
    turning, driving, pulls = jnp.zeros(()), jnp.zeros(()), jnp.zeros(0)
    if joined:
        assert isinstance(scheme, ProjectedDifference)  # checked when built

        def own(every: Sequence[T]) -> tuple[T, ...]:
            return tuple(every[number] for number in joined)

        rows = own(joining_rows(model, methods.tied, frames, state.time))
        new, pulled, pulls = scheme.step_joined(
            tuple(each.model for each in own(model.frames)),
            own(frames),
            own(forces),
            rows,
            lambda moved: _gaps(model, methods, frames, moved, state.time + steps.after),
            steps,
        )
        for number, moved, link in zip(joined, new, pulled, strict=True):
            after[number], links[number] = moved, link
        works = scheme.joining_work(rows, own(frames), new, pulls, steps)
        n_joints = len(model.driven)
        by_laws = jnp.concatenate([jnp.zeros(len(works) - n_joints), model.driven])
        turning, driving = works @ (1 - by_laws), works @ by_laws
        pulls = pulls[len(pulls) - n_joints :]
    for arrays, old, moved, link in zip(model.frames, frames, after, links, strict=True):
        turning = turning + scheme.turning_work(arrays.model, old, moved, link, steps)
    return tuple(after), turning, driving, pulls


def joining_rows(
    model: MarchModel, tied: tuple[tuple[int, int], ...], frames: tuple[FrameState, ...], time: Array
) -> tuple[Generalized, ...]:
    """Rows of ties, then of joints, on the points (R, 4, 3) and modes (R, k) of every frame."""
    pieces: list[list[Generalized]] = [[] for _ in frames]
    for tie, pair in zip(model.ties, tied, strict=True):
        own = dict(zip(pair, tied_rows(tie, *(frames[number] for number in pair)), strict=True))
        rows = len(tie.first.weights)
        for number, at in enumerate(frames):
            none = Generalized(jnp.zeros((rows, 4, 3)), jnp.zeros((rows, len(at.y))))
            pieces[number].append(own.get(number, none))
    if model.machine is not None and model.machine.active:
        for number, each in enumerate(joint_rows(model.machine, model.frames, frames, time)):
            pieces[number].append(each)
    return tuple(Generalized(*map(jnp.concatenate, zip(*own, strict=True))) for own in pieces if own)


def _gaps(
    model: MarchModel,
    methods: Methods,
    frames: tuple[FrameState, ...],
    moved: tuple[FrameState, ...],
    time: Array,
) -> Array:
    """Residuals of ties and joints, with the joined frames in their new positions."""
    every = list(frames)
    for number, own in zip(methods.joined, moved, strict=True):
        every[number] = own
    found = [tied_gap(tie, every[a], every[b]) for tie, (a, b) in zip(model.ties, methods.tied, strict=True)]
    if model.machine is not None and model.machine.active:
        found.append(joint_gaps(model.machine, model.frames, tuple(every), time))
    return jnp.concatenate(found)


def tied_positions(arrays: FrameArrays, frame: FrameState) -> Array:
    """Positions (3, n) of the explicit nodes tied to a frame."""
    return material_points(arrays.weights, arrays.shapes, frame.p, frame.y).T


def tied_velocities(arrays: FrameArrays, frame: FrameState) -> Array:
    """Velocities (3, n) of the explicit nodes tied to a frame."""
    by_rates = jnp.zeros_like(frame.vp), jnp.zeros_like(frame.vy)
    rates = FrameState(frame.vp, frame.vy, *by_rates)
    return jax.jvp(lambda at: tied_positions(arrays, at), (frame,), (rates,))[1]


def _works(
    arrays: FrameArrays, old: FrameState, new: FrameState, forces: tuple[Generalized, ...], steps: StepLengths
) -> Array:
    """Internal, damping, external, contact, nodal works: force times mean rate times mean step.

    forces : external, contact, nodal, and those of elements with stored energy, at rest and by rates
    """
    vp, vy = 0.5 * (old.vp + new.vp), 0.5 * (old.vy + new.vy)
    model = arrays.model
    elastic = (elastic_force(model, old.y, jnp.zeros_like(old.y)) + spin_force(model, old, new)) @ vy
    drag = model.mass_damping * vy @ vy - elastic_force(model, jnp.zeros_like(old.y), old.vy) @ vy
    rates = [jnp.sum(force.p * vp) + force.y @ vy for force in forces]
    return steps.mean * jnp.stack([-elastic - rates[3], drag - rates[4], rates[0], -rates[1], rates[2]])
