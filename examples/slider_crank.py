"""A slider-crank with a flexible connecting rod: how many modes does its stress need?

A crank of 30 mm, driven by a torque that rises to 1 Nm in 0.1 s, moves a slider of 0.5 kg through an
aluminium rod of 140 mm. The reduction keeps enough fixed-interface modes that the errors of the ten lowest
eigenvalues of the free rod are at most 1 %, and verifies these errors. This requires 19 fixed-interface
modes, 25 coordinates with the constraint modes. Three bases of 25 coordinates are then compared: this whole
basis; the 25 lowest vibration modes; 13 vibration modes with 12 attachment modes, the static responses to
forces and moments at the bores.

Expected: the slider follows the exact path of a rigid rod, r cos(phi) + sqrt(l^2 - r^2 sin^2(phi)), within
1e-6 m. The energy equals the work of the torque within 1e-4. Vibration modes alone give the correct
frequencies, but the wrong stress: without static modes of the bores the stress at node A differs by more than
a tenth from that of the whole basis, although the motion of the slider is the same to 1e-6 m. With attachment
modes the difference is below 1 %.

Run it: `python examples/slider_crank.py` draws the von Mises stress at node A, on the shank beside the big
eye, to slider_crank.png.
Source of the machine: [Han2020] section 5.2.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from supple.equations import balances
from supple.integrate import FixedStep, Run, Solution
from supple.mesh import CellType, RodCells
from supple.quantities import stress_modes
from supple.reduction import (
    AttachmentModes,
    CraigBampton,
    ErrorControlled,
    NoDerivatives,
    NoLoads,
    ReducedBody,
    reduce,
)
from supple.simulation import simulate
from supple.units import SI
from supple.viz import Panel, Series, plot_time_history
from supple_benchmarks.machines.slider_crank import SliderCrank, slider_position

machine = SliderCrank(
    cell_type=CellType.TETRA4, cells=RodCells(around=14, ring=1, shank=12, width=3, thickness=2)
).machine()


def reduced(basis) -> ReducedBody:
    """The rod in its mean axes."""
    return reduce(machine.body, machine.frame, basis, derivatives=NoDerivatives(), loads=NoLoads)


def run(rod: ReducedBody) -> Solution:
    """A quarter of a second of the machine with this rod."""
    return simulate(machine.system(rod), Run(duration=0.25, output_step=0.001, step=FixedStep(2.5e-4)))


def stress(rod: ReducedBody, solution: Solution) -> np.ndarray:
    """Von Mises stress at node A over time, Pa."""
    return stress_modes(rod, machine.model, [machine.point]).von_mises(solution.bodies["rod"].coordinates)[
        :, 0
    ]


def slider_error(solution: Solution) -> float:
    """Largest distance of the slider from its position with a rigid rod, m."""
    axes = solution.bodies["crank"].rotation
    angle = np.arctan2(axes[:, 1, 0], axes[:, 0, 0])
    return float(np.abs(solution.bodies["slider"].position[:, 0] - slider_position(angle)).max())


if __name__ == "__main__":
    certificate = reduced(ErrorControlled(0.01, n_modes=10)).report.certificate
    print(certificate)
    whole = reduced(CraigBampton(n_modes=certificate.n_fixed_interface_modes))
    # Equal numbers of coordinates, so that one compiled program serves all.
    n = whole.n_coordinates
    bodies = {
        "vibrations alone": reduced(ErrorControlled(0.01, n_modes=n)),
        "with attachment modes": reduced(AttachmentModes(ErrorControlled(0.01, n_modes=n - 12))),
        "whole basis": whole,
    }
    motions = {name: (body, run(body)) for name, body in bodies.items()}

    for _, solution in motions.values():
        assert slider_error(solution) < 1e-6
    system, solution = machine.system(whole), motions["whole basis"][1]
    energies, work = balances(system, solution), machine.work(solution)
    assert np.abs(energies.total - energies.total[0] - work).max() < 1e-4 * work.max()

    stresses = {name: stress(*motion) for name, motion in motions.items()}
    for name, values in stresses.items():
        print(f"{name}: at most {values.max():.3g} Pa at node {machine.point}")
    largest = stresses["whole basis"].max()
    missed = {
        name: np.abs(values - stresses["whole basis"]).max() / largest for name, values in stresses.items()
    }
    assert missed["vibrations alone"] > 0.1
    assert missed["with attachment modes"] < 0.01

    curves = [Series(name, solution.times, values) for name, values in stresses.items()]
    plot_time_history(Path("slider_crank.png"), [Panel("von Mises stress (Pa)", curves)], units=SI)
