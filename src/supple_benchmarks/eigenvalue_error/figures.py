"""Figure 4 of [Han2020] redrawn."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from supple.reduction import SearchStep
from supple.viz.error_curves import plot_eigenvalue_error
from supple_benchmarks.eigenvalue_error.run import BodyResult

__all__ = ["draw_figures"]


def draw_figures(results: Sequence[BodyResult], folder: Path) -> list[Path]:
    """[Han2020] Fig. 4 for every body at its tightest tolerance; the pictures' paths."""
    folder.mkdir(parents=True, exist_ok=True)
    pictures = []
    for result in results:
        one = min(result.results, key=lambda each: each.tolerance)
        shown = _shown(one.steps)
        pictures.append(
            plot_eigenvalue_error(
                folder / f"figure_4_{result.case.name}_{result.case.element}.png",
                {step.n_modes: step.errors for step in shown},
                one.tolerance,
                exact={one.modes: one.exact},
            )
        )
    return pictures


def _shown(steps: Sequence[SearchStep], n: int = 4) -> list[SearchStep]:
    """The last step, and earlier ones that are evenly spaced on a logarithmic scale."""
    finite = sorted((step for step in steps if np.isfinite(step.largest)), key=lambda step: step.n_modes)
    last = steps[-1]
    earlier = [step for step in finite if step.n_modes < last.n_modes]
    if not earlier:
        return [last]
    wanted = np.geomspace(max(earlier[0].n_modes, 1), last.n_modes, n)[:-1]
    numbers = np.array([step.n_modes for step in earlier])
    chosen = dict.fromkeys(int(np.argmin(abs(np.log(numbers / each)))) for each in wanted)
    return [*(earlier[i] for i in chosen), last]
