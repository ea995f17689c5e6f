"""A flexible arm spun up on a shaft, as a case file beside its reduced body: speeds and tip loads vary."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from supple.body import MeanAxisFrame, RayleighDamping, RigidInterface, flexible_body
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.mesh import strip
from supple.reduction import CompressedDerivatives, CraigBampton, reduce
from supple.storage import write_reduced_body
from supple.sweeps import CaseTable

__all__ = ["arm_case", "arm_table"]

_CASE = """\
title = "flexible arm on a shaft"
gravity = [0.0, 0.0, -9.81]
units = {{ length = "m", mass = "kg", time = "s" }}

[[body]]
name = "arm"
reduced = "arm.h5"

[[joint]]
name = "shaft"
kind = "prescribed-rotation"
first = "ground"
second = "arm.root"
axis = [0, 0, 1]
law = {{ kind = "spin-up", speed = 4.0, duration = 0.2 }}

[[load]]
kind = "force"
at = "arm.tip"
vector = [0.0, 0.0, 1.0]
law = {{ kind = "sine", amplitude = 1.0, frequency_hz = 3.0 }}

[[sensor]]
name = "tip"
kind = "deflection"
at = "arm.tip"

[simulation]
duration = {duration}
output_step = 0.01
step = 0.005
"""


def arm_case(folder: Path, duration: float) -> Path:
    """Write the case file and its reduced body, a steel strip of 1 m x 0.1 m x 5 mm."""
    model = shell_model(strip(1.0, 0.1, 10, 2), HomogeneousSection(Isotropic(2.1e11, 0.3, 7850.0), 5e-3))
    body = flexible_body("arm", model, [RigidInterface("root", "root"), RigidInterface("tip", "tip")])
    reduced = reduce(
        body,
        MeanAxisFrame(),
        CraigBampton(4),
        derivatives=CompressedDerivatives(4),
        damping=RayleighDamping(0.0, 1e-3, "root"),
    )
    folder.mkdir(parents=True, exist_ok=True)
    write_reduced_body(folder / "arm.h5", reduced)
    path = folder / "arm.toml"
    path.write_text(_CASE.format(duration=duration), encoding="utf-8")
    return path


def arm_table(n: int) -> CaseTable:
    """So many cases of speed and load."""
    return CaseTable(
        {
            "joint.shaft.law.speed": np.linspace(1.0, 6.0, n).tolist(),
            "load[0].law.amplitude": (1.0 + np.arange(n) % 7).tolist(),
        }
    )
