"""`supple benchmark invariance`: run, print the tables, write the report."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from supple_benchmarks.growing_report import Study, keep_report, studied
from supple_benchmarks.invariance.blade_at_rest import blade_at_rest
from supple_benchmarks.invariance.buckling import lateral_buckling
from supple_benchmarks.invariance.curvature import bent_strips, turned_strips
from supple_benchmarks.invariance.damped import damped_boxes
from supple_benchmarks.invariance.figures import draw_figures
from supple_benchmarks.invariance.locked import locked_bodies
from supple_benchmarks.invariance.report import tables
from supple_benchmarks.invariance.splits import split_strips
from supple_benchmarks.invariance.ties import tied_boxes
from supple_benchmarks.invariance.vibration import box_vibration

__all__ = ["perform"]

_STUDIES: Mapping[str, Study] = {
    "locking": ("bodies on bases of fixed size", locked_bodies),
    "tie": ("boxes with a rotated root", tied_boxes),
    "damping": ("damped boxes in two frames", damped_boxes),
    "curvature": ("strips in large bending", bent_strips),
    "turned_element": ("strips in rotated frames", turned_strips),
    "split": ("strips split into bodies", split_strips),
    "lateral_buckling": ("lateral buckling", lateral_buckling),
    "box_vibration": ("a swinging box", box_vibration),
    "blade_static": ("the blade at rest", blade_at_rest),
}


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark, print its tables, draw its figure into `folder`.

    The report is written to `json`, or to invariance.json in `folder`.
    """
    keep_report(
        json or folder / "invariance.json",
        partial(studied, quick, _STUDIES),
        tables,
        lambda report, _: draw_figures(report, folder),
    )
