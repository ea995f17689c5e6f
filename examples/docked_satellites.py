"""Two satellites from bulk data, docked by a hinge: a motor rotates one relative to the other in free flight.

The program writes a deck of some 5000 grids, like a deck from a satellite manufacturer: sandwich panels
(`PCOMP`), a frame of bars, a tank and a box (`CONM2`) on `RBE2` and `RBE3`, a wing on `CBUSH` hinges, a
docking ring (`RBE2`). Both bodies of the machine come from this deck; their rings are joined.

Expected: momentum and angular momentum stay zero (to 1e-6 of 500 kg m2 times the largest angular velocity),
because no external force acts. The mean rotation of the first satellite equals that of a machine of two rigid
bodies with the inertia of the deck, within 0.1 %.
Run it: `python examples/docked_satellites.py` writes satellite.bdf and draws docked_satellites.png.
"""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import supple as sp
from supple import machine as m
from supple.body import deck_body, deck_model, rigid_mass_properties
from supple.equations import balances
from supple.importers import read_deck
from supple.importers.deck import Deck
from supple.reduction import CraigBampton
from supple.units import SI
from supple.viz import Panel, Series, draw_machine, plot_time_history

SIZE = np.array([1.6, 1.6, 2.4])
"""Length, width and height of the bus, m"""
CELLS = (24, 24, 36)
WING = (3.0, 1.2, 30, 12)
"""Length and width of the wing, m, and its cells"""
TANK, BOX, RING = 7001, 7002, 7003
HEAD = (
    "SOL 103", "CEND", "TITLE = SATELLITE", "BEGIN BULK", "PARAM,POST,-1",
    "MAT1,1,7.0+10,,.33,2700.",
    "MAT8,2,1.+6,1.+6,.3,5.+5,2.+8,1.+8,50.",
    "PCOMP,10,,,,,,,,+", "+,1,3.-4,0.,NO,2,.02,0.,NO,+", "+,1,3.-4,0.,NO",
    "PSHELL,20,1,.004,1,,1,,2.",
    "PBARL,30,1,,TUBE,,,,,+", "+,.03,.027",
    "PBUSH,40,K,1.+6,1.+6,1.+6,1.+3,2.+2,1.+3",
)  # fmt: skip
"""Materials, aluminium and honeycomb; sections of the panels, of the wing (with 2 kg/m2 of solar cells) and
of the bars of the frame; stiffness of the hinges"""
RING_TIE = f"rbe2_{RING}"
TURN, CALM, TIME = 0.3, 20.0, 40.0
"""Rotation of the hinge by the motor, rad; duration of that rotation and of the run, s"""


class Bulk:
    """Cards of a deck under construction; elements are numbered at the end."""

    def __init__(self) -> None:
        self.cards: list[str] = []
        self.elements: list[str] = []
        self.on_bus: dict[tuple[int, int, int], int] = {}

    def grid(self, number: int, position: np.ndarray) -> int:
        """A grid at a position, m."""
        self.cards.append(f"GRID,{number},," + ",".join(f"{x:.6f}" for x in position))
        return number

    def of_bus(self, *place: int) -> int:
        """The grid of the bus with given row numbers in the three directions."""
        if place not in self.on_bus:
            number = len(self.on_bus) + 1
            self.on_bus[place] = self.grid(number, SIZE * (np.array(place) / CELLS - [0.5, 0.5, 0.0]))
        return self.on_bus[place]

    def element(self, name: str, words: str) -> None:
        """Add an element; `words` are its fields after the element number."""
        self.elements.append(f"{name},{{}},{words}")

    def text(self) -> str:
        """Text of the deck."""
        numbered = (element.format(number) for number, element in enumerate(self.elements, 1))
        return "\n".join([*HEAD, *self.cards, *numbered, "ENDDATA", ""])


def bulk_data() -> str:
    """The satellite as another program would write it: N, m, kg, s."""
    bulk = Bulk()
    for normal in range(3):
        for side in (0, CELLS[normal]):
            _panel(bulk, normal, side)
        _edges(bulk, normal)
    _wing(bulk)
    floor = [bulk.of_bus(i, j, 0) for i in (8, 16) for j in (8, 16)]
    ring = [bulk.of_bus(i, j, CELLS[2]) for i in (6, 12, 18) for j in (6, 12, 18) if (i, j) != (12, 12)]
    wall = [bulk.of_bus(0, 12 + dj, 18 + dk) for dj in (-2, 2) for dk in (-2, 2)]
    for number, place in ((TANK, [0, 0, 0.5]), (BOX, [0.1 - SIZE[0] / 2, 0, 1.2]), (RING, [0, 0, SIZE[2]])):
        bulk.grid(number, np.array(place))
    bulk.element("CONM2", f"{TANK},,250.,,,,,+\n+,12.,,12.,,,9.")
    bulk.element("CONM2", f"{BOX},,30.,,,,,+\n+,.4,,.4,,,.4")
    bulk.cards += [
        f"RBE2,{name},{name},123456,{_list(own, 3)}" for name, own in ((TANK, floor), (RING, ring))
    ]
    bulk.cards.append(f"RBE3,{BOX},,{BOX},123456,1.,123,{_list(wall, 6)}")
    return bulk.text()


def _panel(bulk: Bulk, normal: int, side: int) -> None:
    a, b = (axis for axis in range(3) if axis != normal)
    for i, j in np.ndindex(CELLS[a], CELLS[b]):
        corners = []
        for place in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
            corners.append(bulk.of_bus(*np.insert(place, normal, side).tolist()))
        bulk.element("CQUAD4", f"10,{','.join(map(str, corners))}")


def _edges(bulk: Bulk, along: int) -> None:
    a, b = (axis for axis in range(3) if axis != along)
    for sides in np.ndindex(2, 2):
        at = sides[0] * CELLS[a], sides[1] * CELLS[b]
        rows = [bulk.of_bus(*np.insert(at, along, k).tolist()) for k in range(CELLS[along] + 1)]
        for ends in pairwise(rows):
            bulk.element("CBAR", f"30,{ends[0]},{ends[1]}," + ",".join(f"{x:.1f}" for x in np.eye(3)[a]))


def _wing(bulk: Bulk) -> None:
    """The wing on two hinges; a hinge is a short arm from the bus and a spring at the root of the wing."""
    length, width, along, across = WING
    root = np.array([SIZE[0] / 2 + 0.1, 0.0, SIZE[2] / 2])
    sheet = 6001 + np.arange((along + 1) * (across + 1)).reshape(along + 1, across + 1)
    for (i, j), number in np.ndenumerate(sheet):
        bulk.grid(number, root + np.array([length * i / along, width * (j / across - 0.5), 0.0]))
    for i, j in np.ndindex(along, across):
        corners = sheet[i, j], sheet[i + 1, j], sheet[i + 1, j + 1], sheet[i, j + 1]
        bulk.element("CQUAD4", f"20,{','.join(map(str, corners))}")
    for j in (across // 4, 3 * across // 4):
        on_bus = bulk.of_bus(CELLS[0], CELLS[1] // 2 + (1 if 2 * j > across else -1) * 5, CELLS[2] // 2)
        hinge = bulk.grid(6900 + j, root + np.array([0.0, width * (j / across - 0.5), 0.0]))
        bulk.element("RBE2", f"{on_bus},123456,{hinge}")
        bulk.element("CBUSH", f"40,{hinge},{sheet[0, j]},,,,0")


def _list(nodes: list[int], written: int) -> str:
    """Grid numbers as text of a card, eight fields per line, the first line after `written` fields."""
    words = [str(node) for node in nodes]
    room = 8 - written
    lines = [words[:room]] + [words[i : i + 8] for i in range(room, len(words), 8)]
    return ",\n,".join(",".join(line) for line in lines)


def machine(deck: Deck, *, rigid: bool) -> sp.System:
    """Two bodies of the deck, ring to ring; the second is upside down, rotated by 90 deg about the axis."""
    flexible = deck_body("first", deck, [sp.RigidInterface("ring", RING_TIE)]).linearized()
    interface = flexible.interface("ring")
    has = rigid_mass_properties(flexible.nodal_mass, flexible.nodes, flexible.dofs_per_node)
    bodies = []
    for name in ("first", "second"):
        if rigid:
            places = {"ring": interface.position}
            bodies.append(sp.RigidBody(name, has.mass, has.centre, has.inertia, places))
            continue
        own = replace(flexible, name=name)
        bodies.append(
            sp.reduce(
                own,
                sp.MeanAxisFrame(),
                CraigBampton(n_modes=12),
                derivatives=sp.NoDerivatives(),
                damping=sp.ModalDamping(0.01),
            )
        )
    over = Rotation.from_rotvec([np.pi, 0, 0]) * Rotation.from_rotvec([0, 0, np.pi / 2])
    second = sp.Placed(
        bodies[1],
        position=interface.position - over.apply(np.array(interface.position)),
        rotation=over.as_rotvec(),
    )
    times = np.linspace(0.0, TIME, 41)
    angle = m.Spline(times, TURN / 2 * (1 - np.cos(np.pi * np.minimum(times / CALM, 1.0))))
    hinge = sp.PrescribedRotation(first="first.ring", second="second.ring", axis=(0.0, 1.0, 0.0), angle=angle)
    return sp.System([bodies[0], second], [hinge])


def main(picture: Path = Path("docked_satellites.png")) -> float:
    """Rotation angle of the first satellite, rad."""
    file = picture.with_name("satellite.bdf")
    file.write_text(bulk_data())
    deck = read_deck(file)
    run = sp.Run(duration=TIME, output_step=0.1, step=sp.FixedStep(0.02))
    turned = {}
    for rigid in (False, True):
        system = machine(deck, rigid=rigid)
        solution = sp.simulate(system, run)
        kept = balances(system, solution)
        rates = solution.bodies["first"].angular_velocity
        largest = 500.0 * np.abs(rates).max()
        assert np.abs(kept.momentum).max() < 1e-6 * largest
        assert np.abs(kept.angular_momentum).max() < 1e-6 * largest
        axes = solution.bodies["first"].rotation
        turned[rigid] = Rotation.from_matrix(axes).as_rotvec() @ (0.0, 1.0, 0.0)
        if not rigid:
            elements = deck_model(deck)  # with the sections of beams
            machine_picture = picture.with_name(f"{picture.stem}_machine.png")
            draw_machine(machine_picture, system, solution, {"first": elements, "second": elements}, units=SI)
    after, expected = (float(each[solution.times > CALM].mean()) for each in turned.values())
    print(f"{len(deck.nodes)} grids; the first rotates by {after:.5f} rad, if rigid by {expected:.5f} rad")
    assert np.isclose(after, expected, rtol=1e-3)
    plot_time_history(
        picture,
        [
            Panel(
                "angle of the first satellite (rad)",
                [
                    Series("flexible", solution.times, turned[False]),
                    Series("rigid", solution.times, turned[True]),
                ],
            ),
            Panel(
                "difference (rad)",
                [Series("flexible", solution.times, turned[False] - turned[True])],
            ),
        ],
        units=SI,
    )
    return after


if __name__ == "__main__":
    main()
