"""A bar hits a wall: its nose is modelled by plastic hexahedra, the rest by vibration modes.

Expected: the energy balance closes to a thousandth. The nose absorbs more than half of the initial energy.
Run it: `python examples/impact.py` draws the energies to impact.png.
"""

from pathlib import Path

import numpy as np

import supple as sp
from supple.machine import Contact, RigidPlane, Tie
from supple.methods.explicit import ENERGIES, Energies, J2Plasticity, LinearHardening
from supple.reduction import NormalModes

ALUMINIUM = sp.Isotropic(70e9, 0.3, 2700.0)
SPEED = np.array([30.0, 0.0, 0.0])


def system() -> sp.System:
    """The bar: 1 m of hard alloy as 20 modes, a soft nose of 0.2 m of elements, and a wall at its tip."""
    rest = sp.block(1.0, 0.1, 0.1, 20, 2, 2, sp.CellType.TETRA4)
    nose = sp.block(0.2, 0.1, 0.1, 4, 2, 2, sp.CellType.HEXA8)
    nose = sp.Mesh(nose.nodes + np.array([1.0, 0.0, 0.0]), nose.cells, nose.node_sets)
    body = sp.flexible_body("rest", sp.solid_model(rest, ALUMINIUM))
    law = J2Plasticity(ALUMINIUM, LinearHardening(100e6, 300e6))
    soft = sp.explicit_subdomain(sp.solid_model(nose, ALUMINIUM), law, name="nose")
    return sp.System(
        [
            sp.Placed(sp.modal_subdomain(body, NormalModes(20), yield_stress=500e6), velocity=SPEED),
            sp.Placed(soft, velocity=SPEED),
        ],
        ties=[Tie(sp.At("nose", "root"), "rest")],
        contacts=[Contact(sp.At("nose", "tip"), RigidPlane((1.2, 0, 0), (-1, 0, 0)))],
    )


def main(picture: Path = Path("impact.png")) -> np.ndarray:
    """Energies (t, 8), J, drawn over time."""
    solution = sp.simulate(system(), sp.Run(1.2e-3, 2.4e-5))
    energies = solution.series[ENERGIES]
    balance = energies[:, :7].sum(axis=1) - energies[:, 7]
    assert np.abs(balance / balance[0] - 1).max() < 1e-3
    assert energies[-1, 2] > 0.5 * energies[0, 0]

    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.subplots()
    for name, values in zip(Energies._fields, energies.T, strict=True):
        axes.plot(1e3 * solution.times, values, label=name)
    axes.set(xlabel="time, ms", ylabel="energy, J")
    axes.legend(ncols=2)
    figure.savefig(picture)
    return energies


if __name__ == "__main__":
    main()
