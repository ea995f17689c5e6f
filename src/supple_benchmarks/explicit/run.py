"""The studies of the explicit benchmark, one after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from supple_benchmarks.computer import describe_computer
from supple_benchmarks.explicit.coupling import dual_against_primal, multi_time_steps
from supple_benchmarks.explicit.crash import crash
from supple_benchmarks.explicit.free_flight import free_flight, step_limit
from supple_benchmarks.explicit.throughput import throughput
from supple_benchmarks.progress import Announce
from supple_benchmarks.taylor_bar import taylor_bar

__all__ = ["run_explicit"]

_STUDIES: Mapping[str, tuple[str, Callable[[bool], Any]]] = {
    "free_flight": ("free flight", free_flight),
    "step_limit": ("step limits", step_limit),
    "dual_against_primal": ("multipliers against elimination", dual_against_primal),
    "multi_time_step": ("several time steps", multi_time_steps),
    "taylor_bar": ("Taylor bar", taylor_bar),
    "crash": ("crash", crash),
    "throughput": ("throughput", throughput),
}


def run_explicit(quick: bool, announce: Announce) -> Iterator[dict[str, Any]]:
    """Yield the report, ready for JSON, after each study. Tests read its keys, so they must not change."""
    report: dict[str, Any] = {"quick": quick, "machine": describe_computer()}
    for key, (label, study) in _STUDIES.items():
        progress = announce(label)
        progress(0.0)
        report[key] = study(quick)
        progress(1.0)
        yield report
