"""Time integration of two sides with a dual coupling, compiled."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from numpy.typing import NDArray

from supple.errors import ModelError
from supple_benchmarks.explicit.dual_coupling.multi_time_step import (
    CoupledArrays,
    CoupledState,
    MultiTimeStep,
    Side,
)
from supple_benchmarks.explicit.dual_coupling.sides import Coupling

__all__ = ["CoupledMotion", "dual_march"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CoupledMotion:
    """Motion of both sides at the output times; the first is the initial state.

    times : (t,) s
    modal, elements : (t, k) modal amplitudes, (t, n) displacements of the elements, m
    energies : (t, 2) of the modes and of the elements, J
    interface : (t, 2) work of the multipliers on the modes and on the elements since the start, J; the sum of
        both is the energy that the coupling adds
    gap : largest difference of the interface velocities of the two sides, m/s, at the times at which the
        scheme enforces continuity
    """

    times: FloatArray
    modal: FloatArray
    elements: FloatArray
    energies: FloatArray
    interface: FloatArray
    gap: float


def dual_march(
    coupling: Coupling,
    scheme: MultiTimeStep,
    h: float,
    n_steps: int,
    *,
    modal: tuple[FloatArray, FloatArray],
    elements: tuple[FloatArray, FloatArray],
    every: int = 1,
) -> CoupledMotion:
    """Integrate both sides from initial displacements and velocities; the motion at the output times.

        M a = f + C^T Lambda,   C_1 v_1 + C_2 v_2 = 0,   central differences (Newmark, beta 0, gamma 1/2)

    h : step of the elements, s;   n_steps : number of long steps, each of `scheme.ratio` h
    modal, elements : initial displacements and velocities of the modes (k,) and of the elements (n,)
    every : long steps per output, a divisor of n_steps
    Energies are 1/2 v M v + 1/2 u K u - H^2/8 a M a, with the step H of each side. Central differences
    conserve this energy of a linear side without coupling.
    Raises ModelError unless n_steps is a multiple of `every`: the motion would end before its last step.
    """
    if every < 1 or n_steps < 1 or n_steps % every:
        raise ModelError(
            f"{n_steps} long steps with an output every {every} long steps: give a number of steps that "
            "is a multiple of the steps per output, both at least 1"
        )
    side = coupling.elements
    arrays = CoupledArrays(
        jnp.asarray(coupling.modal.frequencies**2),
        jnp.asarray(coupling.modal.rows),
        jnp.asarray(side.rows),
        jnp.asarray(side.mass),
        scheme.operator(coupling, h),
    )
    (u1, v1), (u2, v2) = ([jnp.asarray(own, dtype=float) for own in pair] for pair in (modal, elements))
    zero = jnp.zeros(())
    a1 = -arrays.squares * u1
    a2 = side.force(u2, zero) / arrays.mass
    # Initial multipliers that make the accelerations of both sides equal at the interface: C a = 0.
    both = np.asarray(arrays.modal_rows @ arrays.modal_rows.T + (arrays.rows / arrays.mass) @ arrays.rows.T)
    pull = jnp.asarray(-np.linalg.solve(both, np.asarray(arrays.modal_rows @ a1 + arrays.rows @ a2)))
    state = CoupledState(
        zero,
        Side(u1, v1, a1 + arrays.modal_rows.T @ pull),
        Side(u2, v2, a2 + arrays.rows.T @ pull / arrays.mass),
        pull,
        jnp.zeros(2),
        zero,
    )
    last, rows = _marched(arrays, coupling, scheme, state, jnp.asarray(h), n_steps // every, every)
    K = jnp.asarray(side.stiffness)
    times, u1, v1, acc1, u2, v2, acc2, works = (
        np.concatenate([np.asarray(first)[None], np.asarray(later)])
        for first, later in zip(_recorded(state), rows, strict=True)
    )
    long = scheme.ratio * h
    modal_energy = 0.5 * (v1**2 + coupling.modal.frequencies**2 * u1**2 - 0.25 * long**2 * acc1**2).sum(
        axis=1
    )
    strain = 0.5 * np.einsum("ti,ij,tj->t", u2, np.asarray(K), u2, optimize=True)
    element_energy = strain + 0.5 * ((v2**2 - 0.25 * h**2 * acc2**2) * side.mass).sum(axis=1)
    return CoupledMotion(
        times, u1, u2, np.column_stack([modal_energy, element_energy]), works, float(last.gap)
    )


@partial(jax.jit, static_argnums=(1, 2, 5, 6))
def _marched(
    arrays: CoupledArrays,
    coupling: Coupling,
    scheme: MultiTimeStep,
    state: CoupledState,
    h: Array,
    n: int,
    every: int,
) -> tuple[CoupledState, tuple[Array, ...]]:
    def output(state: CoupledState, _: None) -> tuple[CoupledState, tuple[Array, ...]]:
        state = lax.fori_loop(0, every, lambda _, s: scheme.step(arrays, coupling, s, h), state)
        return state, _recorded(state)

    return lax.scan(output, state, None, length=n)


def _recorded(state: CoupledState) -> tuple[Array, ...]:
    return state.time, *state.modal, *state.elements, state.works
