"""The studies of the intrinsic benchmark, one after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from supple.methods.intrinsic import CLAMPED, intrinsic_modes
from supple_benchmarks.computer import describe_computer
from supple_benchmarks.intrinsic.agreement import agreement_rows
from supple_benchmarks.intrinsic.at_rest import bend_of_45_degrees, elastica_rows, order_of
from supple_benchmarks.intrinsic.beams import beam_line
from supple_benchmarks.intrinsic.box_beam import box_beam
from supple_benchmarks.intrinsic.flying import energy_drift, flying_u
from supple_benchmarks.intrinsic.speed import speed_rows
from supple_benchmarks.progress import Announce

__all__ = ["run_intrinsic"]

_STUDIES: Mapping[str, tuple[str, Callable[[bool], Any]]] = {
    "orthonormality": ("modes of a cantilever", lambda quick: _orthonormality(20 if quick else 60)),
    "energy_drift": ("a U that vibrates freely", energy_drift),
    "elastica": ("the elastica", lambda quick: list(elastica_rows(quick))),
    "simo45": ("the bend of 45 degrees", lambda _: bend_of_45_degrees()),
    "box_beam": ("the box beam", box_beam),
    "u_beam": ("the flying U", flying_u),
    "agreement": ("a strip by four methods", lambda quick: list(agreement_rows(quick))),
    "speed": ("Runge-Kutta steps", lambda quick: list(speed_rows(quick))),
}


def run_intrinsic(quick: bool, announce: Announce) -> Iterator[dict[str, Any]]:
    """Yield the report, ready for JSON, after each study. Tests read its keys, so they must not change."""
    report: dict[str, Any] = {"quick": quick, "machine": describe_computer()}
    for key, (label, study) in _STUDIES.items():
        progress = announce(label)
        progress(0.0)
        report[key] = study(quick)
        if key == "elastica":
            report["elastica_order"] = order_of(report[key])
        progress(1.0)
        yield report


def _orthonormality(n: int) -> dict[str, float]:
    """Largest deviation of the Gram matrices of Phi_1 and Phi_2 from the unit matrix, for a cantilever."""
    points = np.linspace(0, 2, n + 1)[:, None] * np.eye(3)[0]
    line = beam_line("beam", points, axial=1e5, bending=10.0, torsion=8.0, mass=1.3, radius=0.02)
    first, second = intrinsic_modes(line, CLAMPED).orthonormality
    return {"phi1": first, "phi2": second}
