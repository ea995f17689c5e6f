"""A robot arm of two flexible links under gravity with PD control of its joints.

Two aluminium rods of half a metre are released from the horizontal. Each joint is driven by
`k (target - angle) - c rate`; its target rises smoothly within half a second. Without integral action a
steady error remains under gravity.

Expected: at the end the rates have decayed. The angle error of each joint times its gain then equals the
moment of the weights beyond the joint within 0.5 %. The deflection of the links changes the lever arms by
less than that.
Run it: `python examples/robot_arm.py` draws the angles to robot_arm.png.
"""

from pathlib import Path

import jax.numpy as jnp
import numpy as np

import supple as sp
from supple import machine as m
from supple.quantities import JointMotionSensor
from supple.reduction import CraigBampton, ReducedBody
from supple.units import SI
from supple.viz import Panel, Series, plot_time_history

RADIUS, LENGTH, DENSITY, G = 0.02, 0.5, 2700.0, 9.81
TARGETS = {"shoulder": 0.8, "elbow": -0.5}
STIFFNESS = {"shoulder": 900.0, "elbow": 300.0}
DAMPING = {"shoulder": 40.0, "elbow": 8.0}
AXIS = (0.0, -1.0, 0.0)


def link(name: str) -> ReducedBody:
    """A rod along x, reduced to six modes and the constraint modes of its ends."""
    mesh = sp.cylinder(RADIUS, LENGTH, 2, 1, 6, sp.CellType.TETRA10)
    model = sp.solid_model(mesh, sp.Isotropic(70e9, 0.33, DENSITY))
    ends = [sp.RigidInterface("root", "root"), sp.RigidInterface("tip", "tip")]
    body = sp.flexible_body(name, model, ends).linearized()
    damping = sp.RayleighDamping(0.0, 2e-5)
    return sp.reduce(
        body, sp.MeanAxisFrame(), CraigBampton(n_modes=6), derivatives=sp.NoDerivatives(), damping=damping
    )


def outputs(time, reads, _states):
    """Torques of both joints, N m."""
    share = jnp.clip(time / 0.5, 0.0, 1.0)
    rising = share**3 * (10 - 15 * share + 6 * share**2)
    return {
        name: STIFFNESS[name] * (TARGETS[name] * rising - reads[name].angle)
        - DAMPING[name] * reads[name].rate
        for name in TARGETS
    }


def arm() -> sp.System:
    """Both links, their hinges, gravity, and the controller."""
    ends = {"shoulder": ("ground", "upper.root"), "elbow": ("upper.tip", "fore.root")}
    return sp.System(
        bodies=[link("upper"), sp.Placed(link("fore"), position=np.array([LENGTH, 0, 0]))],
        joints=[m.Revolute(first=a, second=b, axis=AXIS, name=name) for name, (a, b) in ends.items()],
        gravity=np.array([0, 0, -G]),
        controllers=[
            m.Controller(
                reads={name: m.JointReading(name) for name in ends},
                drives={name: m.TorqueBetween(first=a, second=b, axis=AXIS) for name, (a, b) in ends.items()},
                outputs=outputs,
            )
        ],
    )


def main(picture: Path = Path("robot_arm.png")) -> np.ndarray:
    """Angles of both joints over time (t, 2), rad."""
    system = arm()
    solution = sp.simulate(system, sp.Run(duration=2.0, output_step=0.01, step=sp.FixedStep(2e-3)))
    motions = [JointMotionSensor(name, name).values(system, solution) for name in TARGETS]
    angles = np.stack([motion[:, 0] for motion in motions], axis=1)
    assert max(abs(motion[-1, 1]) for motion in motions) < 1e-3

    weights = [placed.body.mass * G for placed in system.bodies]
    upper, fore = angles[-1, 0], angles[-1].sum()
    elbow = weights[1] * LENGTH / 2 * np.cos(fore)
    shoulder = elbow + (weights[0] / 2 + weights[1]) * LENGTH * np.cos(upper)
    held = [STIFFNESS[name] * (TARGETS[name] - angles[-1, i]) for i, name in enumerate(TARGETS)]
    assert np.allclose(held, [shoulder, elbow], rtol=5e-3)

    curves = [Series(name, solution.times, angles[:, i]) for i, name in enumerate(TARGETS)]
    plot_time_history(picture, [Panel("angle (rad)", curves)], units=SI)
    return angles


if __name__ == "__main__":
    main()
