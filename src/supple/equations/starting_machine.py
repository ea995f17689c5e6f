"""Protocol of a machine for its consistent start, and the joint terms and reactions at one state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, Self, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray
from supple.equations.balance import constraint_jacobian
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import Configuration, advance
from supple.equations.joint_force import constraints
from supple.equations.machine_model import Model
from supple.errors import ConvergenceError
from supple.machine import System
from supple.programs.program_cache import CachedProgram

MOST, CONVERGED = 100, 1e-12
"""Iterations, and the relative change of the joint forces at which they stop."""
JAMS = (
    "friction and the forces in the joints do not converge: each raises the other, as "
    "in a slide that jams. Lower the coefficient of friction, or the radius of the pin"
)

S = TypeVar("S", bound=tuple[Any, ...])


class JointTerms(NamedTuple):
    """The constraints at one position and velocity."""

    residual: AnyArray
    """`g`, (m,)"""
    jacobian: AnyArray
    """`G`, (m, n)"""
    rate: AnyArray
    """`dg/dt`, (m,)"""
    acceleration_bias: AnyArray
    """`d2g/dt2` while the velocities stay constant, (m,)"""


def _terms(model: Model, time: jax.Array, configuration: Configuration, velocity: jax.Array) -> JointTerms:
    """Constraints, their Jacobian, and their first two time derivatives at constant velocity."""

    def residual_after(duration: jax.Array) -> jax.Array:
        return constraints(model, time + duration, advance(model, configuration, duration * velocity))

    def with_rate(duration: jax.Array) -> tuple[jax.Array, jax.Array]:
        return jax.jvp(residual_after, (duration,), (jnp.ones(()),))

    (residual, rate), (_, bias) = jax.jvp(with_rate, (jnp.zeros(()),), (jnp.ones(()),))
    return JointTerms(residual, constraint_jacobian(model, time, configuration), rate, bias)


_TERMS = CachedProgram(_terms, STARTING)


def joint_terms(model: Model, time: AnyArray, configuration: Configuration, velocity: AnyArray) -> JointTerms:
    """Constraints at one position and velocity, and their derivatives."""
    return _TERMS(model.joints_alone, time, configuration, velocity)


def converged_reactions(answered: Callable[[np.ndarray], S], found: S) -> S:
    """Accelerations, multipliers and any further quantities, by fixed-point iteration.

    answered : function that returns these quantities for friction at given multipliers (m,)
    found : these quantities without friction

    Raises ConvergenceError where friction and joint forces increase each other without limit.
    """
    for _ in range(MOST):
        before, found = found[1], answered(found[1])
        if not np.isfinite(found[1]).all():
            break
        # Largest entries instead of norms: squares of diverging values would overflow.
        if np.max(abs(found[1] - before)) <= CONVERGED * np.max(abs(found[1])):
            return found
    raise ConvergenceError(JAMS)


class StartingMachine(Protocol):
    """A machine in the form of one method, for its start. Vectors (n,) are those of the method."""

    @property
    def system(self) -> System:
        """The machine itself."""

    @property
    def model(self) -> Model:
        """The model for joints and forces."""

    def restricted(self, active: tuple[int, ...]) -> Self:
        """The machine with the constraint equations `active` only."""

    def joint_terms(self, time: float, configuration: Configuration, velocity: np.ndarray) -> JointTerms:
        """Constraints and derivatives as NumPy arrays; the Jacobian for velocities in `joint_slices`."""

    def metric(self, configuration: Configuration) -> np.ndarray:
        """Positive definite matrix whose inverse defines the norm of rows of the Jacobian."""

    @property
    def slices(self) -> tuple[slice, ...]:
        """Positions of each body's freedoms in the method's vectors, its frame's six first."""

    @property
    def joint_slices(self) -> tuple[slice, ...]:
        """Positions of each body's velocities in the Jacobian's columns, its frame's six first."""

    def frame_masses(self, configuration: Configuration) -> np.ndarray:
        """Mass matrices of the bodies moving rigidly, for the velocities of their frames, (nb, 6, 6)."""

    def kinetic_energies(self, configuration: Configuration, velocity: np.ndarray) -> np.ndarray:
        """Kinetic energies of the bodies, (nb,), at velocities (n,)."""

    def least_change(
        self,
        configuration: Configuration,
        velocity: np.ndarray,
        terms: JointTerms,
        joint_residual: np.ndarray,
    ) -> np.ndarray:
        """The vector (n,) of least mass norm that cancels a residual of the joints, to first order.

        The result is added to `velocity`; the sum satisfies further conditions of the method, such as those
        of frames. The `terms` are those of the joints in this configuration.
        """

    def joint_masses(self, configuration: Configuration, terms: JointTerms) -> np.ndarray:
        """`(G M^-1 G^T)^-1` (m, m): the effective mass along the joints' equations."""

    def moved(self, configuration: Configuration, increment: np.ndarray) -> Configuration:
        """The configuration after an increment (n,)."""
