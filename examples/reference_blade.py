"""The blade of the IEA Wind 22 MW reference turbine, 138 m long, from its public table of 6 x 6 sections.

There is no mesh: position, stiffness and inertia at 30 stations (iea22_blade.csv) define the blade. It is
clamped at its root and bends under its weight in the flap direction, then under twice the weight.

Expected:
- Mass per length within 1e-4 of the turbine's repository, 82 087.9 kg over 136.988 m.
- Frequencies of the clamped blade within 1.5 % (three edgewise modes) and 5 % (two flapwise modes) of those
  of OpenFAST at zero speed. OpenFAST gives frequencies of the rotating rotor in wind (outputs/02_stability of
  the repository), where the flapwise modes have aerodynamic damping of 7 to 30 %. These frequencies are
  extrapolated: a linear function of the squared speed is fitted to the squared mean of backward and forward
  whirl at 1.85, 2.46 and 3.08 rpm.
- Tip deflection under a hundredth of the weight within 0.3 % of that from the integrated strains due to the
  weight beyond each section. Under the whole weight the deflection is less than proportional.

Run it: `python examples/reference_blade.py` draws the bent blade to reference_blade.png.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import supple as sp
from supple import machine as m
from supple.importers import SectionTable, read_section_table
from supple.methods.intrinsic import CLAMPED, IntrinsicBody, intrinsic_body, section_line

TABLE = Path(__file__).parent / "iea22_blade.csv"
MASS_PER_LENGTH = 82087.9 / 136.988  # tests/test_blade_mass.py of the turbine's repository, kg/m
RPM = np.array([1.846621632938634, 2.4621625867571804, 3.0777034135700827])
WHIRL = {
    "flap 1": [(0.398877, 0.458528), (0.409373, 0.486304), (0.431388, 0.522871)],
    "edge 1": [(0.500024, 0.56157), (0.496181, 0.578228), (0.49109, 0.593621)],
    "flap 2": [(1.075421, 1.136789), (1.076318, 1.157886), (1.076805, 1.178288)],
    "edge 2": [(1.489196, 1.550743), (1.496216, 1.578278), (1.505409, 1.607987)],
    "edge 3": [(3.217066, 3.278588), (3.229108, 3.311133), (3.247746, 3.350271)],
}
"""Backward and forward whirl of the rotor at the three speeds, Hz."""
MODES = {"flap 1": 0, "edge 1": 1, "flap 2": 2, "edge 2": 3, "edge 3": 5}
DOWN = np.array([-9.81, 0, 0])


def at_rest(pairs: list[tuple[float, float]]) -> float:
    """Frequency of a mode at zero speed, extrapolated from its whirl frequencies at three speeds, Hz."""
    return float(np.sqrt(np.polyfit(RPM**2, np.mean(pairs, axis=1) ** 2, 1)[1]))


def tip_deflection(table: SectionTable, gravity: np.ndarray, steps: int = 2000) -> np.ndarray:
    """Linear tip deflection (3,), m: strains due to the weight beyond each section, integrated."""
    s = (np.arange(steps) + 0.5) * table.lengths[-1] / steps
    ds = table.lengths[-1] / steps
    places, axes, stiffness, inertia = table.at(s)
    per_length = inertia[:, 0, 0]
    centre = np.column_stack([inertia[:, 1, 5], inertia[:, 2, 3], 0 * s]) / per_length[:, None]
    arms = places + np.einsum("nij,nj->ni", axes, centre)
    weight = per_length[:, None] * gravity * ds
    moment = np.cross(arms, weight)

    def beyond(values):
        return np.cumsum(values[::-1], axis=0)[::-1] - 0.5 * values

    force = beyond(weight)
    both = np.stack([force, beyond(moment) - np.cross(places, force)], axis=1)
    strain = np.linalg.solve(stiffness, (both @ axes).reshape(steps, 6, 1)).reshape(steps, 2, 3)
    stretch, turn = np.einsum("nij,nkj->kni", axes, strain)
    return ((stretch + np.cross(turn, table.positions[-1] - places)) * ds).sum(axis=0)


def bent(blade: IntrinsicBody, gravity: np.ndarray) -> np.ndarray:
    """Positions of the stations of the blade in equilibrium (n, 3), m."""
    root = m.Fixed(first="ground", second="blade.root", name="root")
    rest = sp.equilibrium(sp.System([blade], [root], gravity=gravity)).solution.bodies["blade"]
    return blade.places(rest)[1][0]


def main(picture: Path = Path("reference_blade.png")) -> None:
    """Compare the blade with published numbers, and draw it bent."""
    table = read_section_table(TABLE)
    blade = intrinsic_body(section_line("blade", table, 41), CLAMPED)
    print(
        f"blade: {table.lengths[-1]:.2f} m, {blade.mass:.0f} kg, centre at {blade.centre_of_mass.round(3)} m"
    )
    assert abs(blade.mass / table.lengths[-1] / MASS_PER_LENGTH - 1) < 1e-4

    found = blade.modes.frequencies / (2 * np.pi)
    for name, pairs in WHIRL.items():
        here, expected = found[MODES[name]], at_rest(pairs)
        print(f"{name}: {here:.4f} Hz, of OpenFAST's rotor {expected:.4f} Hz ({here / expected - 1:+.2%})")
        assert abs(here / expected - 1) < (0.015 if name.startswith("edge") else 0.05)

    rest = blade.line.tree.points
    small = (bent(blade, 0.01 * DOWN) - rest)[-1] * 100
    by_hand = tip_deflection(table, DOWN)
    print(f"tip under its weight, linear: {small.round(4)} m, by hand {by_hand.round(4)} m")
    assert np.abs(small - by_hand).max() < 3e-3 * np.linalg.norm(by_hand)

    places = {f"{share:g} x weight": bent(blade, share * DOWN) for share in (1, 2)}
    drops = [each[-1, 0] - rest[-1, 0] for each in places.values()]
    print(f"tip under its weight {drops[0]:.3f} m, under twice that {drops[1]:.3f} m")
    assert abs(by_hand[0]) > abs(drops[0]) > abs(drops[1]) / 2

    figure = Figure(figsize=(9, 3), layout="constrained")
    axes = figure.add_subplot(xlabel="z, m", ylabel="x, m", aspect="equal")
    for name, each in ({"unloaded": rest} | places).items():
        axes.plot(each[:, 2], each[:, 0], label=name)
    axes.legend()
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    main()
