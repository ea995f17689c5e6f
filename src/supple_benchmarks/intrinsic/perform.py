"""`supple benchmark intrinsic`: run, print the tables, write the report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

from supple.methods.intrinsic import CLAMPED, intrinsic_modes
from supple_benchmarks.growing_report import Study, keep_report, studied
from supple_benchmarks.intrinsic.agreement import agreement_rows
from supple_benchmarks.intrinsic.at_rest import bend_of_45_degrees, elastica_rows, order_of
from supple_benchmarks.intrinsic.beams import beam_line
from supple_benchmarks.intrinsic.box_beam import box_beam
from supple_benchmarks.intrinsic.figures import draw_figures
from supple_benchmarks.intrinsic.flying import energy_drift, flying_u
from supple_benchmarks.intrinsic.report import tables
from supple_benchmarks.intrinsic.speed import speed_rows
from supple_benchmarks.lines import points_along_x
from supple_benchmarks.progress import Announce
from supple_benchmarks.table import Row

__all__ = ["perform"]


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark, print its tables, draw its figures into `folder`.

    The report is written to `json`, or to intrinsic.json in `folder`.
    """
    keep_report(
        json or folder / "intrinsic.json",
        partial(_with_order, quick),
        tables,
        lambda report, _: draw_figures(report, folder),
    )


def _with_order(quick: bool, announce: Announce) -> Iterator[Row]:
    for report in studied(quick, _STUDIES, announce):
        if "elastica" in report:
            report["elastica_order"] = order_of(report["elastica"])
        yield report


def _orthonormality(quick: bool) -> dict[str, float]:
    """Largest deviation of the Gram matrices of Phi_1 and Phi_2 from the unit matrix, for a cantilever."""
    points = points_along_x(2, 20 if quick else 60)
    line = beam_line("beam", points, axial=1e5, bending=10.0, torsion=8.0, mass=1.3, radius=0.02)
    first, second = intrinsic_modes(line, CLAMPED).orthonormality
    return {"phi1": first, "phi2": second}


_STUDIES: Mapping[str, Study] = {
    "orthonormality": ("modes of a cantilever", _orthonormality),
    "energy_drift": ("a U that vibrates freely", energy_drift),
    "elastica": ("the elastica", elastica_rows),
    "simo45": ("the bend of 45 degrees", bend_of_45_degrees),
    "box_beam": ("the box beam", box_beam),
    "u_beam": ("the flying U", flying_u),
    "agreement": ("a strip by four methods", agreement_rows),
    "speed": ("Runge-Kutta steps", speed_rows),
}
