"""Centre of mass and bearing damping of a pendulum, identified from a measured motion.

A rod of 2 kg with a known moment of inertia about its pivot (0.5 kg m2) is released from the horizontal. Its
angle was measured 50 times a second for 6 s, with a noise of 0.02 rad. Unknown are the distance of its centre
of mass from the pivot and the damping of its bearing.

Expected: both values within three standard deviations of the true values, 0.35 m and 0.06 N m s. Each
standard deviation is below 1 % of its value, and the residuals have the size of the noise. The moment of
inertia cannot be identified in addition, because the motion depends on `m g s / J` and `c / J` only.
Run it: `python examples/calibrate_pendulum.py` draws measurement and fit to calibrate_pendulum.png.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

import supple as sp
from supple.quantities import JointMotionSensor
from supple.units import SI
from supple.viz import Panel, Series, plot_time_history

MASS, INERTIA = 2.0, 0.5
"""kg; kg m2 about the pivot"""
TRUE = {"centre": 0.35, "damping": 0.06}
"""m; N m s"""
NOISE = 0.02
"""rad"""
AXIS = (0.0, 1.0, 0.0)
RUN = sp.Run(duration=6.0, output_step=0.02, step=sp.FixedStep(0.01))
ANGLE = JointMotionSensor("angle", "pivot")


def pendulum(parameters: Mapping[str, float]) -> sp.System:
    """The horizontal rod on its pivot, for a given position of its centre and damping of the bearing."""
    centre = parameters["centre"]
    about_centre = INERTIA - MASS * centre**2
    inertia = np.diag([0.01, about_centre, about_centre])
    rod = sp.RigidBody("rod", MASS, np.array([centre, 0, 0]), inertia, {"pivot": np.zeros(3)})
    bearing = sp.TorsionSpringDamper(
        first="ground", second="rod.pivot", axis=AXIS, damping=parameters["damping"]
    )
    pivot = sp.Revolute(first="ground", second="rod.pivot", axis=AXIS, name="pivot")
    return sp.System([rod], [pivot], loads=[bearing], gravity=np.array([0, 0, -9.81]))


def measurement() -> tuple[np.ndarray, np.ndarray]:
    """Simulated measurement: times and angles with noise."""
    system = pendulum(TRUE)
    solution = sp.simulate(system, RUN)
    angle = ANGLE.values(system, solution)[:, 0]
    return solution.times, angle + NOISE * np.random.default_rng(1).normal(size=len(angle))


def main(picture: Path = Path("calibrate_pendulum.png")) -> float:
    """Distance of the centre of mass from the pivot, m."""
    times, angle = measurement()
    measured = sp.Measurement("angle", times, angle, channel="angle", deviation=NOISE)
    fit = sp.calibrate(pendulum, {"centre": 0.3, "damping": 0.1}, RUN, [ANGLE], [measured])
    print(fit)
    deviations = dict(zip(fit.parameters, fit.uncertainty.deviations, strict=True))
    for name, value in TRUE.items():
        assert abs(fit.parameters[name] - value) < 3 * deviations[name]
        assert deviations[name] < 0.01 * value
    assert np.isclose(fit.misfit, 1.0, atol=0.25)

    fitted = ANGLE.values(pendulum(fit.parameters), fit.solution)[:, 0]
    plot_time_history(
        picture,
        [
            Panel(
                "angle (rad)",
                [Series("measured", times, angle), Series("fitted", fit.solution.times, fitted)],
            ),
            Panel("residual (rad)", [Series("computed minus measured", times, fit.residuals[0])]),
        ],
        units=SI,
    )
    return fit.parameters["centre"]


if __name__ == "__main__":
    main()
