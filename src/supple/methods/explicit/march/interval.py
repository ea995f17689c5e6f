"""Compiled time integration between output times, with new stable steps at each output time."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from supple.equations.compiler_options import STARTING
from supple.equations.control_force import outputs
from supple.methods.explicit.elements import with_contact
from supple.methods.explicit.march.contact_forces import march_contact_forces
from supple.methods.explicit.march.frame_forces import frame_states
from supple.methods.explicit.march.frame_step import frame_step, tied_positions
from supple.methods.explicit.march.march_model import MarchModel, MarchState, Methods
from supple.methods.explicit.march.march_step import kinetic, march_step
from supple.methods.explicit.spin_stiffness import spinning_step_limit
from supple.programs.program_cache import CachedProgram

DRIFT = 0.01
"""Largest energy lost or created, relative to the largest energy of the run so far; a run stops above it. The
present energy is no scale: it returns to zero where gravity or servos bring a machine to rest."""

RELEASED = 0.2
"""Largest negative contact energy, relative to the largest energy of the run; a run stops above it. A contact
that opens within a step h releases an excess of up to h^2 k / 4 m of its energy, 13 % with the default
stiffness."""

HOPELESS = 10.0
"""Multiple of the allowed interface loss at which a trial is stopped."""


class Recorded(NamedTuple):
    """Results recorded at an output time.

    frames : points and modes of each, their rates and accelerations;   pulls : (m,) multipliers of joints
    contacts : (c, 6) see `march_contact_forces`;   controls : outputs of each controller
    trouble : 0, or 1 an element inverted, 2 not finite, 3 the energy drifts, 4 a negative energy, 5 the
        interface energy drifts
    """

    x: Array
    v: Array
    a: Array
    plastic: tuple[Array, ...]
    alive: tuple[Array, ...]
    von_mises: tuple[Array, ...]
    frames: tuple[tuple[Array, ...], ...]
    pulls: Array
    obstacles: tuple[tuple[Array, Array], ...]
    contacts: Array
    controls: tuple[Array, ...]
    energies: Array
    time: Array
    steps: Array
    step: Array
    ratio: Array
    trouble: Array


def _march_to(
    model: MarchModel, methods: Methods, state: MarchState, fixed: Array, times: Array
) -> tuple[MarchState, Recorded]:
    """Integrate to output times (t,); after a failure or at times already reached, the last row is repeated.

    fixed : fixed step of the explicit nodes, s; 0: the stable step
    """

    def one(carry: tuple[MarchState, Array], end: Array) -> tuple[tuple[MarchState, Array], Recorded]:
        state, trouble = carry
        new = _interval(model, methods, state, fixed, end)
        over = (trouble > 0) | (end <= state.time)
        new = jax.tree.map(lambda a, b: jnp.where(over, a, b), state, new)
        new = new._replace(largest=jnp.maximum(new.largest, _size(new) + kinetic(model, new)))
        # Viscous work is counted a step before the work of its force: internal energy lacks that of one step.
        lead = jnp.where(new.steps == state.steps + 1, new.energies.damping - state.energies.damping, 0.0)
        row, trouble = _checked(model, methods, new, trouble, lead)
        return (new, trouble), row

    (state, _), rows = lax.scan(one, (state, jnp.asarray(0)), times)
    return state, rows


def _chosen_steps(
    model: MarchModel, methods: Methods, state: MarchState, fixed: Array, span: Array
) -> tuple[Array, Array, Array]:
    """Element step, s, number of element steps in one frame step, and number of frame steps in a span."""
    short = _nodes_limit(model, state, methods.explicit.safety)
    short = jnp.where(fixed > 0, fixed, short)
    if not model.frames:
        n = jnp.maximum(jnp.ceil(span / short * (1 - 1e-9)), 1)
        return span / n, jnp.asarray(1), n.astype(int)
    long = methods.explicit.safety * jnp.min(jnp.stack(frame_limits(model, state)))
    if not model.blocks:
        short = long = jnp.where(fixed > 0, fixed, long)
    long = jnp.minimum(long, jnp.minimum(methods.explicit.largest_ratio, state.ratio_bound) * short)
    n = jnp.maximum(jnp.ceil(span / long * (1 - 1e-9)), 1)
    ratio = jnp.maximum(jnp.ceil(span / n / short * (1 - 1e-9)), 1)
    return span / (n * ratio), ratio.astype(int), n.astype(int)


def _nodes_limit(model: MarchModel, state: MarchState, safety: float) -> Array:
    """Element step, s: `safety` times the limit in the present state, reduced for stiffness damping."""
    short = safety * with_contact(jnp.asarray(jnp.inf), model.contact_rate)
    for block, own in zip(model.blocks, state.blocks, strict=True):
        longest = safety * block.longest_step(state.x, state.v, own.alive, model.contact_rate)
        if block.beta is not None:
            zeta = block.beta / longest
            longest = longest * (jnp.sqrt(1 + zeta**2) - zeta)
        short = jnp.minimum(short, longest)
    return short


def frame_limits(model: MarchModel, state: MarchState) -> list[Array]:
    """Step limit of each frame at its angular velocity, s."""
    return [
        arrays.step_limit
        if arrays.spin_bound is None
        else spinning_step_limit(arrays.step_limit, arrays.spin_bound, frame.p, frame.vp)
        for arrays, frame in zip(model.frames, state.frames, strict=True)
    ]


def _interval(model: MarchModel, methods: Methods, state: MarchState, fixed: Array, end: Array) -> MarchState:
    """Integrate to an output time; repeated with smaller ratios while the interface energy drifts."""
    if not model.frames or not model.blocks:
        return _marched(model, methods, state, fixed, end)
    allowed = methods.explicit.interface_loss * state.largest

    def ratio_of(bound: Array) -> Array:
        return _chosen_steps(model, methods, state._replace(ratio_bound=bound), fixed, end - state.time)[1]

    def lost(new: MarchState) -> Array:
        return jnp.abs(new.energies.interface - state.energies.interface)

    def too_much(carry: tuple[Array, MarchState]) -> Array:
        ratio, new = carry
        return (ratio > 1) & ~(lost(new) <= allowed)

    def again(carry: tuple[Array, MarchState]) -> tuple[Array, MarchState]:
        bound = jnp.maximum(carry[0] // 2, 1)
        return bound, _marched(
            model, methods, state._replace(ratio_bound=bound), fixed, end, HOPELESS * allowed
        )

    first = ratio_of(state.ratio_bound)
    tried = _marched(model, methods, state, fixed, end, HOPELESS * allowed)
    ratio, new = lax.while_loop(too_much, again, (first, tried))
    repeated = ratio != first
    # After each repetition the wait for a larger ratio doubles: a trial costs the whole interval.
    longer = (lost(new) < 0.1 * allowed) & (state.ratio_wait == 0) & ~repeated
    larger = jnp.where(longer, jnp.minimum(2 * ratio, methods.explicit.largest_ratio), state.ratio_bound)
    return new._replace(
        ratio_bound=jnp.where(repeated, ratio, larger),
        ratio_wait=jnp.where(repeated, state.ratio_patience, jnp.maximum(state.ratio_wait - 1, 0)),
        ratio_patience=jnp.where(repeated, jnp.minimum(2 * state.ratio_patience, 64), state.ratio_patience),
    )


def _size(state: MarchState) -> Array:
    """Energy scale since the start of the run, without kinetic energy, J."""
    e = state.energies
    return jnp.abs(state.initial) + jnp.abs(e.external) + e.plastic + jnp.abs(e.damping)


def _marched(
    model: MarchModel,
    methods: Methods,
    state: MarchState,
    fixed: Array,
    end: Array,
    most: Array | float = float("inf"),
) -> MarchState:
    """Integrate to an output time, unless the interface loses or gains over `most` J at a ratio above 1."""
    h, ratio, n = _chosen_steps(model, methods, state, fixed, end - state.time)
    before = state.energies.interface

    def is_running(carry: tuple[Array, MarchState]) -> Array:
        done, state = carry
        bears = (ratio == 1) | (jnp.abs(state.energies.interface - before) <= most)
        return (done < n) & (state.smallest > 0) & jnp.isfinite(state.energies.internal) & bears

    def go_on(carry: tuple[Array, MarchState]) -> tuple[Array, MarchState]:
        done, state = carry
        return done + 1, march_step(model, methods, state, h, ratio)

    done, state = lax.while_loop(is_running, go_on, (jnp.asarray(0), state))
    return state._replace(time=jnp.where(done == n, end, state.time))


def _checked(
    model: MarchModel, methods: Methods, state: MarchState, trouble: Array, lead: Array
) -> tuple[Recorded, Array]:
    """The row of an output time, and its trouble; lead : damping without its internal energy, J."""
    row = _recorded(model, methods, state, trouble, jnp.zeros(()))
    e = state.energies._replace(kinetic=row.energies[0])
    held = e.kinetic + e.internal + e.plastic + e.hourglass + e.contact + e.damping + e.interface
    # Energy of round-off in a body at rest: relative strains of 1e-12 at the fastest rate.
    noise = 1e-24 * jnp.sum(model.mass) * jnp.abs(state.x).max(initial=0.0) ** 2 / state.before**2
    noise = noise + _noise_of_joints(model, state)
    largest = state.largest + noise
    # Without kinetic energy, which is about half of the largest energy of a run.
    size = jnp.maximum(_size(state) + noise, 0.5 * largest)
    causes = {
        1: state.smallest <= 0,
        2: ~jnp.isfinite(held),
        3: jnp.abs(held - e.external - state.initial) > DRIFT * largest,
        5: jnp.abs(e.interface) > DRIFT * largest,
        4: (jnp.minimum(e.internal + lead, e.hourglass) < -2 * DRIFT * size)
        | (e.contact < -RELEASED * largest),
    }
    seen = jnp.select(list(causes.values()), list(causes), 0)
    trouble = jnp.where(trouble > 0, trouble, seen)
    return row._replace(trouble=trouble), trouble


def _noise_of_joints(model: MarchModel, state: MarchState) -> Array:
    """Energy of round-off in jointed frames, J: relative errors of positions 1e-12, of weights 1e-10."""
    noise = jnp.zeros(())
    if model.machine is None or not model.machine.active:
        return noise
    weight = jnp.linalg.norm(model.gravity)
    for arrays, at in zip(model.frames, state.frames, strict=True):
        reach = jnp.abs(at.p).max()
        mass = arrays.model.moments.S0.sum()
        noise = noise + mass * reach * (1e-24 * reach / state.frame_before**2 + 1e-10 * weight)
    return noise


def _recorded(
    model: MarchModel, methods: Methods, state: MarchState, trouble: Array, first: Array
) -> Recorded:
    worst = [
        block.recorded(state.x, state.turning.triads, own)
        for block, own in zip(model.blocks, state.blocks, strict=True)
    ]
    acceleration = model.movable * state.forces.sum(axis=0) / jnp.where(model.mass > 0, model.mass, 1.0)
    acceleration = acceleration - model.alpha * state.v
    frames, centred, pulls = [], [], jnp.zeros(0)
    if model.frames:
        long = jnp.where(state.frame_before > 0, state.frame_before, first)
        mean = 0.5 * (state.frame_before + long)
        done = frame_step(model, methods, state, long)
        pulls = done.pulls
        for arrays, at, new in zip(model.frames, state.frames, done.frames, strict=True):
            # At the start, the rates are the initial ones.
            share = jnp.where(state.frame_before > 0, 0.5, 0.0)
            change = new.vp - at.vp, new.vy - at.vy
            rates = tuple(own + share * by for own, by in zip((at.vp, at.vy), change, strict=True))
            frames.append((at.p, at.y, *rates, *(by / mean for by in change)))
            centred.append(at._replace(vp=rates[0], vy=rates[1]))
            tied_rates = (tied_positions(arrays, new) - state.x[:, arrays.nodes]) / long
            acceleration = acceleration.at[:, arrays.nodes].set(
                (tied_rates - state.v[:, arrays.nodes]) / mean
            )
    controls: tuple[Array, ...] = ()
    if model.machine is not None and state.control is not None:
        now = frame_states(model.machine, model.frames, tuple(centred), state.time, state.control)
        controls = outputs(model.machine, now)
    return Recorded(
        state.x,
        state.v,
        acceleration,
        tuple(plastic for plastic, _ in worst),
        tuple(own.alive for own in state.blocks),
        tuple(stress for _, stress in worst),
        tuple(frames),
        pulls,
        tuple((at.offset, at.velocity) for at in state.obstacles),
        march_contact_forces(model, state),
        controls,
        jnp.stack(state.energies._replace(kinetic=kinetic(model, state))),
        state.time,
        state.steps,
        state.before,
        jnp.where(state.frame_before > 0, state.frame_before / state.before, 1.0),
        trouble,
    )


march_to = CachedProgram(_march_to)
nodes_limit = CachedProgram(_nodes_limit, STARTING)
chosen_steps = CachedProgram(_chosen_steps, STARTING)
recorded = CachedProgram(_recorded)
"""A recorded state.

    Rates of frames at t_n, accelerations and multipliers follow from a trial of the next step.
    first : length of the trial at the start, s; later trials have the length of the previous step
"""
