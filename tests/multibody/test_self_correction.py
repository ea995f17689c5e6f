"""Self-correcting reduction against the full run that it never makes."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import MeanAxisFrame, NodalFixedFrame
from supple.errors import AccuracyError, ConvergenceError, ModelError
from supple.integrate import FixedStep, Tolerances
from supple.multibody import (
    GROUND,
    FullBody,
    Placed,
    PrescribedRotation,
    SelfCorrection,
    SelfCorrectionError,
    System,
    TimeFunction,
    self_correct,
    self_correction,
    simulate,
)
from supple.reduction import CompressedDerivatives, CraigBampton, NoDerivatives

FRAMES = {"nodal-fixed": NodalFixedFrame("root"), "mean-axis": MeanAxisFrame()}
START = CraigBampton(n_modes=3)
RUN = {
    "duration": 2.0,
    "output_step": 0.02,
    "step": FixedStep(0.02),
    "tolerances": Tolerances(residual=1e-9),
}


@pytest.fixture(scope="module")
def strip_body(blade):
    """The strip of the other tests, held at its root alone."""
    return blade


def spun(body):
    """The blade, 1 m long, driven about the width of its root with an angular acceleration that grows in time."""
    hinge = PrescribedRotation(
        name="hinge", first=GROUND, second=("blade", "root"), axis=(0, -1, 0), angle=_cubic
    )
    return System((Placed(body),), (hinge,))


_cubic = TimeFunction(lambda t: 0.12 * t**3)
