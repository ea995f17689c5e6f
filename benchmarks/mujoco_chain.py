"""The rigid chain in MuJoCo: joint coordinates, fourth-order Runge-Kutta steps."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
from exudyn_run import Outcome, TimedRun

__all__ = ["MUJOCO", "in_mujoco"]

MUJOCO = find_spec("mujoco") is not None
"""Whether MuJoCo is installed"""


def in_mujoco(
    n: int, mass: float, centre: float, inertia: tuple[float, float, float], **run: float
) -> TimedRun:
    """Rods of length 1 along x on ball joints; `run` has duration, step and gravity along z."""
    import mujoco

    xml, end = "", ""
    for i in range(n):
        xml += f'<body pos="{min(i, 1)} 0 0"><joint type="ball"/>'
        xml += f'<inertial pos="{centre} 0 0" mass="{mass}" diaginertia="{" ".join(map(str, inertia))}"/>'
        end += "</body>"
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{run["step"]}" integrator="RK4" gravity="0 0 {run["gravity"]}"/>'
        f"<worldbody>{xml}{end}</worldbody></mujoco>"
    )

    def timed() -> Outcome:
        data = mujoco.MjData(model)
        steps = round(run["duration"] / run["step"])
        for _ in range(steps):
            mujoco.mj_step(model, data)
        tip = data.xpos[-1] + data.xmat[-1].reshape(3, 3)[:, 0]
        return steps, 4 * steps, 0.0, np.array(tip)[None]

    return timed
