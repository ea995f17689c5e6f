"""A machine run with one variant of its flexible body, and the measurements of its motion."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from supple.body import FullBody
from supple.equations import balances, joint_residuals
from supple.fem import Isotropic
from supple.integrate import FloatingMotion, Solution
from supple.machine import System
from supple.quantities import von_mises_history
from supple.reduction import ReducedBody
from supple_benchmarks.machines.flexible_machine import FlexibleMachine

__all__ = [
    "Drift",
    "MachineRun",
    "PointHistory",
    "Variant",
    "deformation",
    "drift",
    "energy_norm",
    "equivalent_strain",
    "point_history",
]

Array = NDArray[np.float64]


class Variant(Enum):
    """The model of the flexible body; the value is its description."""

    UNREDUCED = "unreduced"
    EXACT_MODES = "exact modes"
    MODAL_COORDINATES = "modal coordinates"
    WITH_ATTACHMENT_MODES = "with attachment modes"
    WHOLE_BASIS = "whole basis"


@dataclass(frozen=True, eq=False)
class PointHistory:
    """Motion of node A: position, velocity, acceleration (t, 3), von Mises stress and strain (t,)."""

    times: Array
    position: Array
    velocity: Array
    acceleration: Array
    stress: Array
    strain: Array


class Drift(NamedTuple):
    """Drift of quantities that a run should conserve."""

    energy: float
    """Largest change of the energy less the external work, over the largest kinetic energy."""
    joints: float
    """Largest constraint residual, m or rad."""


@dataclass(frozen=True, eq=False)
class MachineRun:
    """One simulation, and the quantities compared.

    tolerance : of the eigenvalues, or None      modes : fixed-interface modes, N_d
    deformation_error : (t,), J^1/2     energy norm of the difference of its deformation from that of the
        unreduced body; for the unreduced body, of its deformation
    """

    variant: Variant
    tolerance: float | None
    modes: int | None
    body: FullBody | ReducedBody
    system: System
    solution: Solution
    point: PointHistory
    deformation_error: Array
    drift: Drift
    offline_seconds: float = 0.0


def drift(machine: FlexibleMachine, system: System, solution: Solution) -> Drift:
    """Drift of energy and joints, due to time integration and not to reduction."""
    energies = balances(system, solution)
    excess = energies.total - machine.work(solution)
    return Drift(
        float(np.abs(excess - excess[0]).max() / energies.kinetic.max()),
        float(np.abs(joint_residuals(system, solution)).max()),
    )


def point_history(machine: FlexibleMachine, body: FullBody | ReducedBody, solution: Solution) -> PointHistory:
    """The motion of node A, and its stress and strain."""
    motion = solution.motion(body.name, FloatingMotion)
    node = body.node_motion(motion, [machine.point])
    stress = von_mises_history(body, machine.model, motion.coordinates, [machine.point])[:, 0]
    return PointHistory(
        solution.times,
        node.position[:, 0],
        node.velocity[:, 0],
        node.acceleration[:, 0],
        stress,
        equivalent_strain(machine.material, stress),
    )


def equivalent_strain(material: Isotropic, stress: Array) -> Array:
    """Von Mises strain of a von Mises stress: stress over 3 G in an isotropic material."""
    shear_modulus = material.youngs_modulus / (2 + 2 * material.poissons_ratio)
    return stress / (3 * shear_modulus)


def deformation(body: FullBody | ReducedBody, solution: Solution) -> Array:
    """Displacements (n_nodal, t) of all nodes in the body's frame, m."""
    expanded = body.expand(solution.motion(body.name, FloatingMotion).coordinates)
    return expanded.reshape(len(expanded), -1).T


def energy_norm(machine: FlexibleMachine, displacements: Array) -> Array:
    """sqrt(u^T K u) (t,) of displacements (n_nodal, t), J^1/2: measures stress and strain of the whole body.

    In this norm a larger space of columns has a smaller error; at a single node this need not hold.
    """
    squares = np.einsum("nt,nt->t", displacements, machine.model.stiffness @ displacements)
    return np.sqrt(np.maximum(squares, 0.0))
