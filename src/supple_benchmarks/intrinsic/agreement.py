"""Large tip rotation of a slender strip, in equilibrium under a dead force at its tip, by four methods."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from time import process_time

import numpy as np
from numpy.typing import NDArray

from supple.body import AveragingInterface, FullBody, NodalFixedFrame, RigidInterface, flexible_body
from supple.errors import ConvergenceError
from supple.fem import FiniteElementModel, HomogeneousSection, Isotropic, shell_model
from supple.machine import DeadForce, Fixed, Joint, System, split_body
from supple.mesh import AlongAxis, strip
from supple.methods.intrinsic import LoadPath, condense
from supple.reduction import CompressedDerivatives, CraigBampton, NoLoads, ReducedBody, reduce
from supple.simulation.equilibrium import equilibrium
from supple_benchmarks.intrinsic.blade import blade_rows
from supple_benchmarks.lines import tip_at_rest
from supple_benchmarks.references.elastica import force_for_rotation
from supple_benchmarks.table import Row

__all__ = ["METHODS", "agreement_rows", "tip_by"]

LENGTH, WIDTH, THICKNESS, MODULUS = 1.0, 0.1, 0.005, 2.1e11
BENDING = MODULUS * WIDTH * THICKNESS**3 / 12
METHODS = ("full", "floating", "split", "intrinsic")
N_LENGTH = 24
ENDS = (RigidInterface("root", "root"), AveragingInterface("tip", "tip"))


def agreement_rows(quick: bool) -> Iterator[Row]:
    """Rows of the strip compared with the elastica, one per method and rotation, then rows of the blade."""
    for method in METHODS:  # compiles the programs before times are measured
        tip_by(method, 0.05)
    for rotation in (0.29, 0.87) if quick else (0.01, 0.03, 0.1, 0.29, 0.57, 0.87, 1.2, 1.5):
        for method in METHODS:
            yield tip_by(method, rotation)
    yield from blade_rows(quick)


def tip_by(method: str, rotation: float) -> Row:
    """A row of the report: the strip by one method, under the force that rotates the tip by `rotation`, rad.

    The force is that of the elastica. The error is the distance of the tip from that of the elastica, over
    the deflection. It is None if the method finds no equilibrium, as one floating frame at large rotations.
    """
    force, exact = force_for_rotation(BENDING, LENGTH, rotation)
    began = process_time()
    error: float | None = None
    with suppress(ConvergenceError):
        tip = {"full": _full, "floating": _floating, "split": _split, "intrinsic": _intrinsic}[method](force)
        error = float(np.hypot(*(tip[[0, 2]] - exact)) / exact[1])
    return {
        "body": "strip",
        "tip_rotation": rotation,
        "method": method,
        "error": error,
        "seconds": process_time() - began,
    }


def _model() -> FiniteElementModel:
    wall = HomogeneousSection(Isotropic(MODULUS, 0.0, 7800.0), THICKNESS)
    return shell_model(strip(LENGTH, WIDTH, N_LENGTH, 2), wall)


def _resting(
    bodies: Sequence[FullBody | ReducedBody], force: float, joints: Sequence[Joint] = ()
) -> NDArray[np.float64]:
    """The tip of a chain of bodies, clamped at its root, with a force on its tip."""
    clamp = Fixed(first="ground", second=f"{bodies[0].name}.root")
    loads = [DeadForce(at=f"{bodies[-1].name}.tip", force=(0.0, 0.0, force))]
    placed = equilibrium(System(bodies, [clamp, *joints], loads)).system.bodies[-1]
    tip = placed.body.interface("tip")
    moved = np.asarray(tip.motion @ placed.coordinates)[:3]
    return placed.position + placed.rotation @ (tip.position + moved)


def _full(force: float) -> NDArray[np.float64]:
    body = flexible_body("strip", _model(), ENDS)
    return _resting([FullBody(body, NodalFixedFrame("root"))], force)


def _floating(force: float) -> NDArray[np.float64]:
    body = flexible_body("strip", _model(), ENDS)
    reduced = reduce(
        body, NodalFixedFrame("root"), CraigBampton(6), derivatives=CompressedDerivatives(8), loads=NoLoads
    )
    return _resting([reduced], force)


def _split(force: float) -> NDArray[np.float64]:
    parts = split_body("strip", _model(), AlongAxis(4, (1, 0, 0)), ENDS)
    held = ["root", *(f"cut-{number + 1}" for number in range(3))]
    bodies = [
        reduce(
            part, NodalFixedFrame(name), CraigBampton(4), derivatives=CompressedDerivatives(4), loads=NoLoads
        )
        for part, name in zip(parts.parts, held, strict=True)
    ]
    return _resting(bodies, force, parts.joints)


def _intrinsic(force: float) -> NDArray[np.float64]:
    shells = flexible_body("strip", _model(), ENDS)
    body = condense(shells, LoadPath("root", "tip", N_LENGTH + 1), n_modes=60)
    return tip_at_rest(body, DeadForce(at="strip.tip", force=(0.0, 0.0, force)))
