"""A strip in large bending, as one body and split into several bodies, each with its own frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from supple.body import FullBody, MeanAxisFrame, NodalFixedFrame, RigidInterface
from supple.fem import FiniteElementModel
from supple.machine import Fixed, split_body
from supple.mesh import AlongAxis
from supple_benchmarks.compared_models import FRAMES
from supple_benchmarks.invariance.clamped import clamped_body, resting_tip
from supple_benchmarks.invariance.strip import BENDING, LENGTH, strip_model
from supple_benchmarks.references.elastica import force_for_rotation
from supple_benchmarks.table import Row

__all__ = ["split_strips"]


def split_strips(quick: bool) -> Iterator[Row]:
    """Distance of the tip from that of the elastica, over the deflection, by frame and number of bodies k."""
    model = strip_model(24)
    weights = np.array([0.25, 0.5, 0.25])
    for rotation in (0.874,) if quick else (0.291, 0.573, 0.874, 1.2):
        force, (along, across) = force_for_rotation(BENDING, LENGTH, rotation)
        for name in FRAMES:
            for k in (1, 2) if quick else (1, 2, 4):
                bodies, joints, tip = _parts(model, name, k)
                found = resting_tip(bodies, tip, np.outer(weights, [0, 0, force]), tip, joints=joints)
                error = float(np.hypot(found[0] - along, found[2] - across) / across)
                yield {"k": k, "frame": name, "tip_rotation": rotation, "error": error}


def _parts(
    model: FiniteElementModel, frame: str, k: int
) -> tuple[list[FullBody], Sequence[Fixed], ArrayLike]:
    """Bodies from the root to the tip, their joints, and the tip nodes of the last body."""
    if k == 1:
        return [FullBody(clamped_body("strip", model), FRAMES[frame])], (), model.mesh.nodes_of("tip")
    split = split_body("strip", model, AlongAxis(k, (1, 0, 0)), (RigidInterface("root", "root"),))
    held = ["root", *(f"cut-{number + 1}" for number in range(k - 1))]
    bodies = [
        FullBody(part, NodalFixedFrame(name) if frame == "nodal-fixed" else MeanAxisFrame())
        for part, name in zip(split.parts, held, strict=True)
    ]
    return bodies, split.joints, split.mesh.parts[-1].mesh.nodes_of("tip")
