"""Schemes of two coupled sides over a long step: Gravouil and Combescure, Prakash and Hjelmstad.

Sources: A. Gravouil, A. Combescure, "Multi-time-step explicit-implicit method for non-linear structural
dynamics", Int. J. Numer. Methods Eng. 50 (2001) 199-225; A. Prakash, K. D. Hjelmstad, "A FETI-based
multi-time-step coupling method for Newmark schemes in structural dynamics", Int. J. Numer. Methods Eng. 61
(2004) 2183-2204.
"""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Integral
from typing import NamedTuple, Protocol

import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from supple.algebra import jax_settings  # noqa: F401 - 64-bit floats, before the first array
from supple.errors import ModelError
from supple_benchmarks.explicit.dual_coupling.interface_operator import InterfaceOperator, interface_operator
from supple_benchmarks.explicit.dual_coupling.sides import Coupling

__all__ = ["GravouilCombescure", "MultiTimeStep", "PrakashHjelmstad"]


class Side(NamedTuple):
    """Displacement, velocity and acceleration of a side at one time."""

    u: Array
    v: Array
    a: Array


class CoupledState(NamedTuple):
    """State of both sides at the end of a long step.

    multiplier : (l,) at this time, N
    works : (2,) work of the multipliers on the modes and on the elements since the start, J
    gap : largest difference of the interface velocities of the two sides since the start, m/s, at the times
        at which the scheme enforces continuity
    """

    time: Array
    modal: Side
    elements: Side
    multiplier: Array
    works: Array
    gap: Array


class CoupledArrays(NamedTuple):
    """Constants of the coupled equations.

    squares : (k,) omega^2 of the modes;   mass : (n,) of the elements, kg
    modal_rows, rows : (l, k), (l, n) interface rows of the modes and of the elements;   operator : H^-1
    """

    squares: Array
    modal_rows: Array
    rows: Array
    mass: Array
    operator: InterfaceOperator


class MultiTimeStep(Protocol):
    """A coupling scheme with short steps of the elements and long steps of the modes."""

    @property
    def ratio(self) -> int:
        """Number of short steps in a long one."""
        ...

    def operator(self, coupling: Coupling, h: float) -> InterfaceOperator:
        """The interface operator for short steps of h seconds."""
        ...

    def step(self, arrays: CoupledArrays, coupling: Coupling, state: CoupledState, h: Array) -> CoupledState:
        """The state after one long step."""
        ...


@dataclass(frozen=True)
class GravouilCombescure:
    """Continuity at every short step, between the elements and the interpolated free velocity of the modes.

    The free velocity is the velocity without the part dT/2 C_1^T Lambda, with Lambda at the same time. The
    scheme is stable, and dissipates energy for ratio > 1. The interpolation starts from the free velocity at
    the start of the long step. With the whole velocity there, the interface is continuous as well, but half
    of the energy is lost.
    """

    ratio: int = 1

    def __post_init__(self) -> None:
        _check(self.ratio)

    def operator(self, coupling: Coupling, h: float) -> InterfaceOperator:
        """The inverse of H = dT/2 C_1 C_1^T + dt/2 C_2 M_2^-1 C_2^T, for long steps dT and short steps dt."""
        rows = coupling.elements.rows
        own = 0.5 * h * (rows / coupling.elements.mass) @ rows.T
        return interface_operator(own, np.sqrt(0.5 * h * self.ratio) * coupling.modal.rows)

    def step(self, arrays: CoupledArrays, coupling: Coupling, state: CoupledState, h: Array) -> CoupledState:
        """The state after one long step."""
        long = self.ratio * h
        free = _free_modes(arrays, state.modal, long)
        # The free velocity at the start: without the contribution of the multiplier at that time.
        begin = arrays.modal_rows @ (state.modal.v - 0.5 * long * (arrays.modal_rows.T @ state.multiplier))
        end = arrays.modal_rows @ free.v

        def short(j: Array, carry: tuple[Side, Array, Array, Array]) -> tuple[Side, Array, Array, Array]:
            side, multiplier, work, gap = carry
            part = (j + 1) / self.ratio
            own = _free_elements(arrays, coupling, side, state.time + (j + 1) * h, h)
            between = (1 - part) * begin + part * end
            new = arrays.operator.solve(-(between + arrays.rows @ own.v))
            pull = arrays.rows.T @ new / arrays.mass
            after = Side(own.u, own.v + 0.5 * h * pull, own.a + pull)
            work = work + 0.5 * (multiplier + new) @ (arrays.rows @ (after.u - side.u))
            left = (
                between
                + 0.5 * long * (arrays.modal_rows @ (arrays.modal_rows.T @ new))
                + arrays.rows @ after.v
            )
            return after, new, work, jnp.maximum(gap, jnp.abs(left).max())

        elements, multiplier, work, gap = lax.fori_loop(
            0, self.ratio, short, (state.elements, state.multiplier, jnp.zeros(()), state.gap)
        )
        return _joined(arrays, state, free, elements, multiplier, work, gap, long)


@dataclass(frozen=True)
class PrakashHjelmstad:
    """Continuity at the ends of long steps only; the multipliers are linear in time between them.

    The energy of linear sides changes less than with `GravouilCombescure`.
    passes : number of passes over the short steps; 2 give exact continuity for linear elements, nonlinear
        elements need more
    """

    ratio: int = 1
    passes: int = 2

    def __post_init__(self) -> None:
        _check(self.ratio)
        if not isinstance(self.passes, Integral) or self.passes < 2:
            raise ModelError(
                f"the passes of Prakash and Hjelmstad's scheme must be a whole number of at least 2, "
                f"got {self.passes}"
            )

    def operator(self, coupling: Coupling, h: float) -> InterfaceOperator:
        """The inverse of H = dT/2 C_1 C_1^T + V, for long steps dT.

        Each column of V (l, l) contains the interface velocities of the elements at the end of a long step
        during which one multiplier increases linearly from 0 to 1, with the stiffness at rest.
        """
        side = coupling.elements
        pull = side.rows.T / side.mass[:, None]
        stiff = side.stiffness
        u = v = a = np.zeros_like(pull)
        for j in range(self.ratio):
            u = u + h * v + 0.5 * h * h * a
            new = -(stiff @ u) / side.mass[:, None] + (j + 1) / self.ratio * pull
            v, a = v + 0.5 * h * (a + new), new
        ramp = side.rows @ v
        return interface_operator(0.5 * (ramp + ramp.T), np.sqrt(0.5 * h * self.ratio) * coupling.modal.rows)

    def step(self, arrays: CoupledArrays, coupling: Coupling, state: CoupledState, h: Array) -> CoupledState:
        """The state after one long step."""
        long = self.ratio * h
        free = _free_modes(arrays, state.modal, long)

        def marched(last: Array) -> tuple[Side, Array]:
            def short(j: Array, carry: tuple[Side, Array]) -> tuple[Side, Array]:
                side, work = carry
                part = (j + 1) / self.ratio
                before = state.multiplier + (part - 1 / self.ratio) * (last - state.multiplier)
                new = (1 - part) * state.multiplier + part * last
                own = _free_elements(arrays, coupling, side, state.time + (j + 1) * h, h)
                pull = arrays.rows.T @ new / arrays.mass
                after = Side(own.u, own.v + 0.5 * h * pull, own.a + pull)
                return after, work + 0.5 * (before + new) @ (arrays.rows @ (after.u - side.u))

            return lax.fori_loop(0, self.ratio, short, (state.elements, jnp.zeros(())))

        def gap(last: Array, elements: Side) -> Array:
            own = free.v + 0.5 * long * (arrays.modal_rows.T @ last)
            return arrays.modal_rows @ own + arrays.rows @ elements.v

        last = jnp.zeros_like(state.multiplier)
        elements, work = marched(last)
        for _ in range(self.passes - 1):
            last = last - arrays.operator.solve(gap(last, elements))
            elements, work = marched(last)
        left = jnp.abs(gap(last, elements)).max()
        return _joined(arrays, state, free, elements, last, work, jnp.maximum(state.gap, left), long)


def _free_modes(arrays: CoupledArrays, modal: Side, long: Array) -> Side:
    u = modal.u + long * modal.v + 0.5 * long**2 * modal.a
    a = -arrays.squares * u
    return Side(u, modal.v + 0.5 * long * (modal.a + a), a)


def _free_elements(arrays: CoupledArrays, coupling: Coupling, side: Side, time: Array, h: Array) -> Side:
    u = side.u + h * side.v + 0.5 * h**2 * side.a
    a = coupling.elements.force(u, time) / arrays.mass
    return Side(u, side.v + 0.5 * h * (side.a + a), a)


def _joined(
    arrays: CoupledArrays,
    state: CoupledState,
    free: Side,
    elements: Side,
    multiplier: Array,
    work: Array,
    gap: Array,
    long: Array,
) -> CoupledState:
    pull = arrays.modal_rows.T @ multiplier
    modal = Side(free.u, free.v + 0.5 * long * pull, free.a + pull)
    on_modes = 0.5 * (state.multiplier + multiplier) @ (arrays.modal_rows @ (modal.u - state.modal.u))
    return CoupledState(
        state.time + long, modal, elements, multiplier, state.works + jnp.stack([on_modes, work]), gap
    )


def _check(ratio: int) -> None:
    if not isinstance(ratio, Integral) or ratio < 1:
        raise ModelError(f"the ratio of the steps must be a whole number of at least 1, got {ratio}")
