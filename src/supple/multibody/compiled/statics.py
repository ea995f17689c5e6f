"""Machines of rigid and reduced bodies at rest, or turning steadily."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from supple.integrate import StepFactors
from supple.multibody.compiled.compiled_machine import CompiledMachine
from supple.multibody.compiled.elimination import solve_bordering_column
from supple.multibody.compiled.time_step import kinds_of_rows, position_scale
from supple.multibody.equations.balance import Balance, balance, tangent
from supple.multibody.equations.compiler_options import STARTING
from supple.multibody.equations.configuration import Configuration, SystemMotion
from supple.multibody.equations.joint_force import constraint_rows
from supple.multibody.equations.model import Model
from supple.multibody.equations.static_search import StaticCorrection, StaticState, Unbalance
from supple.multibody.equations.steady_motion import (
    Turning,
    in_turning_axes,
    linear_equations,
    steady_motion,
)

__all__ = ["CompiledStatics"]


@dataclass(frozen=True, eq=False)
class CompiledStatics:
    """A `StaticMachine` whose steps are compiled."""

    machine: CompiledMachine
    turning: Turning | None = None
    """None for machines at rest"""

    def unbalance(self, state: StaticState, time: float) -> Unbalance:
        """The residuals at rest."""
        model = self.machine.model
        terms = _balance(
            model, self.turning, jnp.asarray(float(time)), state.configuration, jnp.asarray(state.multipliers)
        )
        columns = (terms.residual, terms.inertia, terms.internal, terms.applied, terms.joint)
        norms = np.sqrt(kinds_of_rows(model) @ np.stack(columns, axis=1) ** 2)
        scale = norms[:, 1:].max(axis=1)
        relative = norms[:, 0] / np.where(scale > 0, scale, 1.0)
        gap = float(np.max(abs(np.asarray(terms.constraint_residual)), initial=0.0)) / float(model.length)
        return Unbalance(relative, gap, terms)

    def correction(self, state: StaticState, time: float, unbalance: Unbalance, k: float) -> StaticCorrection:
        """One implicit step of length k."""
        change = _correction(
            self.machine.model,
            self.turning,
            jnp.asarray(float(time)),
            state.configuration,
            jnp.asarray(state.multipliers),
            unbalance.terms,
            jnp.asarray(k),
        )
        increment, multipliers = (np.asarray(part) for part in change)
        return StaticCorrection(increment, multipliers)

    def moved(self, configuration: Configuration, increment: np.ndarray) -> Configuration:
        """The configuration after an increment (n,)."""
        return self.machine.moved(configuration, increment)

    @property
    def position_scale(self) -> np.ndarray:
        """What counts as a large change of each freedom, (n,)."""
        return np.asarray(position_scale(self.machine.model))


def _motion(
    model: Model,
    turning: Turning | None,
    time: jax.Array,
    configuration: Configuration,
    multipliers: jax.Array,
) -> SystemMotion:
    if turning is not None:
        return steady_motion(model, turning, time, configuration, multipliers)
    none = jnp.zeros(model.n_velocities)
    return SystemMotion(time, configuration, none, none, multipliers)


@partial(jax.jit, compiler_options=STARTING)
def _balance(
    model: Model,
    turning: Turning | None,
    time: jax.Array,
    configuration: Configuration,
    multipliers: jax.Array,
) -> Balance:
    return balance(model, _motion(model, turning, time, configuration, multipliers))


@partial(jax.jit, compiler_options=STARTING)
def _correction(
    model: Model,
    turning: Turning | None,
    time: jax.Array,
    configuration: Configuration,
    multipliers: jax.Array,
    terms: Balance,
    k: jax.Array,
) -> tuple[jax.Array, jax.Array]:
    """Increment of the configuration (n,), change of the multipliers (m,)."""
    motion = _motion(model, turning, time, configuration, multipliers)
    n, m = model.n_velocities, multipliers.shape[0]
    if turning is None:
        matrix = tangent(model, motion, terms.linearization, jnp.zeros(n), StepFactors(k, jnp.zeros(())))
    else:
        steady = linear_equations(model, turning, motion, terms)
        axes = in_turning_axes(model, configuration)
        matrix = axes @ (steady.mass + k * steady.stiffness) @ axes.T
    rows = constraint_rows(model, terms.linearization.joints)
    # Rows of one size: multipliers in parts of what the matrix holds.
    size = jnp.max(jnp.abs(jnp.diag(matrix)))
    bordered = jnp.block(
        [
            [matrix, size * rows.T, terms.residual[:, None]],
            [size * rows, jnp.zeros((m, m)), (size / k * terms.constraint_residual)[:, None]],
        ]
    )
    change = -solve_bordering_column(bordered)
    return k * change[:n], size * change[n:]
