"""The studies of the invariance benchmark, one after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from supple_benchmarks.computer import describe_computer
from supple_benchmarks.invariance.blade_at_rest import blade_at_rest
from supple_benchmarks.invariance.buckling import lateral_buckling
from supple_benchmarks.invariance.curvature import bent_strips, turned_strips
from supple_benchmarks.invariance.damped import damped_boxes
from supple_benchmarks.invariance.locked import locked_bodies
from supple_benchmarks.invariance.splits import split_strips
from supple_benchmarks.invariance.ties import tied_boxes
from supple_benchmarks.invariance.vibration import box_vibration
from supple_benchmarks.nrel5mw_blade import COARSE_GRID, Blade
from supple_benchmarks.progress import Announce

__all__ = ["run_invariance"]

_ROWS: Mapping[str, tuple[str, Callable[[bool], Iterator[dict[str, Any]]]]] = {
    "locking": ("bodies on bases of fixed size", locked_bodies),
    "tie": ("boxes with a rotated root", tied_boxes),
    "damping": ("damped boxes in two frames", damped_boxes),
    "curvature": ("strips in large bending", bent_strips),
    "turned_element": ("strips in rotated frames", turned_strips),
    "split": ("strips split into bodies", split_strips),
}
_NUMBERS: Mapping[str, tuple[str, Callable[[bool], dict[str, Any]]]] = {
    "lateral_buckling": ("lateral buckling", lateral_buckling),
    "box_vibration": ("a swinging box", box_vibration),
}


def run_invariance(quick: bool, announce: Announce) -> Iterator[dict[str, Any]]:
    """Yield the report, ready for JSON, after each study. Tests read its keys, so they must not change."""
    report: dict[str, Any] = {"quick": quick, "machine": describe_computer()}
    for key, (label, study) in _ROWS.items():
        progress = announce(label)
        progress(0.0)
        report[key] = list(study(quick))
        progress(1.0)
        yield report
    for key, (label, study) in _NUMBERS.items():
        progress = announce(label)
        progress(0.0)
        report[key] = study(quick)
        progress(1.0)
        yield report
    progress = announce("the blade at rest")
    progress(0.0)
    rests = blade_at_rest(Blade(COARSE_GRID) if quick else Blade(), progress)
    report["blade_static"] = {frame: rest.tip for frame, rest in rests.items()}
    yield report
