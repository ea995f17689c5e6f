"""One step of the time integration: a long step of the frames, and several short ones of the explicit nodes.

The frames step first, under the forces of t_n. This determines the path of the nodes tied to them, which move
at a constant rate during the steps of the explicit nodes (constant-velocity subcycling: W. J. T. Daniel,
Comput. Struct. 65 (1997) 613-623, and references there). With equal steps the result is the leap-frog rule
for the coupled system. The energy lost at the interface by subcycling is a term of the energy balance.
"""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array, lax

from supple.equations.compiler_options import STARTING
from supple.equations.control_force import stepped
from supple.methods.explicit.elements import ElementInstant
from supple.methods.explicit.frame_model import step_kinetic_energy
from supple.methods.explicit.march.contact_forces import contact_energy
from supple.methods.explicit.march.frame_forces import frame_states, gravity_at
from supple.methods.explicit.march.frame_step import frame_step, tied_positions
from supple.methods.explicit.march.march_model import Energies, MarchModel, MarchState, Methods, ObstacleState
from supple.methods.explicit.march.nodal_forces import explicit_forces
from supple.methods.explicit.march.turning_nodes import turned
from supple.programs.program_cache import CachedProgram


def march_step(model: MarchModel, methods: Methods, state: MarchState, h: Array, ratio: Array) -> MarchState:
    """The state after one frame step, which is `ratio` element steps of h."""
    if not model.frames:
        return nodal_step(model, state, h, jnp.zeros_like(state.v), jnp.zeros_like(state.obstacle_forces))
    long = ratio * h
    done = frame_step(model, methods, state, long)
    tied_rates = state.v
    for arrays, frame in zip(model.frames, done.frames, strict=True):
        tied_rates = tied_rates.at[:, arrays.nodes].set(
            (tied_positions(arrays, frame) - state.x[:, arrays.nodes]) / long
        )
    old = state.energies
    energies = old._replace(
        internal=old.internal + done.internal,
        damping=old.damping + done.damping,
        external=old.external + done.external,
        contact=old.contact + done.contact,
        interface=old.interface - done.from_nodes - done.turning,
    )
    state = state._replace(energies=energies)
    if state.control is not None:
        assert model.machine is not None
        end = frame_states(model.machine, model.frames, done.frames, state.time + long, state.control, long)
        state = state._replace(control=stepped(model.machine, end))
    state = lax.fori_loop(
        0, ratio, lambda _, s: nodal_step(model, s, h, tied_rates, done.on_obstacles), state
    )
    # Tied nodes end at their positions on the frame, to round-off.
    x = state.x
    for arrays, frame in zip(model.frames, done.frames, strict=True):
        x = x.at[:, arrays.nodes].set(tied_positions(arrays, frame))
    return state._replace(x=x, frames=done.frames, frame_before=long)


def nodal_step(
    model: MarchModel, state: MarchState, h: Array, tied_rates: Array, from_frames: Array
) -> MarchState:
    """The explicit nodes after a step h; those tied to frames move at the rates `tied_rates` (3, N)."""
    mean = 0.5 * (state.before + h)
    drag = 0.5 * mean * model.alpha
    # Points of modal surfaces have no mass: the frames move them.
    acceleration = state.forces.sum(axis=0) / jnp.where(model.mass > 0, model.mass, 1.0)
    v = model.movable * ((1 - drag) * state.v + mean * acceleration) / (1 + drag)
    tied = jnp.zeros(len(model.mass), dtype=bool)
    for arrays in model.frames:
        tied = tied.at[arrays.nodes].set(True)
    v = jnp.where(tied, tied_rates, v)
    middle = 0.5 * (state.v + v)
    obstacles, driven, given = _moved(model, state, from_frames, mean, h)
    x = state.x + h * v
    turning, spun, dragged = turned(model.spins, state.turning, mean, h)
    at = ElementInstant(x, h * v, h, turning.triads)
    out = explicit_forces(model, state.time + h, at, state.blocks, obstacles)
    works = mean * (state.forces * middle).sum(axis=(1, 2))
    on_tied = mean * jnp.sum(jnp.where(tied, state.forces.sum(axis=0) * middle, 0.0))
    gravity = gravity_at(model, state.time)
    weight = mean * jnp.sum(jnp.where(tied, model.mass * gravity[:, None] * middle, 0.0))
    old = state.energies
    energies = Energies(
        kinetic=old.kinetic,
        internal=old.internal - works[0] - spun - out.plastic - out.viscous,
        plastic=old.plastic + out.plastic,
        hourglass=old.hourglass - works[1],
        contact=old.contact - works[2] - given,
        damping=old.damping
        + out.viscous
        + dragged
        + mean * jnp.sum(jnp.where(tied, 0.0, model.alpha * model.mass * middle**2)),
        interface=old.interface + on_tied - weight,
        external=old.external + works[3] - weight + driven,
    )
    return state._replace(
        time=state.time + h,
        before=h,
        x=x,
        v=v,
        forces=out.forces,
        blocks=out.blocks,
        obstacles=obstacles,
        turning=turning._replace(moments=out.moments),
        obstacle_forces=out.on_obstacles,
        energies=energies,
        smallest=jnp.minimum(state.smallest, out.smallest),
        steps=state.steps + 1,
    )


def _moved(
    model: MarchModel, state: MarchState, from_frames: Array, mean: Array, h: Array
) -> tuple[tuple[ObstacleState, ...], Array, Array]:
    """Obstacles after a step, external work (drives and gravity), and work of contact on all of them."""
    moved, driven, given, gravity = [], jnp.zeros(()), jnp.zeros(()), gravity_at(model, state.time)
    for number, at in enumerate(state.obstacles):
        force, mass = state.obstacle_forces[number] + from_frames[number], model.obstacle_mass[number]
        fall = jnp.where(jnp.isinf(mass), 0.0, gravity)
        velocity = at.velocity + mean * (force / mass + fall)
        work = mean * force @ (0.5 * (at.velocity + velocity))
        given = given + work
        weight = jnp.where(jnp.isinf(mass), 0.0, mass) * gravity
        fallen = mean * weight @ (0.5 * (at.velocity + velocity))
        driven = driven + jnp.where(jnp.isinf(mass), -work, fallen)
        moved.append(ObstacleState(at.offset + h * velocity, velocity))
    return tuple(moved), driven, given


def _begun(model: MarchModel, state: MarchState) -> MarchState:
    """The initial state of a run with its forces and energy."""
    at = ElementInstant(state.x, jnp.zeros_like(state.x), jnp.ones(()), state.turning.triads)
    out = explicit_forces(model, state.time, at, state.blocks, state.obstacles)
    turning = state.turning._replace(moments=out.moments)
    pressed = contact_energy(model, state)
    initial = kinetic(model, state) + state.energies.internal + pressed
    return state._replace(
        forces=out.forces,
        obstacle_forces=out.on_obstacles,
        turning=turning,
        energies=state.energies._replace(contact=pressed),
        initial=initial,
        largest=jnp.abs(initial),
    )


def kinetic(model: MarchModel, state: MarchState) -> Array:
    """Kinetic energy of explicit nodes, frames and free obstacles, J; tied nodes count with their frames."""
    own = model.mass
    for arrays in model.frames:
        own = own.at[arrays.nodes].set(0.0)
    total = 0.5 * jnp.sum(own * state.v**2) + 0.5 * jnp.sum(model.spins.inertia * state.turning.rates**2)
    for arrays, frame in zip(model.frames, state.frames, strict=True):
        total = total + step_kinetic_energy(arrays.model, frame, state.frame_before)
    for number, at in enumerate(state.obstacles):
        mass = model.obstacle_mass[number]
        total = total + jnp.where(jnp.isinf(mass), 0.0, 0.5 * mass * at.velocity @ at.velocity)
    return total


begun = CachedProgram(_begun, STARTING)
