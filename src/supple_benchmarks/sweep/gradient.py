"""Derivatives of a case of a sweep, integrated along its run, compared with differences of runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from supple.integrate import Tolerances
from supple.machine import System
from supple.sensitivity import Statistic, sensitivities
from supple.simulation import simulate
from supple.sweeps.plan import read_plan
from supple.sweeps.swept_group import swept_group

__all__ = ["gradient_error"]

STEP = 1e-3
"""Change of a parameter for the differences, relative to its value."""
TOLERANCE = 1e-11
"""Newton tolerance: tight, because differences divide the residual by the change of the parameter."""


def gradient_error(folder: Path, case: int) -> float:
    """Largest error of the derivatives of the tip's largest deflections, over the largest derivative.

    The references are differences of runs:

        dy/dp ~ (4 D(h) - D(2 h)) / 3,   D(h) = (y(p + h) - y(p - h)) / (2 h)       (Richardson)

    Parameters are those of the table, by the paths of the case file.

    folder : of a sweep whose case file has a sensor `tip`
    """
    plan = read_plan(folder)
    group = swept_group(folder, plan, int(plan.group[case]))
    own = group.case(case)
    run = replace(own.run, tolerances=Tolerances(TOLERANCE))
    tip = next(sensor for sensor in own.quantities if sensor.name == "tip")
    largest = Statistic("largest", tip, np.max)
    parameters = {path: float(value) for path, value in plan.table.row(case).items()}

    def build(values: Mapping[str, float]) -> System:
        return group.with_values({plan.places[path]: value for path, value in values.items()}).system

    def at(path: str, share: float) -> np.ndarray:
        system = build({**parameters, path: parameters[path] * (1 + share)})
        return largest.values(system, simulate(system, run))

    found = sensitivities(build, parameters, run, [largest]).derivatives["largest"]
    distances = []
    for path, value in parameters.items():
        coarse, fine = ((at(path, own) - at(path, -own)) / (2 * own * value) for own in (2 * STEP, STEP))
        by_differences = (4 * fine - coarse) / 3
        distances.append(np.abs(found[path] - by_differences).max() / np.abs(by_differences).max())
    return float(max(distances))
