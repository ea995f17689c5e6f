"""Flexible bodies in motion: spin-up, a travelling load, and a harmonic force."""

from __future__ import annotations

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.body import (
    FlexibleBody,
    NodalFixedFrame,
    RayleighDamping,
    RigidInterface,
    flexible_body,
)
from supple.fem import BeamSection, Isotropic, shell_model
from supple.integrate import FixedStep, FloatingMotion, Run
from supple.linearization import frequency_response, linearize, state_space
from supple.linearization.ports import TranslationPort
from supple.machine import (
    GROUND,
    At,
    DeadForce,
    Fixed,
    Placed,
    PointOnLine,
    PrescribedRotation,
    Revolute,
    SpinUp,
    System,
)
from supple.reduction import CompressedDerivatives, CraigBampton, NoDerivatives, SteadyLoads, reduce
from supple.simulation import simulate
from supple_benchmarks.beam_motion import spin_up_beam
from supple_benchmarks.lines import BENDING_ROOTS, line_mesh, points_along_x
from supple_benchmarks.planar_beam import ROTATING_BEAM
from supple_benchmarks.validation.beam_chain import rectangle
from supple_benchmarks.validation.validation_case import (
    Comparison,
    ValidationCase,
    compared,
    largest_difference,
)

__all__ = ["CASES"]

Array = NDArray[np.float64]

ENDS = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))


def _beam(length: float, n: int, section: BeamSection) -> FlexibleBody:
    nodes = points_along_x(length, n)
    return flexible_body("beam", shell_model(line_mesh(nodes), section), ENDS)


def spun_up() -> Sequence[Comparison]:
    """The beam of Simo and Vu-Quoc, spun up to 6 rad/s in 15 s: largest lag and steady extension of its tip.

    extension = m w^2 L^3 / (3 E A), with the mass per length m; lag : deflection against the rotation
    """
    length, stretching, mass = 10.0, 2.8e7, 1.2
    thickness = np.sqrt(12 * 1.4e4 / stretching)
    material = Isotropic(stretching / thickness, 0.0, mass / thickness)
    body = _beam(length, 20, rectangle(material, 1.0, thickness, thickness**3 / 3))
    recipe = SteadyLoads(CraigBampton(n_modes=4))
    reduced = reduce(body, NodalFixedFrame("root"), recipe, derivatives=CompressedDerivatives(6))
    motor = PrescribedRotation(
        name="motor", first=GROUND, second=At("beam", "root"), axis=(0, -1, 0), angle=SpinUp(6.0, 15.0)
    )
    solution = simulate(System([Placed(reduced)], [motor]), Run(20.0, 0.1, step=FixedStep(0.025)))
    tip = reduced.expand(solution.motion("beam", FloatingMotion).coordinates)[:, -1]
    exact = spin_up_beam(ROTATING_BEAM, motor.law, duration=10.0, step=0.0125, n_elements=10)
    last = solution.times > 16
    return (
        Comparison(
            "steady extension of the tip, m",
            float(tip[last, 0].mean()),
            mass * 36 * length**3 / 3 / stretching,
            "J. C. Simo, L. Vu-Quoc, J. Appl. Mech. 53 (1986) 855-863: m w^2 L^3 / (3 E A)",
            5e-3,
        ),
        Comparison(
            "largest lag of the tip, m",
            float(-tip[:, 2].min()),
            float(np.abs(exact.tip_transverse).max()),
            "geometrically exact planar beam, 10 quadratic elements, without a floating frame",
            5e-3,
        ),
    )


def travelling_load() -> Sequence[Comparison]:
    """A constant force P crosses a simply supported beam, at speed v, in one period of its lowest frequency.

        u(L/2) = 2 P L^3 / (pi^4 E I) sum sin(n pi / 2) / (n^2 (n^2 - a^2)) (sin(n w t) - a/n sin(w_n t))

    with w = pi v / L, a = w / w_1 = 1/2, the natural frequencies w_n = n^2 w_1, and the sum over n = 1, 2, ..
    """
    length, n, force = 2.0, 24, 50.0
    material = Isotropic(2.1e11, 0.0, 7800.0)
    y, z = 0.06, 0.02
    body = _beam(length, n, rectangle(material, y, z, z**3 * y / 4))
    bending = material.youngs_modulus * y * z**3 / 12
    lowest = (np.pi / length) ** 2 * np.sqrt(bending / (material.density * y * z))
    a = 0.5
    speed = a * lowest * length / np.pi
    duration = length / speed

    def nodal(t: jax.Array) -> jax.Array:
        shares = jnp.maximum(0.0, 1 - jnp.abs(jnp.arange(n + 1) - n * t / duration))
        return -force * shares[:, None] * jnp.array([0.0, 0.0, 1.0])

    reduced = reduce(body, NodalFixedFrame("root"), CraigBampton(n_modes=10), derivatives=NoDerivatives())
    joints = (
        Revolute(name="left", first=GROUND, second=At("beam", "root"), axis=(0, 1, 0)),
        PointOnLine(name="right", first=GROUND, second=At("beam", "tip"), axis=(1, 0, 0)),
    )
    load = DeadForce(body="beam", at=np.arange(n + 1), force=nodal)
    run = Run(duration, duration / 100, step=FixedStep(duration / 400))
    solution = simulate(System([Placed(reduced)], joints, [load]), run)
    found = -reduced.positions(solution.bodies["beam"], [n // 2])[:, 0, 2]
    k = np.arange(1, 60)[:, None]
    t = solution.times
    ringing = np.sin(k * a * lowest * t) - a / k * np.sin(k**2 * lowest * t)
    series = np.sin(k * np.pi / 2) / (k**2 * (k**2 - a**2)) * ringing
    exact = 2 * force * length**3 / (np.pi**4 * bending) * series.sum(axis=0)
    source = "L. Fryba, Vibration of Solids and Structures under Moving Loads (1999), chapter 1"
    return (largest_difference("deflection of the middle, m", found, exact, source, 1e-2),)


def harmonic_force() -> Sequence[Comparison]:
    """A damped cantilever with a harmonic tip force: below, at and above its first resonance, at its second.

        u / P = (sin s cosh s - cos s sinh s) / (E I* s^3 / L^3 (1 + cos s cosh s)),  s^4 = w^2 m* L^4 / E I*

    with E I* = E I (1 + i w b), m* = m (1 - i a / w), tip deflection u, mass per length m, and Rayleigh's
    damping factors a (mass) and b (stiffness).
    """
    length, y, z = 1.0, 0.03, 0.01
    material, damping = Isotropic(2.1e11, 0.0, 7800.0), RayleighDamping(alpha=2.0, beta=1e-4)
    body = _beam(length, 48, rectangle(material, y, z, z**3 * y / 4))
    recipe = CraigBampton(n_modes=8)
    reduced = reduce(body, NodalFixedFrame("root"), recipe, derivatives=NoDerivatives(), damping=damping)
    wall = Fixed(name="wall", first=GROUND, second=At("beam", "root"))
    port = TranslationPort(At("beam", "tip"), (0, 0, 1))
    bending, mass = material.youngs_modulus * y * z**3 / 12, material.density * y * z
    first = BENDING_ROOTS[0] ** 2 / length**2 * np.sqrt(bending / mass)
    w = first * np.array([0.5, 1.0, 3.0, 6.2669])
    space = state_space(linearize(System([Placed(reduced)], [wall])), inputs=[port], outputs=[port])
    found = frequency_response(space, w).transfer[:, 0, 0]
    stiff, heavy = bending * (1 + 1j * w * damping.beta), mass * (1 - 1j * damping.alpha / w)
    s = (w**2 * heavy * length**4 / stiff) ** 0.25
    exact = np.sin(s) * np.cosh(s) - np.cos(s) * np.sinh(s)
    exact *= length**3 / (stiff * s**3 * (1 + np.cos(s) * np.cosh(s)))
    source = "R. E. D. Bishop, D. C. Johnson, The Mechanics of Vibration (1960), chapter 7"
    names = (
        "half of the first frequency",
        "the first frequency",
        "three times the first frequency",
        "the second frequency",
    )
    return compared((f"receptance at {name}, m/N" for name in names), abs(found), abs(exact), source, 0.01)


CASES = (
    ValidationCase("beam spun up", spun_up),
    ValidationCase("moving load on a beam", travelling_load, quick=False),
    ValidationCase("cantilever with a harmonic tip force", harmonic_force),
)
