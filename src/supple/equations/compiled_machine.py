"""A machine of rigid and reduced bodies for the consistent start, with a dense mass matrix."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import jax
import jax.numpy as jnp
import numpy as np

from supple.equations.balance import balance
from supple.equations.build_model import build_model
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import (
    Configuration,
    ControlState,
    ControlStep,
    SystemMotion,
    advance,
)
from supple.equations.consistent_start import consistent_start
from supple.equations.control_start import first_control
from supple.equations.inertia import mass_matrix
from supple.equations.machine_model import Model
from supple.equations.start_change import StartChange
from supple.equations.starting_machine import JointTerms, converged_reactions, joint_terms
from supple.machine import System
from supple.programs.program_cache import CachedProgram


@dataclass(frozen=True, eq=False)
class CompiledMachine:
    """A `StartingMachine` with a dense mass matrix."""

    system: System
    model: Model

    def restricted(self, active: tuple[int, ...]) -> Self:
        """The machine with the constraint equations `active` only."""
        return replace(self, model=replace(self.model, active=active))

    def joint_terms(self, time: float, configuration: Configuration, velocity: np.ndarray) -> JointTerms:
        """Constraint residuals, their Jacobian, and their time derivatives, as NumPy arrays."""
        terms = joint_terms(self.model, np.asarray(float(time)), configuration, velocity)
        return JointTerms(*map(np.asarray, terms))

    def metric(self, configuration: Configuration) -> np.ndarray:
        """The mass matrix."""
        return np.asarray(_mass(self.model.bodies_alone, configuration))

    @property
    def slices(self) -> tuple[slice, ...]:
        """Positions of each body's velocities in vectors (n,)."""
        return self.model.slices

    joint_slices = slices  # joints use the coordinates directly

    def frame_masses(self, configuration: Configuration) -> np.ndarray:
        """Diagonal blocks (nb, 6, 6) of the mass matrix, for the velocities of the frames."""
        mass = self.metric(configuration)
        return np.array([mass[p.start : p.start + 6, p.start : p.start + 6] for p in self.model.slices])

    def kinetic_energies(self, configuration: Configuration, velocity: np.ndarray) -> np.ndarray:
        """`v^T M v / 2` by body; bodies are not coupled in M."""
        products = velocity * (self.metric(configuration) @ velocity)
        return np.array([products[part].sum() / 2 for part in self.model.slices])

    def least_change(
        self,
        configuration: Configuration,
        velocity: np.ndarray,  # noqa: ARG002 - only joints restrict it
        terms: JointTerms,
        joint_residual: np.ndarray,
    ) -> np.ndarray:
        """Solution x of `M x + G^T y = 0`, `G x = - residual`."""
        mass = self.metric(configuration)
        return bordered_solve(mass, terms.jacobian, np.zeros(len(mass)), -joint_residual)[: len(mass)]

    def joint_masses(self, configuration: Configuration, terms: JointTerms) -> np.ndarray:
        """`(G M^-1 G^T)^-1` (m, m): multipliers y of `least_change` for a unit residual of each equation."""
        mass, m = self.metric(configuration), len(terms.residual)
        return bordered_solve(mass, terms.jacobian, np.zeros((len(mass), m)), -np.eye(m))[len(mass) :]

    def moved(self, configuration: Configuration, increment: np.ndarray) -> Configuration:
        """The configuration after an increment."""
        return jax.tree.map(np.asarray, _moved(self.model.joints_alone, configuration, increment))


class CompiledStart(NamedTuple):
    """A consistent initial state."""

    model: Model
    """Without redundant constraints"""
    configuration: Configuration
    velocity: np.ndarray
    acceleration: np.ndarray
    multipliers: np.ndarray
    change: StartChange
    """Differences of positions and velocities from those given"""
    control: ControlState | None


def compiled_start(system: System, time: float) -> CompiledStart:
    """Consistent positions and velocities, with the corresponding accelerations and multipliers.

    `M vdot + G^T lambda = - forces`, `G vdot = - d2g/dt2` at constant velocity.
    """
    every = CompiledMachine(system, build_model(system))
    machine, configuration, velocity, change = consistent_start(every, time)
    model = machine.model
    instant = SystemMotion(np.asarray(float(time)), configuration, velocity, velocity, np.zeros(0))
    control = first_control(machine.system, model, instant)
    acceleration, multipliers = accelerations(machine, instant, control)
    return CompiledStart(model, configuration, velocity, acceleration, multipliers, change, control)


def accelerations(
    machine: CompiledMachine, instant: SystemMotion, control: ControlState | None
) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations (n,) and multipliers (m,) for given positions and velocities."""
    terms = machine.joint_terms(float(instant.time), instant.configuration, instant.velocity)
    mass = machine.metric(instant.configuration)
    step = None if control is None else ControlStep(control, np.zeros(()))
    at = instant.time, instant.configuration, instant.velocity

    def answered(*carried: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        forces = np.asarray(_forces(machine.model, *at, step, *carried))
        solution = bordered_solve(mass, terms.jacobian, -forces, -terms.acceleration_bias)
        return solution[: len(mass)], solution[len(mass) :]

    found = answered()
    return converged_reactions(answered, found) if machine.model.reads_reactions else found


def forces_without_acceleration(
    model: Model,
    time: jax.Array,
    configuration: Configuration,
    velocity: jax.Array,
    control: ControlStep | None = None,
    multipliers: jax.Array | None = None,
) -> jax.Array:
    """The residual without accelerations and joint forces, (n,).

    multipliers : of the joints, for forces that depend on them; zero by default
    """
    reactions = jnp.zeros(len(model.active)) if multipliers is None else multipliers
    still = SystemMotion(time, configuration, velocity, jnp.zeros_like(velocity), reactions, control)
    terms = balance(model, still)
    return terms.inertia + terms.internal + terms.applied


_moved = CachedProgram(advance, STARTING)
_mass = CachedProgram(mass_matrix, STARTING)
_forces = CachedProgram(forces_without_acceleration, STARTING)


def bordered_solve(mass: np.ndarray, jacobian: np.ndarray, top: np.ndarray, bottom: np.ndarray) -> np.ndarray:
    """`x`, then `y` (n + m, ...) of `M x + G^T y = top`, `G x = bottom`; one or several right-hand sides."""
    m = len(jacobian)
    scale = np.trace(mass) / len(mass)
    matrix = np.block([[mass, scale * jacobian.T], [scale * jacobian, np.zeros((m, m))]])
    solution = np.linalg.solve(matrix, np.concatenate([top, scale * bottom]))
    solution[len(mass) :] *= scale
    return solution
