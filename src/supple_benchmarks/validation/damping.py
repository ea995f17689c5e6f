"""Damping ratios of a strip with a mean-axis frame and a clamped root, from eigenvalues and from resonance.

The largest amplitude of a mode with damping ratio zeta under a harmonic force is
1 / (2 zeta sqrt(1 - zeta^2)) times its static response to a constant force of equal size.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from supple.body import (
    FlexibleBody,
    FullBody,
    MeanAxisFrame,
    ModalDamping,
    NodalFixedFrame,
    RayleighDamping,
    RigidInterface,
    flexible_body,
    rayleigh_at_modes,
)
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.linearization import (
    LinearMachine,
    TranslationPort,
    frequency_response,
    linearize,
    machine_modes,
    state_space,
)
from supple.machine import GROUND, At, Fixed, Placed, System
from supple.mesh import strip
from supple.reduction import CraigBampton, NoDerivatives, reduce
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase

__all__ = ["CASES", "held_strip", "strip_body"]

RATIO = 0.02
MODES = (1, 2)
SOURCE = "closed form: the prescribed ratio of the two modes"


def strip_body() -> FlexibleBody:
    """A strip of steel, 1 x 0.1 m and 5 mm thick, along x, with the interfaces "root" and "tip"."""
    model = shell_model(strip(1.0, 0.1, 8, 2), HomogeneousSection(Isotropic(2.1e11, 0.3, 7850.0), 5e-3))
    return flexible_body("strip", model, [RigidInterface("root", "root"), RigidInterface("tip", "tip")])


def held_strip(damping: RayleighDamping | ModalDamping, *, full: bool = False) -> System:
    """The strip with a mean-axis frame and its root fixed in space; `full`: with all its coordinates."""
    body, frame = strip_body(), MeanAxisFrame()
    form = (
        FullBody(body, frame, damping)
        if full
        else reduce(body, frame, CraigBampton(8), derivatives=NoDerivatives(), damping=damping)
    )
    return System((Placed(form),), (Fixed(name="clamp", first=GROUND, second=At("strip", "root")),))


def _rayleigh() -> RayleighDamping:
    body = strip_body()
    constraint = NodalFixedFrame("root").constraint(body)
    return replace(rayleigh_at_modes(body.stiffness, body.mass, constraint, RATIO, MODES), held="root")


def _decay() -> list[Comparison]:
    """Damping ratios of the first two modes, from the eigenvalues of the machine."""
    comparisons = []
    for name, damping, full in (
        ("rayleigh", _rayleigh(), False),
        ("modal", ModalDamping(RATIO, n_modes=6, held="root"), False),
        ("rayleigh, full body", _rayleigh(), True),
    ):
        modes = machine_modes(linearize(held_strip(damping, full=full)), 2)
        for mode, ratio in zip(MODES, modes.damping_ratios, strict=True):
            comparisons.append(Comparison(f"{name}: ratio of mode {mode}", float(ratio), RATIO, SOURCE, 1e-3))
    return comparisons


def _resonance() -> list[Comparison]:
    """Largest amplitude of the tip, under a harmonic tip force near the first frequency, and closed form."""
    machine = linearize(held_strip(_rayleigh()), fulls=())
    assert isinstance(machine, LinearMachine)
    undamped = replace(machine, damping=np.zeros_like(machine.damping))
    modes = machine_modes(undamped, 1)
    first = modes.frequencies[0]
    port = TranslationPort("strip.tip", (0, 0, 1))
    space = state_space(machine, inputs=[port], outputs=[port])
    still = state_space(undamped, inputs=[port], outputs=[port])
    near = first * (1 + np.linspace(-0.01, 0.01, 201))
    largest = float(abs(frequency_response(space, near).transfer[:, 0, 0]).max())
    # Residue of the first mode: so near w1, residue / (w1^2 - w^2) exceeds the terms of all other modes.
    close = first * (1 - 1e-4)
    residue = float(frequency_response(still, [close]).transfer[0, 0, 0].real) * (first**2 - close**2)
    expected = residue / first**2 / (2 * RATIO * np.sqrt(1 - RATIO**2))
    source = "closed form: 1 / (2 zeta sqrt(1 - zeta^2)) times the static response of the mode"
    return [Comparison("amplitude at resonance, m/N", largest, expected, source, 5e-3)]


CASES: tuple[ValidationCase, ...] = (
    ValidationCase("damping of a strip clamped at its root, in mean axes", _decay),
    ValidationCase("resonance of a strip clamped at its root, in mean axes", _resonance),
)
