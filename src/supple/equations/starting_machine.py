"""A machine in the hands of one engine, as its start needs it, and what joints say of one state."""

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
from supple.programs.kept_programs import KeptProgram

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


_TERMS = KeptProgram(_terms, STARTING)


def joint_terms(model: Model, time: AnyArray, configuration: Configuration, velocity: AnyArray) -> JointTerms:
    """Constraints at one position and velocity, and their derivatives."""
    return _TERMS(model.joints_alone, time, configuration, velocity)


class StartingMachine(Protocol):
    """A machine in the hands of one engine, as its start needs it. Vectors (n,) are the engine's own."""

    @property
    def system(self) -> System:
        """The machine itself."""
        ...

    @property
    def model(self) -> Model:
        """What joints and forces see of it."""
        ...

    def restricted(self, active: tuple[int, ...]) -> Self:
        """The machine with some of its constraint equations left out."""
        ...

    def joint_terms(self, time: float, configuration: Configuration, velocity: np.ndarray) -> JointTerms:
        """Constraints and their derivatives as NumPy arrays; the Jacobian for velocities in `seen_slices`."""
        ...

    def metric(self, configuration: Configuration) -> np.ndarray:
        """Positive matrix in whose inverse rows of the Jacobian are compared."""
        ...

    @property
    def slices(self) -> tuple[slice, ...]:
        """Where each body's freedoms stand in the engine's vectors, its frame's six first."""
        ...

    @property
    def seen_slices(self) -> tuple[slice, ...]:
        """Where each body's velocities stand in the Jacobian's columns, its frame's six first."""
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
        """The vector (n,) of least mass norm that takes away a residual of the joints, to first order.

        `velocity` is what it is added to: conditions on it beside the joints' hold afterwards as well. The
        `terms` are those of the joints in this configuration.
        """
        ...

    def joint_masses(self, configuration: Configuration, terms: JointTerms) -> np.ndarray:
        """`(G M^-1 G^T)^-1` (m, m): the mass that the machine has along its joints' equations."""
        ...

    def moved(self, configuration: Configuration, increment: np.ndarray) -> Configuration:
        """The configuration after an increment (n,)."""
        ...
