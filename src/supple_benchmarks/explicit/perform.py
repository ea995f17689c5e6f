"""`supple benchmark explicit`: run, print the tables, write the report."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from supple_benchmarks.explicit.coupling import dual_against_primal, multi_time_steps
from supple_benchmarks.explicit.crash import crash
from supple_benchmarks.explicit.free_flight import free_flight, step_limit
from supple_benchmarks.explicit.report import tables
from supple_benchmarks.explicit.throughput import throughput
from supple_benchmarks.growing_report import Study, keep_report, studied
from supple_benchmarks.taylor_bar import taylor_bar

__all__ = ["perform"]

_STUDIES: Mapping[str, Study] = {
    "free_flight": ("free flight", free_flight),
    "step_limit": ("step limits", step_limit),
    "dual_against_primal": ("multipliers against elimination", dual_against_primal),
    "multi_time_step": ("several time steps", multi_time_steps),
    "taylor_bar": ("Taylor bar", taylor_bar),
    "crash": ("crash", crash),
    "throughput": ("throughput", throughput),
}


def perform(quick: bool, json: Path | None, folder: Path) -> None:
    """Run the benchmark, print its tables; write the report to `json`, or to explicit.json in `folder`."""
    keep_report(json or folder / "explicit.json", partial(studied, quick, _STUDIES), tables)
