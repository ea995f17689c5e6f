"""Equilibrium of clamped bodies, full or reduced, in any frame, under dead forces on the last body."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.body import FlexibleBody, FullBody, RigidInterface, flexible_body
from supple.fem import FiniteElementModel
from supple.machine import GROUND, At, Constant, DeadForce, Fixed, Placed, Scaled, System
from supple.reduction import ReducedBody
from supple.simulation import equilibrium

__all__ = ["clamped_body", "resting_tip"]


def clamped_body(name: str, model: FiniteElementModel) -> FlexibleBody:
    """A body of the model, with the node set root as a rigid interface."""
    return flexible_body(name, model, (RigidInterface("root", "root"),))


def resting_tip(
    bodies: Sequence[FullBody | ReducedBody],
    nodes: ArrayLike,
    forces: ArrayLike,
    watched: ArrayLike,
    *,
    joints: Sequence[Fixed] = (),
) -> NDArray[np.float64]:
    """Mean position (3,) of the nodes `watched` in equilibrium under dead forces; all nodes of the last body.

    Parameters
    ----------
    bodies : chain from the clamped body to the loaded body
    nodes, forces : (k,), (k, 3)    loaded nodes, and the force on each, N
    watched : nodes of the mean
    joints : between the bodies
    """
    first, last = bodies[0], bodies[-1]
    clamp = Fixed(first=GROUND, second=At(first.name, "root"), name="clamp")
    load = DeadForce(body=last.name, at=np.asarray(nodes), force=Scaled(np.asarray(forces), Constant(1.0)))
    found = equilibrium(
        System(tuple(map(Placed, bodies)), (clamp, *joints), (load,)), fulls=()
    ).system.bodies[-1]
    return found.positions(watched).mean(axis=0)
