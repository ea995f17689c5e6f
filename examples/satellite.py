"""A free satellite with two flexible panels rotates by means of a reaction wheel.

No external force acts. A motor drives a wheel against the hub, first in one direction, then in the other. Hub
and panels rotate in the opposite direction, and the panels vibrate.

Expected: momentum and angular momentum stay zero for any torque of the motor (to 1e-8 of the wheel's largest
angular momentum). After the vibrations have decayed, the hub has rotated by the angle of a rigid satellite
within 0.2 %, `-J_w/(J_s + J_w)` times the relative angle of the wheel, with the moments of inertia J_w of the
wheel and J_s of hub and panels.
Run it: `python examples/satellite.py` draws hub and panel to satellite.png.
"""

from pathlib import Path

import numpy as np

import supple as sp
from supple import machine as m
from supple.equations import balances
from supple.quantities import DeflectionSensor, JointMotionSensor, Place
from supple.reduction import CraigBampton, ReducedBody
from supple.units import SI
from supple.viz import Panel, Series, plot_time_history

HUB, WHEEL = 20.0, 0.5
"""Moments of inertia about the axis, kg m2"""
PANEL, HALF = 2.0, 0.5
"""Length of a panel, and distance of its root from the axis, m"""
AXIS = (0.0, 0.0, 1.0)


SHEET = sp.strip(PANEL, 0.6, 8, 2)


def panel(name: str) -> ReducedBody:
    """An aluminium sheet, its normal along y."""
    upright = SHEET.nodes @ np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    mesh = sp.Mesh(upright, SHEET.cells, SHEET.node_sets)
    model = sp.shell_model(mesh, sp.HomogeneousSection(sp.Isotropic(70e9, 0.3, 2700.0), 0.004))
    body = sp.flexible_body(name, model, [sp.RigidInterface("root", "root")]).linearized()
    return sp.reduce(
        body,
        sp.MeanAxisFrame(),
        CraigBampton(n_modes=6),
        derivatives=sp.NoDerivatives(),
        damping=sp.RayleighDamping(0.0, 0.02),
    )


def satellite() -> sp.System:
    """Hub, wheel and panels, free in space; the motor between hub and wheel."""
    places = {"centre": np.zeros(3), "right": np.array([HALF, 0, 0]), "left": np.array([-HALF, 0, 0])}
    hub = sp.RigidBody("hub", 100.0, np.zeros(3), np.diag([15.0, 15.0, HUB]), places)
    wheel = sp.RigidBody("wheel", 5.0, np.zeros(3), np.diag([0.3, 0.3, WHEEL]), {"axle": np.zeros(3)})
    return sp.System(
        bodies=[
            hub,
            wheel,
            sp.Placed(panel("right"), position=places["right"]),
            sp.Placed(panel("left"), position=places["left"], rotation=np.array([0, 0, np.pi])),
        ],
        joints=[
            m.Revolute(first="hub.centre", second="wheel.axle", axis=AXIS, name="axle"),
            m.Fixed(first="hub.right", second="right.root"),
            m.Fixed(first="hub.left", second="left.root"),
        ],
        loads=[
            m.TorqueBetween(
                first="hub.centre",
                second="wheel.axle",
                axis=AXIS,
                torque=m.Table([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 100.0], [0, 1, 1, -1, -1, 0, 0]),
            )
        ],
    )


def main(picture: Path = Path("satellite.png")) -> float:
    """Angle of the hub at the end, rad."""
    system = satellite()
    solution = sp.simulate(system, sp.Run(duration=12.0, output_step=0.05, step=sp.FixedStep(0.01)))
    kept = balances(system, solution)
    turned = JointMotionSensor("wheel", "axle").values(system, solution)
    largest = WHEEL * abs(turned[:, 1]).max()
    assert np.abs(kept.momentum).max() < 1e-8 * largest
    assert np.abs(kept.angular_momentum).max() < 1e-8 * largest

    panels = sum(_inertia_of(placed) for placed in system.bodies[2:])
    axes = solution.bodies["hub"].rotation
    hub = np.unwrap(np.arctan2(axes[:, 1, 0], axes[:, 0, 0]))
    rigid = -WHEEL / (HUB + panels + WHEEL) * turned[:, 0]
    assert np.isclose(hub[-1], rigid[-1], rtol=2e-3)

    tip = Place("right", tuple(SHEET.nodes_of("tip").tolist()))
    swing = DeflectionSensor("tip", tip, m.At("right", "root")).values(system, solution)
    plot_time_history(
        picture,
        [
            Panel(
                "angle of the hub (rad)",
                [Series("satellite", solution.times, hub), Series("rigid", solution.times, rigid)],
            ),
            Panel("deflection (m)", [Series("tip of a panel", solution.times, swing[:, 1])]),
        ],
        units=SI,
    )
    return float(hub[-1])


def _inertia_of(placed: sp.Placed) -> float:
    """Moment of inertia of a panel about the satellite's axis, kg m2: a sheet of uniform mass."""
    middle = HALF + PANEL / 2
    return placed.body.mass * (PANEL**2 / 12 + middle**2)


if __name__ == "__main__":
    main()
