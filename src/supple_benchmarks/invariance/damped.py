"""A damped box in two frames: strain-rate damping is independent of the frame."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from supple.body import FlexibleBody, LinearRayleighDamping, RayleighDamping
from supple.reduction import CompressedDerivatives, CraigBampton, NoLoads, reduce
from supple_benchmarks.compared_models import FRAMES
from supple_benchmarks.invariance.box import BOX_LENGTH, box_of_beams
from supple_benchmarks.invariance.clamped import clamped_body
from supple_benchmarks.invariance.vibration import pushed, swinging_tip
from supple_benchmarks.table import Row

__all__ = ["damped_boxes"]

BETA = 0.0145
"""Factor of the stiffness, s: a damping ratio of 2 % at the first frequency."""


def damped_boxes(quick: bool) -> Iterator[Row]:
    """Largest distance between the tip in the two frames, over the largest deflection, for three dampings.

    frames_apart : strain-rate damping;   frames_apart_linear : damping with the stiffness of the undeformed
    body;   undamped_apart : without damping
    """
    body = clamped_body("box", box_of_beams(10 if quick else 20))
    apart = {
        "frames_apart": _apart(body, RayleighDamping(0.0, BETA), quick),
        "frames_apart_linear": _apart(body, LinearRayleighDamping(0.0, BETA), quick),
        "undamped_apart": _apart(body, None, quick),
    }
    yield {"body": "box", "beta": BETA, **apart}


def _apart(body: FlexibleBody, damping: RayleighDamping | LinearRayleighDamping | None, quick: bool) -> float:
    times, forces = pushed(2.5 if quick else 10.0, 0.11)
    fixed, mean = (
        swinging_tip(
            reduce(
                body,
                frame,
                CraigBampton(6),
                derivatives=CompressedDerivatives(12),
                damping=damping,
                loads=NoLoads,
            ),
            times,
            forces,
        )
        for frame in FRAMES.values()
    )
    swing = np.linalg.norm(fixed - [BOX_LENGTH, 0, 0], axis=1).max()
    return float(np.linalg.norm(mean - fixed, axis=1).max() / swing)
