"""Intrinsic lines with few or all modes: bending, roll-up, steady rotation, free flight."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from supple.fem import BeamSection, Isotropic, lumped_mass, shell_model
from supple.integrate import FixedStep, GeneralizedAlpha, Run
from supple.linearization import linearize, machine_modes
from supple.machine import (
    DeadForce,
    FollowerTorque,
    Placed,
    PrescribedRotation,
    Spin,
    System,
)
from supple.methods.intrinsic import (
    CLAMPED,
    FREE,
    IntrinsicBody,
    IntrinsicMotion,
    RootSupport,
    condensed_line,
    intrinsic_body,
)
from supple.methods.intrinsic.truncation_error import centre_drift
from supple.simulation import simulate
from supple_benchmarks.lines import line_mesh, points_along_x, tip_at_rest
from supple_benchmarks.references.elastica import elastica
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase

__all__ = ["CASES", "slender_beam", "spinning_frequencies"]

Array = NDArray[np.float64]

WRIGHT = "A. D. Wright et al., J. Appl. Mech. 49 (1982) 197-202, table 1: uniform cantilever, no hub"
FLAP = {6.0: 7.3604, 12.0: 13.1702}
"""First flapping frequency by angular velocity, both over sqrt(EI / (m L^4))."""


def slender_beam(n: int, support: RootSupport, n_modes: int | None = None) -> IntrinsicBody:
    """A line of n segments, L = EI = GJ = 1, 1 kg/m, nearly inextensible and with little rotary inertia.

    n_modes : number of modes; None: all
    """
    points = points_along_x(1, n)
    section = BeamSection(Isotropic(1e6, 0.0, 1.0), 1.0, 1e-6, 1e-6, 2e-6, 0.0, 0.0, orientation=(0, 0, 1.0))
    model = shell_model(line_mesh(points), section)
    mass = lumped_mass(model).reshape(-1, 6)
    mass = np.hstack([mass[:, :3], np.full((n + 1, 3), mass[:, 0].mean() * 0.005**2)])
    line = condensed_line("beam", points, model.stiffness, np.diag(mass.ravel()))
    return intrinsic_body(line, support, n_modes)


def spinning_frequencies(body: IntrinsicBody, speed: float) -> Array:
    """Frequencies (m,), rad/s, about equilibrium; the root of the body rotates about z at `speed`, rad/s."""
    drive = PrescribedRotation(first="ground", second="beam.root", axis=(0, 0, 1), angle=0.0)
    return machine_modes(linearize(System([body], [drive]), spin=Spin(speed))).frequencies


def _bent() -> Sequence[Comparison]:
    along, across, _ = elastica(1.0, 1.0, 10.0)
    tip = tip_at_rest(slender_beam(20, CLAMPED, 12), DeadForce(at="beam.tip", force=(0, 0, 10.0)))
    source = "inextensible elastica, by shooting"
    return [
        Comparison("tip along the beam over L, PL^2/EI = 10, 12 modes", tip[0], along, source, 1e-3, 1.0),
        Comparison("tip across the beam over L", tip[2], across, source, 1e-3, 1.0),
    ]


def _rolled_up() -> Sequence[Comparison]:
    torque = FollowerTorque(first="beam.tip", torque=(0, -2 * np.pi, 0))
    tip = tip_at_rest(slender_beam(16, CLAMPED), torque)
    source = "constant curvature: a full circle closes"
    apart = float(np.linalg.norm(tip))
    return [Comparison("distance of the ends over L, ML/EI = 2 pi", apart, 0.0, source, 1e-6, 1.0)]


def _spinning() -> Sequence[Comparison]:
    body = slender_beam(20, CLAMPED, 10)
    found = []
    for speed, flap in FLAP.items():
        lag, flapping = spinning_frequencies(body, speed)[:2]
        of = f"frequency at speed {speed:g}, 10 modes, over sqrt(EI/(m L^4))"
        found.append(Comparison(f"flapping {of}", flapping, flap, WRIGHT, 0.01))
        own = float(np.sqrt(flap**2 - speed**2))
        found.append(Comparison(f"lag {of}", lag, own, f"{WRIGHT}; lag^2 = flap^2 - speed^2", 0.01))
    return found


def _flying() -> Sequence[Comparison]:
    body = slender_beam(12, FREE)
    spin = np.array([0.3, 0.5, 2.0])
    rates = np.zeros(body.n_coordinates)
    rates[:2] = 1.5, 0.7
    about_centre = -np.cross(spin, [0.5, 0, 0])
    placed = Placed(body, coordinate_rates=rates, angular_velocity=spin, velocity=about_centre)
    machine = System([placed])
    solution = simulate(machine, Run(0.5, 0.05, step=FixedStep(2.5e-3), method=GeneralizedAlpha(1.0)))
    motion = solution.motion("beam", IntrinsicMotion)
    energies = np.sum(motion.rates**2, axis=1) + np.sum(body.forces_of(motion.coordinates) ** 2, axis=1)
    drift = centre_drift(machine, solution, "beam")
    energy = float(energies[-1] / energies[0])
    return [
        Comparison(
            "drift of the centre of mass over L, bent and rotating", drift, 0.0, "momentum", 0.01, 1.0
        ),
        Comparison(
            "energy over its initial value, implicit midpoint rule", energy, 1.0, "conservation", 1e-8
        ),
    ]


CASES: tuple[ValidationCase, ...] = (
    ValidationCase("intrinsic line of few modes: elastica", _bent),
    ValidationCase("intrinsic line: roll-up by an end moment", _rolled_up),
    ValidationCase("intrinsic line of few modes: spinning cantilever", _spinning),
    ValidationCase("intrinsic line: free flight", _flying),
)
