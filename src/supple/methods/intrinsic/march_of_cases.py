"""Time integration of many cases of one machine of lines: different loads, motions and initial states.

Where cases share the lines, the Runge-Kutta rule integrates all of them at once, with cases as the last axis
of all amplitudes. The modes are then read once for all cases, and products are limited by arithmetic, not by
memory. Otherwise, the rule is mapped over the cases.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
from jax.tree_util import PyTreeDef

from supple.arrays import AnyArray
from supple.integrate import RungeKutta4
from supple.methods.intrinsic.line_equations import RootTwist, line_rates, station_velocities
from supple.methods.intrinsic.line_march import LineMarchState, Stepping, march_lines, runge_kutta_step
from supple.methods.intrinsic.line_model import LineState
from supple.methods.intrinsic.line_system import LineSystem, States, root_rates, wrenches_on
from supple.methods.intrinsic.station_loads import MovingStations
from supple.methods.intrinsic.strain_integration import rotation_of, station_places

Axes: TypeAlias = tuple[int | None, ...]
"""For each leaf of a system: 0 where the cases differ, None where they share it."""


@lru_cache(maxsize=32)
def march_of_cases(structure: PyTreeDef, axes: Axes, stepping: Stepping) -> Callable[..., LineMarchState]:
    """Compiled time integration of k cases for one pattern of shared data.

    structure : tree structure of a `LineSystem`;  axes : batch axes of its leaves

    The result is a function of those leaves, starts (k, ...), output times (t,) and the tolerance of implicit
    steps. It returns states (k, t, ...).
    """
    of_lines = axes[: structure.children()[0].num_leaves]  # the first field of a system
    if isinstance(stepping.rule, RungeKutta4) and 0 not in of_lines:
        return jax.jit(partial(_together, structure, axes, stepping.n_steps))

    def one(
        own: list[AnyArray], start: LineMarchState, times: jax.Array, tolerance: AnyArray
    ) -> LineMarchState:
        return march_lines(stepping, jax.tree.unflatten(structure, own), start, times, tolerance)

    return jax.jit(jax.vmap(one, in_axes=(list(axes), 0, None, None)))


def _together(
    structure: PyTreeDef,
    axes: Axes,
    n_steps: int,
    leaves: list[AnyArray],
    starts: LineMarchState,
    times: jax.Array,
    _: AnyArray,
) -> LineMarchState:
    """Runge-Kutta integration with cases on the last axis; all share the lines and the initial time."""
    lines = jax.tree.unflatten(structure, leaves).lines
    of_roots = jax.vmap(partial(_roots, structure), in_axes=(list(axes), None, -1), out_axes=-1)
    of_loads = jax.vmap(
        lambda own, *at: wrenches_on(jax.tree.unflatten(structure, own).loads, *at),
        in_axes=(list(axes), -1, None),
        out_axes=-1,
    )

    def rates(time: AnyArray, states: States) -> States:
        roots = of_roots(leaves, time, states)
        motions = [
            MovingStations(
                station_places(model, state.q2, *root.pose), station_velocities(model, state.q1, root.twist)
            )
            for model, state, root in zip(lines, states, roots, strict=True)
        ]
        wrenches = of_loads(leaves, motions, time)
        each = zip(lines, states, roots, wrenches, strict=True)
        return tuple(
            LineState(*line_rates(model, state.q1, state.q2, wrench, root.twist), *root.turning)
            for model, state, root, wrench in each
        )

    def to_output(now: tuple[AnyArray, States], end: jax.Array) -> tuple[tuple[AnyArray, States], States]:
        begin, first = now
        h = (end - begin) / n_steps

        def one(states: States, number: jax.Array) -> tuple[States, None]:
            return runge_kutta_step(rates, begin + number * h, states, h), None

        last, _ = jax.lax.scan(one, first, jnp.arange(n_steps))
        return (end, last), last

    first = jax.tree.map(lambda leaf: jnp.moveaxis(leaf, 0, -1), starts.states)
    reached = jax.lax.scan(to_output, (starts.time[0], first), times)[1]
    k, t = len(starts.time), len(times)
    unchanged = jax.tree.map(lambda leaf: jnp.broadcast_to(leaf[:, None], (k, t, *leaf.shape[1:])), starts)
    return unchanged._replace(
        time=jnp.broadcast_to(times, (k, t)),
        states=jax.tree.map(lambda leaf: jnp.moveaxis(leaf, -1, 0), reached),
    )


class _Root(NamedTuple):
    """Pose of a root, its prescribed motion, and the rates of its quaternion and position."""

    pose: tuple[jax.Array, jax.Array]
    twist: RootTwist | None
    turning: tuple[jax.Array, jax.Array]


def _roots(structure: PyTreeDef, leaves: list[AnyArray], time: AnyArray, states: States) -> list[_Root]:
    """Roots of one case."""
    system: LineSystem = jax.tree.unflatten(structure, leaves)
    return [
        _Root(
            (rotation_of(state.quaternion), state.position) if drive is None else drive.pose(time),
            None if drive is None else drive.twist(time),
            root_rates(model, state.q1, state.quaternion),
        )
        for model, drive, state in zip(system.lines, system.drives, states, strict=True)
    ]
