"""A body whose rigid root is rotated relative to its frame: false strain energy due to the tie."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from supple.body import FlexibleBody, FullBody, QuadraticStrainForce
from supple.errors import ConvergenceError
from supple_benchmarks.compared_models import FRAMES
from supple_benchmarks.invariance.box import BOX_LENGTH, box_of_walls, weak_bending
from supple_benchmarks.invariance.clamped import clamped_body, resting_tip
from supple_benchmarks.table import Row

__all__ = ["tied_boxes"]

TURNS = (0.03, 0.06, 0.12)
DEFLECTION = 0.09
"""Deflection of the loaded box over its length, in linear theory."""


def tied_boxes(quick: bool) -> Iterator[Row]:
    """Strain energy of the unloaded box with rotated root, whose exact value is 0; effect of the frame.

    energy_linear, energy : J, with the root tied to first and to second order in its rotation
    mean_axis_against_nodal_fixed : distance between the tips of the loaded box in the two frames, over the
        deflection
    """
    body = clamped_body("box", box_of_walls(8 if quick else 16))
    apart = _frames_apart(body)
    for angle in TURNS:
        turn = np.array([0.0, angle, 0.0])
        yield {
            "body": "box",
            "turn_rad": angle,
            "energy_linear": turned_energy(linearly_tied(body), turn),
            "energy": turned_energy(body, turn),
            "mean_axis_against_nodal_fixed": apart,
        }


def linearly_tied(body: FlexibleBody) -> FlexibleBody:
    """The body with interfaces tied to first order in their rotation."""
    assert body.model is not None
    return replace(body, force=QuadraticStrainForce(body.model, body.expansion))


def turned_energy(body: FlexibleBody, turn: np.ndarray) -> float:
    """Strain energy, J, of the unloaded body in equilibrium with its first interface rotated.

    turn : rotation vector (3,), rad
    Raises ConvergenceError without equilibrium.
    """
    root = body.interfaces[0]
    arms = body.nodes - root.position
    exact = np.zeros((len(body.nodes), body.dofs_per_node))
    exact[:, :3] = Rotation.from_rotvec(turn).apply(arms) - arms
    exact[:, 3:] = turn[: body.dofs_per_node - 3]
    q = splu((body.expansion.T @ body.expansion).tocsc()).solve(body.expansion.T @ exact.ravel())
    held = root.motion.indices
    q[held] = np.concatenate([np.zeros(3), turn])
    free = np.setdiff1d(np.arange(body.n), held)
    for _ in range(20):
        tangent = body.assembly.tangent(q)[free][:, free].tocsc()
        change = splu(tangent).solve(-body.assembly.internal_force(q)[free])
        q[free] += change
        if np.abs(change).max() < 1e-9:
            return float(body.assembly.energy(q))
    raise ConvergenceError(f"no equilibrium of body '{body.name}' with its root rotated by {turn}")


def _frames_apart(body: FlexibleBody) -> float:
    assert body.model is not None
    tip = body.model.mesh.nodes_of("tip")
    force = 3 * weak_bending() * DEFLECTION / BOX_LENGTH**2
    loads = np.outer(np.full(len(tip), 1 / len(tip)), [0, 0, force])
    fixed, mean = (resting_tip([FullBody(body, frame)], tip, loads, tip) for frame in FRAMES.values())
    return float(np.linalg.norm(mean - fixed) / np.linalg.norm(fixed - [BOX_LENGTH, 0, 0]))
