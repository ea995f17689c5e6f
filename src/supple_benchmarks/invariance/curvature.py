"""Large bending of a strip in a frame on its root, and in frames rotated relative to the root."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from supple.body import FullBody
from supple_benchmarks.compared_models import FRAMES
from supple_benchmarks.invariance.clamped import clamped_body, resting_tip
from supple_benchmarks.invariance.strip import (
    BENDING,
    LENGTH,
    TORSION,
    ClampedStrip,
    beam_model,
    strip_model,
)
from supple_benchmarks.references.elastica import force_for_rotation
from supple_benchmarks.table import Row

__all__ = ["bent_strips", "turned_strips"]

ROTATIONS = (0.291, 0.573, 0.874)
"""Rotations of the tip, rad."""
TURN = 0.2
"""Rotation of the frame relative to the root, rad."""


def bent_strips(quick: bool) -> Iterator[Row]:
    """Distance of the tip from that of the elastica, over the deflection; the frame is on the root."""
    models = {"shell": (strip_model(20), np.array([0.25, 0.5, 0.25])), "beam": (beam_model(40), np.ones(1))}
    for rotation in ROTATIONS[: 1 if quick else None]:
        force, (along, across) = force_for_rotation(BENDING, LENGTH, rotation)
        for element, (model, weights) in models.items():
            tip = model.mesh.nodes_of("tip")
            body = FullBody(clamped_body("strip", model), FRAMES["nodal-fixed"])
            found = resting_tip([body], tip, np.outer(weights, [0, 0, force]), tip)
            error = float(np.hypot(found[0] - along, found[2] - across) / across)
            yield {"element": element, "tip_rotation": rotation, "error": error}


def turned_strips(quick: bool) -> Iterator[Row]:
    """The strip under bending and under torsion, in frames rotated about x, y and z.

    energy_ratio : strain energy of the same deformation with the frame rotated, over that without rotation
    tip_moved : change of the tip position under the same load; bent: over the deflection; twisted: over
        the length times the rotation of the tip
    """
    strip = ClampedStrip(10 if quick else 20)
    tip = strip.mesh.nodes_of("tip_centre")[0]
    loads = {
        "bent": strip.tip_force([0, 0, force_for_rotation(BENDING, LENGTH, 0.291)[0]]),
        "twisted": strip.tip_couple(0.3 * TORSION / LENGTH),
    }
    for case, load in loads.items():
        motion = strip.bent(load)
        own = strip.energy(np.zeros(3), motion)
        size = np.linalg.norm(motion[tip, :3]) if case == "bent" else LENGTH * abs(motion[tip, 3])
        for axis, direction in zip("xyz", np.eye(3), strict=True):
            turn = TURN * direction
            moved = strip.seen_from(turn, load, motion) - motion
            yield {
                "element": "shell",
                "case": case,
                "axis": axis,
                "turn_rad": TURN,
                "energy_ratio": strip.energy(turn, motion) / own,
                "tip_moved": float(np.linalg.norm(moved[tip, :3]) / size),
            }
