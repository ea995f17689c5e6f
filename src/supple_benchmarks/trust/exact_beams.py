"""The sum of all error parts, including the model's, compared with geometrically exact beams.

A full run of the same elements in the same frame cannot show the error of the kinematics. A geometrically
exact beam of another formulation can: slender strips with Poisson's ratio zero are such beams, except for the
mesh error, which is negligible.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.body import (
    BodyForm,
    Frame,
    FullBody,
    MeanAxisFrame,
    NodalFixedFrame,
    RigidInterface,
    flexible_body,
)
from supple.error import ErrorStudy, state_errors
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import PARTS, FixedStep, Run
from supple.machine import GROUND, At, DeadForce, Fixed, Placed, System, Table
from supple.mesh import strip
from supple.quantities import PositionSensor
from supple.reduction import (
    CompressedDerivatives,
    CraigBampton,
    DerivativeChoice,
    NoLoads,
    ReducedBody,
    reduce,
)
from supple.simulation import simulate
from supple_benchmarks.progress import Progress
from supple_benchmarks.references.simo_reissner import straight_beam, swung
from supple_benchmarks.table import Row

__all__ = ["EXACT_BEAMS", "ExactBeamCase", "assess_by_exact_beam"]

Array = NDArray[np.float64]

FRAMES: dict[str, Frame] = {"root": NodalFixedFrame("root"), "mean axes": MeanAxisFrame()}
TIP = "tip of the beam"


@dataclass(frozen=True)
class ExactBeamCase:
    """A strip and its run, and the motion of its tip in space by a geometrically exact beam."""

    name: str
    made: Callable[[], tuple[FullBody, Callable[[BodyForm], System], DerivativeChoice, Run, PositionSensor]]
    exact: Callable[[], Array]
    """Positions of the tip (t, 3) at the output times"""


def assess_by_exact_beam(case: ExactBeamCase, progress: Progress) -> Row:
    """Estimated error of the tip of a body of fixed size, and its distance from the exact beam's tip."""
    full, system_of, derivatives, run, tip = case.made()
    body: ReducedBody = reduce(
        full.body, full.frame, CraigBampton(n_modes=10), derivatives=derivatives, loads=NoLoads
    )
    system = system_of(body)
    solution = state_errors(
        system, run, simulate(system, run, check=False), ErrorStudy(quantities=(tip,)), fulls=[full]
    )
    progress(0.6)
    stated = solution.errors[tip.name]
    apart = tip.values(system, solution) - case.exact()
    progress(1.0)
    return {
        "name": case.name,
        "coordinates": body.r,
        "parts": {part: stated.parts[part].value for part in PARTS},
        "size": stated.size,
        "stated_total": stated.total,
        "true_total": float(np.linalg.norm(apart, axis=1).max()),
    }


LENGTH, WIDTH, THICKNESS = 1.0, 0.1, 0.01
MODULUS, DENSITY = 1e9, 1000.0
SLOWLY, QUICKLY = 2.0, 0.6
"""s, durations of the push; the first mode has a period of 0.6 s."""
STEP, HALF, FINER = 0.01, 2, 4
"""Output step, s, and divisors of it that give the steps of the run and of the exact beam."""


def _bent(force: float, push: float, frame: str) -> ExactBeamCase:
    """Case of a cantilever that a force at its tip, a single pulse of sine-squared shape, bends strongly."""

    def forces(step: float) -> tuple[Array, Array]:
        times: Array = step * np.arange(round(1.2 * push / step) + 1, dtype=np.float64)
        over = np.where(times < push, np.sin(np.pi * times / push) ** 2, 0.0)
        return times, force * over[:, None] * [0.0, 0.0, 1.0]

    def made() -> tuple[FullBody, Callable[[BodyForm], System], DerivativeChoice, Run, PositionSensor]:
        ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
        model = shell_model(
            strip(LENGTH, WIDTH, 24, 2), HomogeneousSection(Isotropic(MODULUS, 0.0, DENSITY), THICKNESS)
        )
        body = flexible_body("body", model, ends)
        wall = Fixed(name="wall", first=GROUND, second=At("body", "root"))
        # Tabulated at the steps of the exact beam, because a table interpolates linearly.
        load = DeadForce(body="body", at="tip", force=Table(*forces(STEP / FINER)))
        return (
            FullBody(body, FRAMES[frame]),
            lambda form: System((Placed(form),), (wall,), (load,)),
            CompressedDerivatives(15),
            Run(1.2 * push, STEP, step=FixedStep(STEP / HALF)),
            PositionSensor(TIP, "body.tip"),
        )

    def exact() -> Array:
        area, inertia = WIDTH * THICKNESS, np.array([WIDTH * THICKNESS**3, THICKNESS * WIDTH**3]) / 12
        E, G, k = MODULUS, MODULUS / 2, 5 / 6
        beam = straight_beam(
            LENGTH,
            16,
            [E * area, k * G * area, k * G * area, 4 * G * inertia[0], E * inertia[0], E * inertia[1]],
            mass=DENSITY * area,
            inertia=DENSITY * np.array([inertia.sum(), inertia[0], inertia[1]]),
        )
        return swung(beam, forces(STEP / FINER)[1], step=STEP / FINER)[0][::FINER, -1]

    return ExactBeamCase(f"bent by {force:g} N in {push:g} s, {frame}", made, exact)


EXACT_BEAMS = (
    *(_bent(force, SLOWLY, frame) for frame in FRAMES for force in (4.0, 8.0)),
    *(_bent(4.0, QUICKLY, frame) for frame in FRAMES),
)
"""Large bending by slow pushes, and by pushes as long as the period of the first mode."""
