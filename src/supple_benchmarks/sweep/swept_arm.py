"""A flexible arm spun up on a shaft, as a case file with its mesh: speeds and tip loads vary."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from supple.cases.examples import write_example
from supple.sweeps import CaseTable

__all__ = ["ALLOWED", "arm_case", "arm_table"]

ALLOWED = 1e-4
"""Allowed error of any case, m: a sixtieth of the largest deflection of the tip."""

_CASE = """\
title = "flexible arm on a shaft"
gravity = [0.0, 0.0, -9.81]
units = {{ length = "m", mass = "kg", time = "s", force = "N", stress = "Pa" }}

[[body]]
name = "arm"
mesh = "slider_crank.inp"    # a strip of 0.14 m x 0.02 m
shell = {{ thickness = 0.5e-3, youngs_modulus = 72.0e9, poissons_ratio = 0.33, density = 2700.0 }}
frame = {{ kind = "mean-axis" }}
linear = true
damping = {{ kind = "rayleigh", alpha = 0.0, beta = 1e-3, held = "root" }}

[body.reduction]
basis = "craig-bampton"
modes = 4
accuracy = {{ absolute = {allowed}, instants = 4 }}

[[body.interface]]
name = "root"
nodes = "ROOT"

[[body.interface]]
name = "tip"
nodes = "TIP"

[[joint]]
name = "shaft"
kind = "prescribed-rotation"
first = "ground"
second = "arm.root"
axis = [0, 0, 1]
law = {{ kind = "spin-up", speed = 4.0, duration = 0.1 }}

[[load]]
kind = "force"
at = "arm.tip"
vector = [0.0, 0.0, 1.0]
law = {{ kind = "sine", amplitude = 0.05, frequency_hz = 6.0 }}

[[sensor]]
name = "tip"
kind = "deflection"
at = "arm.tip"

[simulation]
duration = {duration}
output_step = 0.003
step = 0.003
"""


def arm_case(folder: Path, duration: float) -> Path:
    """Write the case file and its mesh, the rod of the slider-crank example."""
    for path in write_example("slider_crank.toml", folder):
        if path.suffix != ".inp":
            path.unlink()
    path = folder / "arm.toml"
    path.write_text(_CASE.format(duration=duration, allowed=ALLOWED), encoding="utf-8")
    return path


def arm_table(n: int) -> CaseTable:
    """A given number of cases of speed, rad/s, and load, N."""
    return CaseTable(
        {
            "joint.shaft.law.speed": np.linspace(1.0, 6.0, n).tolist(),
            "load[0].law.amplitude": (0.02 + 0.01 * (np.arange(n) % 7)).tolist(),
        }
    )
