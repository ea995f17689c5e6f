"""Protocol of a machine for its consistent start, and the joint terms at one state."""

from __future__ import annotations

from typing import NamedTuple, Protocol, Self

import jax
import jax.numpy as jnp
import numpy as np

from supple.equations.balance import constraint_jacobian
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import AnyArray, Configuration, advance
from supple.equations.joint_force import constraints
from supple.equations.machine_model import Model
from supple.machine import System
from supple.programs.program_cache import CachedProgram

__all__ = ["JointTerms", "StartingMachine", "joint_terms"]


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


class StartingMachine(Protocol):
    """A machine in the form of one method, for its start. Vectors (n,) are those of the method."""

    @property
    def system(self) -> System:
        """The machine itself."""
        ...

    @property
    def model(self) -> Model:
        """The model for joints and forces."""
        ...

    def restricted(self, active: tuple[int, ...]) -> Self:
        """The machine with the constraint equations `active` only."""
        ...

    def joint_terms(self, time: float, configuration: Configuration, velocity: np.ndarray) -> JointTerms:
        """Constraints and derivatives as NumPy arrays; the Jacobian for velocities in `joint_slices`."""
        ...

    def metric(self, configuration: Configuration) -> np.ndarray:
        """Positive definite matrix whose inverse defines the norm of rows of the Jacobian."""
        ...

    @property
    def slices(self) -> tuple[slice, ...]:
        """Positions of each body's freedoms in the method's vectors, its frame's six first."""
        ...

    @property
    def joint_slices(self) -> tuple[slice, ...]:
        """Positions of each body's velocities in the Jacobian's columns, its frame's six first."""
        ...

    def frame_masses(self, configuration: Configuration) -> np.ndarray:
        """Mass matrices of the bodies moving rigidly, for the velocities of their frames, (nb, 6, 6)."""
        ...

    def kinetic_energies(self, configuration: Configuration, velocity: np.ndarray) -> np.ndarray:
        """Kinetic energies of the bodies, (nb,), at velocities (n,)."""
        ...

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
        ...

    def joint_masses(self, configuration: Configuration, terms: JointTerms) -> np.ndarray:
        """`(G M^-1 G^T)^-1` (m, m): the effective mass along the joints' equations."""
        ...

    def moved(self, configuration: Configuration, increment: np.ndarray) -> Configuration:
        """The configuration after an increment (n,)."""
        ...
