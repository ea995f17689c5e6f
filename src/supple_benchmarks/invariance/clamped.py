"""Clamped bodies in equilibrium under a dead force across their tip: full and reduced, in any frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.body import (
    FlexibleBody,
    Frame,
    FullBody,
    MeanAxisFrame,
    NodalFixedFrame,
    RigidInterface,
    flexible_body,
)
from supple.fem import FiniteElementModel
from supple.machine import GROUND, At, Constant, DeadForce, Fixed, Placed, Scaled, System
from supple.reduction import ReducedBody
from supple.simulation import equilibrium

__all__ = ["FRAMES", "clamped_body", "resting_tip"]

FRAMES: dict[str, Frame] = {"nodal-fixed": NodalFixedFrame("root"), "mean-axis": MeanAxisFrame()}

Form = TypeVar("Form", FullBody, ReducedBody)


def clamped_body(name: str, model: FiniteElementModel) -> FlexibleBody:
    """A body with its root as a rigid interface."""
    return flexible_body(name, model, (RigidInterface("root", "root"),))


def resting_tip(
    bodies: Sequence[FullBody | ReducedBody],
    nodes: ArrayLike,
    forces: ArrayLike,
    watched: ArrayLike,
    *,
    joints: Sequence[Fixed] = (),
) -> NDArray[np.float64]:
    """Mean position (3,) of the nodes `watched` of the last body, in equilibrium under dead forces on it.

    Parameters
    ----------
    bodies : from the clamped one to the loaded one
    nodes, forces : (k,), (k, 3)    of the last body
    joints : between the bodies
    """
    first, last = bodies[0], bodies[-1]
    clamp = Fixed(first=GROUND, second=At(first.name, "root"), name="clamp")
    load = DeadForce(body=last.name, at=np.asarray(nodes), force=Scaled(np.asarray(forces), Constant(1.0)))
    found = equilibrium(
        System(tuple(map(Placed, bodies)), (clamp, *joints), (load,)), fulls=()
    ).system.bodies[-1]
    return found.positions(watched).mean(axis=0)
