"""The rotating beam at 6 rad/s reduced as far as an error allows: sizes, errors, estimates in both frames."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import FullBody, MeanAxisFrame, NodalFixedFrame
from supple.error import ReductionStart, SelfCorrection, self_correct
from supple.fem import GREEN_LAGRANGE
from supple.integrate import FixedStep, Run, Tolerances
from supple.machine import GROUND, At, Placed, PrescribedRotation, System
from supple.machine.laws.spin_up import SpinUp
from supple.reduction import (
    AmplitudeProduct,
    CompressedDerivatives,
    CraigBampton,
    StaticLoad,
    UnitLoad,
)
from supple.results import motion_error
from supple.simulation import simulate
from supple_benchmarks.rotating_beam.problem import RotatingBeam, spin_up_load

RUN = Run(
    duration=20.0,
    output_step=0.02,
    step=FixedStep(0.02),
    tolerances=Tolerances(residual=1e-9),
)


def spun_up(body):
    hinge = PrescribedRotation(
        name="hinge", first=GROUND, second=At("beam", "root"), axis=(0, -1, 0), angle=SpinUp(6.0)
    )
    return System((Placed(body),), (hinge,))


@pytest.mark.soak
@pytest.mark.parametrize(
    "frame", [NodalFixedFrame("root"), MeanAxisFrame()], ids=["nodal-fixed", "mean-axis"]
)
def test_few_coordinates_reach_micrometres_and_say_so(frame):
    """From 5 modes and 5 derivatives: at most 14 coordinates for 3e-6 m and 18 for 3e-7 m (tip: 0.6 m)."""
    beam = RotatingBeam.quick().body(GREEN_LAGRANGE)
    full = FullBody(beam, frame)
    reference = simulate(spun_up(full), RUN)
    for expected in (UnitLoad(), StaticLoad(spin_up_load(beam))):
        result = self_correct(
            spun_up(FullBody(beam, frame)),
            RUN,
            ReductionStart(
                SelfCorrection(absolute=3e-7),
                CraigBampton(n_modes=5),
                CompressedDerivatives(5, weights=AmplitudeProduct(expected)),
            ),
        ).bodies["beam"]
        sizes = np.array([each.size for each in result.rounds])
        true = np.array(
            [
                motion_error(reference, full, each.solution, each.body, body="beam").max_rms
                for each in result.rounds
            ]
        )
        estimated = np.array([each.estimated_error for each in result.rounds])
        assert sizes[0] == 10
        assert sizes[true <= 3e-6].min() <= 14
        assert sizes[true <= 3e-7].min() <= 18
        assert result.body.r <= 18
        assert (np.abs(np.log(estimated / true)) < np.log(1.4)).all()
