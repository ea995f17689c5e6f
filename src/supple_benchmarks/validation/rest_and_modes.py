"""Equilibria and modes of machines at rest and in steady rotation, and their error estimates."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from supple.body import BodyForm, FlexibleBody, FullBody, NodalFixedFrame, RigidInterface, flexible_body
from supple.error import ReductionStart, SelfCorrection, correct_at_rest
from supple.errors import BasisWarning, ValidityWarning
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.linearization import linearize, machine_modes
from supple.machine import GROUND, At, Placed, PrescribedRotation, Spin, System
from supple.mesh import CellType, block, strip
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, Rubin, reduce
from supple.simulation import equilibrium
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase

__all__ = ["CASES"]

LENGTH, MODULUS, DENSITY, THICKNESS = 1.0, 1e9, 1000.0, 0.01
UNIT = float(np.sqrt(MODULUS * THICKNESS**2 / 12 / DENSITY))
"""sqrt(E I / (rho A L^4)), rad/s."""
RATE = 6 * UNIT
STRETCH = DENSITY * RATE**2 * LENGTH**3 / (3 * MODULUS)
ROOT = NodalFixedFrame("root")
ELONGATION = "rho w^2 L^3 / (3 E), elongation of a bar that spins about its end"


def spinning_bar() -> Sequence[Comparison]:
    """A bar that spins about its end, with six modes: all are bending modes and contain no extension.

    Without responses to steady loads in the basis, the estimated error is therefore the whole extension.
    """
    bar = _bar()
    full = FullBody(bar, ROOT)
    start = ReductionStart(SelfCorrection(relative=1e-3), derivatives=NoDerivatives())
    rubin = reduce(bar, ROOT, Rubin(6), derivatives=NoDerivatives())
    bare = reduce(bar, ROOT, Rubin(6), derivatives=NoDerivatives(), loads=NoLoads)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)  # the bar is linear: its spin is too fast
        corrected, _ = correct_at_rest(_on_hub(full), start, spin=_spin())
        as_it_comes = equilibrium(_on_hub(rubin), spin=_spin())
        warnings.simplefilter("ignore", BasisWarning)
        short = equilibrium(_on_hub(bare), spin=_spin(), fulls=[full])
    stated = _end(bar, short.errors["bar"].displacement)[0]
    missing = STRETCH - _stretch(bar, short.system)
    return [
        Comparison(
            "stretch of the bar reduced to a relative error of 1e-3, m",
            _stretch(bar, corrected.system),
            STRETCH,
            ELONGATION,
            2e-3,
        ),
        Comparison(
            "stretch with Rubin(6) as reduced, m",
            _stretch(bar, as_it_comes.system),
            STRETCH,
            ELONGATION,
            2e-3,
        ),
        Comparison("estimated error of Rubin(6) alone, m", stated, missing, ELONGATION, 5e-3),
    ]


def cantilever_under_its_weight() -> Sequence[Comparison]:
    """A clamped strip under its own weight, with small deflection, reduced to a relative error of 1e-4."""
    body, gravity = _strip(), 0.01
    system = System((FullBody(body, ROOT),), (_hub(),), gravity=np.array([0.0, 0.0, -gravity]))
    found, _ = correct_at_rest(system, SelfCorrection(relative=1e-4))
    (placed,) = found.system.bodies
    load = DENSITY * THICKNESS * gravity
    deflection = load * LENGTH**4 / (8 * MODULUS * THICKNESS**3 / 12)
    tip = _end(body, placed.body.expand(placed.coordinates))[2]
    return [
        Comparison("tip deflection, m", tip, -deflection, "q L^4 / (8 E I), Euler-Bernoulli", 3e-3),
        Comparison(
            "estimated RMS error, over the deflection",
            found.errors["bar"].rms / deflection,
            0.0,
            "the requested accuracy",
            1e-4,
            scale=1.0,
        ),
    ]


def frequencies_of_a_spinning_beam() -> Sequence[Comparison]:
    """First flapping frequency of a strip that rotates at 6 UNIT; largest estimated error of three modes."""
    body = _strip()
    small = reduce(body, ROOT, CraigBampton(6))
    modes = machine_modes(linearize(_on_hub(small), spin=_spin(), fulls=[FullBody(body, ROOT)]), 3)
    source = "[Wright1982], hub radius 0, speed 6"
    flaps = [frequency for frequency in modes.frequencies / UNIT if frequency > 1.0]
    assert modes.error is not None
    return [
        Comparison("first flapping frequency, over sqrt(EI/(m L^4))", flaps[0], 7.3604, source, 5e-3),
        Comparison(
            "largest estimated relative error of a frequency",
            float(modes.error.relative.max()),
            0.0,
            "the modes with all coordinates",
            1e-4,
            scale=1.0,
        ),
    ]


def _bar() -> FlexibleBody:
    mesh = block(LENGTH, 0.02, THICKNESS, 8, 1, 1, CellType.HEXA20)
    model = solid_model(mesh, Isotropic(MODULUS, 0.0, DENSITY))
    return flexible_body("bar", model, (RigidInterface("root", "root"),)).linearized()


def _strip() -> FlexibleBody:
    section = HomogeneousSection(Isotropic(MODULUS, 0.0, DENSITY), THICKNESS)
    model = shell_model(strip(LENGTH, 0.1, 16, 2), section)
    return flexible_body("bar", model, (RigidInterface("root", "root"),))


def _hub() -> PrescribedRotation:
    return PrescribedRotation(name="hub", first=GROUND, second=At("bar", "root"), axis=(0, 0, 1), angle=0.0)


def _on_hub(form: BodyForm) -> System:
    return System((Placed(form),), (_hub(),))


def _spin() -> Spin:
    return Spin(RATE, np.array([0.0, 0.0, 1.0]))


def _end(body: FlexibleBody, field: np.ndarray) -> np.ndarray:
    """Mean (3,) of a nodal field (N, 3) over the nodes at the end x = L of the body."""
    return field[np.isclose(body.nodes[:, 0], LENGTH)].mean(axis=0)


def _stretch(body: FlexibleBody, system: System) -> float:
    return float(_end(body, system.bodies[0].positions() - body.nodes)[0])


CASES = (
    ValidationCase("spinning bar", spinning_bar),
    ValidationCase("cantilever under its weight", cantilever_under_its_weight, quick=False),
    ValidationCase("frequencies of a spinning beam", frequencies_of_a_spinning_beam),
)
