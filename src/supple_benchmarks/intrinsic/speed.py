"""Processor time of a Runge-Kutta step: factorised equations compared with dense tensors."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import process_time

import jax
import jax.numpy as jnp
import numpy as np

from supple.methods.intrinsic import CLAMPED, intrinsic_modes
from supple.methods.intrinsic.line_equations import line_rates
from supple.methods.intrinsic.line_march import runge_kutta_step
from supple.methods.intrinsic.line_model import line_model
from supple_benchmarks.intrinsic.beams import beam_line
from supple_benchmarks.intrinsic.dense_couplings import dense_couplings, dense_rates
from supple_benchmarks.lines import points_along_x
from supple_benchmarks.table import Row

__all__ = ["speed_rows"]

State = tuple[jax.Array, jax.Array]
SIZES = ((24, 50), (24, 100), (24, 138), (48, 100))
"""Pairs: number of stations, number of modes."""


def speed_rows(quick: bool) -> Iterator[Row]:
    """Processor time per step, microseconds, for each pair in `SIZES`: the smallest of five measurements."""
    for nodes, m in SIZES[: 1 if quick else None]:
        points = points_along_x(1, nodes - 1)
        line = beam_line("beam", points, axial=1e5, bending=1.0, torsion=1.0, mass=1.0, radius=0.03)
        model = line_model(intrinsic_modes(line, CLAMPED, m))
        couplings = dense_couplings(model)
        n_steps = 200 if quick else 2000
        yield {
            "modes": m,
            "nodes": nodes,
            "us_per_rk4_step": _microseconds(lambda q, own=model: line_rates(own, *q), m, n_steps),
            "tensor_us_per_rk4_step": _microseconds(
                lambda q, own=model, tensors=couplings: dense_rates(own, tensors, *q), m, n_steps // 10
            ),
        }


def _microseconds(rates: Callable[[State], State], m: int, n_steps: int) -> float:
    start = (1e-3 * jnp.ones(m), jnp.zeros(m))

    @jax.jit
    def march(state: State) -> State:
        def step(now: State, _: None) -> tuple[State, None]:
            return runge_kutta_step(lambda _, q: rates(q), 0.0, now, 1e-6), None

        return jax.lax.scan(step, state, None, length=n_steps)[0]

    jax.block_until_ready(march(start))
    least = np.inf
    for _ in range(5):
        began = process_time()
        jax.block_until_ready(march(start))
        least = min(least, process_time() - began)
    return 1e6 * least / n_steps
