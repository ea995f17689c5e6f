"""Driven bodies: without a given initial velocity, a body starts with the velocity of its drive.

A beam of 1 m whose root is driven by a motor at a constant rate, or by a shaker; a satellite bus with given
spin and attached panels; a crank driven by a motor, with a flexible rod.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

import jax.numpy as jnp
import numpy as np

from supple.body import (
    BodyForm,
    FlexibleBody,
    FullBody,
    MeanAxisFrame,
    ModalDamping,
    NodalFixedFrame,
    RigidBody,
    RigidInterface,
    flexible_body,
)
from supple.fem import Isotropic, shell_model
from supple.integrate import FixedStep, FloatingMotion, GeneralizedAlpha, Run, Solution
from supple.machine import (
    GROUND,
    At,
    Ball,
    Fixed,
    Placed,
    PrescribedRotation,
    PrescribedTranslation,
    Prismatic,
    Revolute,
    System,
)
from supple.methods.intrinsic import LoadPath, condense, released
from supple.reduction import CraigBampton, NoDerivatives, reduce
from supple.simulation import simulate
from supple_benchmarks.lines import BENDING_ROOTS, line_mesh, points_along_x
from supple_benchmarks.validation.beam_chain import rectangle
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase

__all__ = ["CASES"]

MATERIAL = Isotropic(2e9, 0.0, 1000.0)
Y, Z = 0.03, 0.01
MASS = MATERIAL.density * Y * Z
FLEXIBILITY = np.sqrt(MATERIAL.youngs_modulus * Y * Z**3 / 12 / MASS)
"""sqrt(E I / m) of bending along z, m^2/s, with the mass per length m."""
SPIN = 2.0
SIDE = (0.0, 1.0, 0.0)
X, UP = np.eye(3)[[0, 2]]


def _beam(name: str = "beam") -> FlexibleBody:
    """A beam of 1 m along x; its soft bending direction is z."""
    nodes = points_along_x(1, 12)
    model = shell_model(line_mesh(nodes), rectangle(MATERIAL, Y, Z, Y * Z**3 / 4))
    return flexible_body(name, model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))


FORMS: Mapping[str, Callable[[FlexibleBody], BodyForm]] = MappingProxyType(
    {
        "nodal-fixed frame": lambda body: reduce(body, NodalFixedFrame("root"), CraigBampton(4)),
        "mean axes, linear": lambda body: reduce(
            body.linearized(), MeanAxisFrame(), CraigBampton(4), derivatives=NoDerivatives()
        ),
        "full body": lambda body: FullBody(body, MeanAxisFrame()),
        "intrinsic": lambda body: released(condense(body, LoadPath("root", "tip", n_stations=13))),
    }
)
"""Forms of the driven beam: functions of the flexible body, by name."""


def _deflection(form: BodyForm, solution: Solution, root: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Deflection (t,) of the tip along the z axis of the driven root, m.

    root : function of the times (t,); returns the rotation of the root about y, rad, and its shift along z, m
    """
    motion = solution.bodies["beam"]
    tip = form.positions(motion, [len(form.nodes) - 1])[:, 0]
    angle, shift = root(solution.times)
    return tip[:, 0] * np.sin(angle) + (tip[:, 2] - shift) * np.cos(angle)


def turned(*names: str) -> Sequence[Comparison]:
    """Beams whose root rotates at a constant rate about y, the axis of soft bending.

    names : keys of `FORMS`
    """
    drive = PrescribedRotation(
        name="drive", first=GROUND, second=At("beam", "root"), axis=SIDE, angle=lambda t: SPIN * t
    )
    comparisons = []
    for name in names:
        form = FORMS[name](_beam())
        run = Run(0.5, 0.01, FixedStep(0.01), method=GeneralizedAlpha(0.8))
        solution = simulate(System([form], [drive]), run)
        deflection = _deflection(form, solution, lambda t: np.array([SPIN * t, 0 * t]))
        comparisons.append(
            Comparison(
                f"{name}: largest deflection of the tip, m",
                float(np.abs(deflection).max()),
                0.0,
                "closed form: a beam in steady rotation only extends along its axis",
                1e-4,
                scale=1.0,
            )
        )
    return comparisons


def shaken(*names: str) -> Sequence[Comparison]:
    """Beams whose root moves by a sin(w t) along z; initially all points have the velocity a w of the drive.

    Mode by mode, with participation factor g:  q'' + w_n^2 q = g a w^2 sin(w t), q = q' = 0 at the start.

    names : keys of `FORMS`
    """
    size, rate = 0.002, 5.0
    table = PrescribedTranslation(
        name="table",
        first=GROUND,
        second=At("beam", "root"),
        axis=(0, 0, 1),
        displacement=lambda t: size * jnp.sin(rate * t),
    )
    run = Run(1.0, 0.01, FixedStep(0.005), method=GeneralizedAlpha(0.9))
    comparisons = []
    for name in names:
        form = FORMS[name](_beam())
        solution = simulate(System([form], [table]), run)
        found = _deflection(form, solution, lambda t: np.array([0 * t, size * np.sin(rate * t)]))
        exact = sum(_modal_responses(solution.times, size, rate))
        comparisons.append(
            Comparison(
                f"{name}: largest deflection of the tip, m",
                float(np.abs(found).max()),
                float(np.abs(exact).max()),
                "closed form: modes of a cantilever on a shaken base, Euler and Bernoulli",
                0.01,
            )
        )
    return comparisons


def _modal_responses(times: np.ndarray, size: float, rate: float) -> list[np.ndarray]:
    """Deflections (t,) of the tip relative to the root, m, in each of the first three modes."""
    responses = []
    for number, root in enumerate(BENDING_ROOTS[:3]):
        ratio = (np.cosh(root) + np.cos(root)) / (np.sinh(root) + np.sin(root))
        at_tip = 2 * (-1) ** number * 2 * ratio / root  # mode shape at the tip times participation factor
        own = root**2 * FLEXIBILITY
        amplitude = size * rate**2 / (own**2 - rate**2)
        responses.append(at_tip * amplitude * (np.sin(rate * times) - rate / own * np.sin(own * times)))
    return responses


def bus_and_panels() -> Sequence[Comparison]:
    """A satellite bus of given spin; the centres of its two panels rotate with it at r = 0.2 + 0.5 m.

    The panels have no given velocity.
    """
    spin, offset = 0.1, 0.2
    bus = RigidBody("bus", 5.0, np.zeros(3), np.eye(3), {"right": offset * X, "left": -offset * X})
    panels = [
        reduce(_beam(name), NodalFixedFrame("root"), CraigBampton(4), damping=ModalDamping(0.2))
        for name in ("right", "left")
    ]
    bodies = [
        Placed(bus, angular_velocity=np.array([0, spin, 0])),
        Placed(panels[0], position=offset * X),
        Placed(panels[1], position=-offset * X, rotation=np.array([0, 0, np.pi])),
    ]
    joints = [
        Fixed(name=f"{side} weld", first=At("bus", side), second=At(side, "root"))
        for side in ("right", "left")
    ]
    solution = simulate(System(bodies, joints), Run(2.0, 0.01, FixedStep(0.01)))
    force = float(np.linalg.norm(solution.joint_forces["right weld"][1:, :3].mean(axis=0)))
    return [
        Comparison(
            "spin of the bus at the end, rad/s",
            float(solution.motion("bus", FloatingMotion).angular_velocity[-1, 1]),
            spin,
            "closed form: a rigid satellite keeps its spin",
            1e-6,
        ),
        Comparison(
            "mean force of a panel on its weld, N",
            force,
            MASS * (offset + 0.5) * spin**2,
            "closed form: m r w^2",
            0.02,
        ),
    ]


def slider_crank() -> Sequence[Comparison]:
    """A slider-crank with an upright crank and a motor: no initial velocity is given."""
    radius = 0.2
    pins = {"hub": np.zeros(3), "pin": radius * UP}
    crank = RigidBody("crank", 1.0, radius / 2 * UP, 0.1 * np.eye(3), pins)
    slider = RigidBody("slider", 0.5, np.zeros(3), 0.1 * np.eye(3), {"pin": np.zeros(3)})
    joints = [
        PrescribedRotation(
            name="motor", first=GROUND, second=At("crank", "hub"), axis=SIDE, angle=lambda t: SPIN * t
        ),
        Ball(name="big end", first=At("crank", "pin"), second=At("beam", "root")),
        Revolute(name="small end", first=At("slider", "pin"), second=At("beam", "tip"), axis=SIDE),
        Prismatic(name="way", first=GROUND, second=At("slider", "pin"), axis=(1, 0, 0)),
    ]
    rod = reduce(_beam(), NodalFixedFrame("root"), CraigBampton(4))
    placed = Placed(rod, position=radius * UP, rotation=np.array([0, np.arcsin(radius), 0]))
    system = System([crank, placed, Placed(slider, position=np.sqrt(1 - radius**2) * X)], joints)
    solution = simulate(system, Run(0.02, 0.01, FixedStep(0.01)))
    rates = solution.motion("beam", FloatingMotion).coordinate_rates[0]
    source = "closed form: the mechanism of rigid links"
    speed = radius * SPIN
    return [
        Comparison(
            "speed of the slider at the start, m/s",
            float(solution.motion("slider", FloatingMotion).velocity[0, 0]),
            speed,
            source,
            1e-9,
        ),
        Comparison(
            "energy of the rod's deformation rate at the start, J",
            float(rates @ rates / 2),
            0.0,
            source,
            1e-12,
            scale=MASS * speed**2 / 2,
        ),
    ]


CASES: tuple[ValidationCase, ...] = (
    ValidationCase(
        "beam rotated at a constant rate, no velocity given", lambda: turned("nodal-fixed frame", "intrinsic")
    ),
    ValidationCase("beam on a shaker, no velocity given", lambda: shaken("mean axes, linear")),
    ValidationCase(
        "beam rotated at a constant rate, other methods",
        lambda: turned("mean axes, linear", "full body"),
        quick=False,
    ),
    ValidationCase(
        "beam on a shaker, other methods",
        lambda: shaken("nodal-fixed frame", "full body", "intrinsic"),
        quick=False,
    ),
    ValidationCase("bus of given spin with panels fixed to it", bus_and_panels),
    ValidationCase("slider-crank with a flexible rod, no velocity given", slider_crank),
)
