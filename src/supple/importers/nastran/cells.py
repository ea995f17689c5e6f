"""Solids and shells of a Nastran deck as cells."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.importers.cell_blocks import LAYERED
from supple.importers.deck import DeckElements, IsotropicMaterial, Property, ShellProperty, SolidProperty
from supple.importers.nastran.bulk_data import BulkCard, by_id, integer_column
from supple.importers.nastran.deck_reading import DeckReading
from supple.importers.nastran.materials import Materials
from supple.importers.nastran.walls import WALL_CARDS, WallOptions, read_wall
from supple.importers.plain_number import is_plain_digits
from supple.importers.quadrilateral import CROSSED, crossed_quadrilaterals, split_quadrilaterals
from supple.mesh import CellType
from supple.mesh.reference_cell import mirrored_order

# Linear and quadratic type of the cells of solid elements.
_SOLIDS = {
    "CTETRA": (CellType.TETRA4, CellType.TETRA10),
    "CHEXA": (CellType.HEXA8, CellType.HEXA20),
    "CPENTA": (CellType.WEDGE6, CellType.WEDGE15),
    "CPYRAM": (CellType.PYRAMID5, CellType.PYRAMID13),
}
SOLID_CARDS = tuple(_SOLIDS)
SOLID_PROPERTY_CARDS = ("PSOLID", "PCOMPS")


@dataclass(frozen=True)
class _Shell:
    """A shell element: number of its corners, whether it has middle nodes, indices in `BulkCard.fields`.

    angle : of THETA or MCID;  offset : of ZOFFS;  flag : of TFLAG;  thickness : of T1
    """

    corners: int
    middles: bool
    angle: int
    offset: int
    flag: int
    thickness: int


_SHELLS = {
    "CQUAD4": _Shell(4, False, 6, 7, 9, 10),
    "CQUADR": _Shell(4, False, 6, 7, 9, 10),
    "CTRIA3": _Shell(3, False, 5, 6, 9, 10),
    "CTRIAR": _Shell(3, False, 5, 6, 9, 10),
    "CQUAD8": _Shell(4, True, 14, 15, 16, 10),
    "CTRIA6": _Shell(3, True, 8, 9, 13, 10),
}
SHELL_CARDS = tuple(_SHELLS)


def grids_named(
    cards: Sequence[BulkCard], reading: DeckReading, first: int, count: int, *, blanks: bool = False
) -> IntArray:
    """Numbers (cards, count) of the grids in `count` fields from index `first` on.

    ImportFormatError for a grid that the file does not define, and for a blank field; if `blanks`, the number
    of a field that is blank or 0 is -1.
    """
    whats = ["a middle grid"] * count if blanks else [f"grid G{i + 1}" for i in range(count)]
    default = 0 if blanks else None
    columns = [integer_column(cards, first + i, what, default) for i, what in enumerate(whats)]
    ids = np.stack(columns, axis=1)
    nodes, known = reading.grids.lookup(ids)
    absent = (ids == 0) & blanks
    wrong = np.argwhere(~known & ~absent)
    if wrong.size:
        row, corner = wrong[0]
        raise cards[row].error(
            f"element {cards[row].word(0)} names grid {ids[row, corner]}, which the file does not define; "
            "add its GRID card, or remove the element"
        )
    return np.where(absent, -1, nodes)


class Properties:
    """The properties of elements of one kind, each made once and named after its card.

    If the elements of a property card differ in their own data (offset, thickness, added mass), the card
    gives several properties: pshell_7, pshell_7_2.
    """

    def __init__(self, reading: DeckReading, *names: str) -> None:
        self._reading = reading
        self.cards = by_id(reading.file.named(*names), "property")
        self.found: dict[str, Property] = {}
        self._names: dict[tuple[int, object], str] = {}
        self._counts: dict[int, int] = {}

    def name(
        self, element: BulkCard, number: int, key: object, make: Callable[[BulkCard], Property | str]
    ) -> str:
        """Name of the property of an element; an empty string if the element is left out without it.

        number : id of the property card;  key : own data of the element
        make : function from the card to the property, or to the reason for its absence
        """
        known = self._names.get((number, key))
        if known is not None:
            return known
        card = self.cards.get(number)
        if card is None:
            made = f"their property {number} is not defined or not supported"
        else:
            try:
                made = make(card)
            except (ArithmeticError, np.linalg.LinAlgError):
                made = "its values are too large or too small"
            if not isinstance(made, str):
                self._counts[number] = count = self._counts.get(number, 0) + 1
                name = f"{card.name.lower()}_{number}" + (f"_{count}" if count > 1 else "")
                self._names[number, key], self.found[name] = name, made
                return name
            made = f"{card.name} {number}: {made}"
        self._reading.leave_out(element, f"elements left out: {made}")
        return ""


# --- solids


def read_solids(reading: DeckReading, materials: Materials) -> tuple[list[DeckElements], dict[str, Property]]:
    """Cells of CTETRA, CHEXA, CPENTA and CPYRAM, linear or quadratic, with PSOLID and PCOMPS."""
    properties = Properties(reading, *SOLID_PROPERTY_CARDS)
    middles = _Middles(reading)
    found: list[DeckElements] = []
    for name in SOLID_CARDS:
        groups: dict[tuple[str, int], list[BulkCard]] = {}
        for card in reading.file.named(name):
            number = card.property_id()
            of = properties.name(card, number, None, lambda card: _solid(card, materials))
            if of:
                groups.setdefault((of, number), []).append(card)
        for (of, number), cards in groups.items():
            found += _solid_cells(name, cards, of, properties.cards[number], reading, middles, properties)
    middles.tie()
    return found, properties.found


def _solid(card: BulkCard, materials: Materials) -> SolidProperty | str:
    """Property of a PSOLID, or of a PCOMPS with one isotropic material; else the reason for its absence."""
    if card.name == "PCOMPS":
        plies = {card.integer(i, "a ply's material") for i in range(9, len(card.fields), 8) if card.word(i)}
        material = materials.of_solid(plies.pop()) if len(plies) == 1 else ""
        if isinstance(material, IsotropicMaterial):
            return SolidProperty(material)
        return "layered solids (PCOMPS) of several or anisotropic materials are not read"
    if card.word(6) not in ("", "SMECH"):
        return f"they are fluid ({card.word(6)})"
    material = materials.of_solid(card.integer(1, "the material id"))
    return material if isinstance(material, str) else SolidProperty(material)


def _solid_cells(
    name: str,
    cards: list[BulkCard],
    of: str,
    psolid: BulkCard,
    reading: DeckReading,
    middles: _Middles,
    properties: Properties,
) -> list[DeckElements]:
    (linear, whole), system = _SOLIDS[name], psolid.integer(2, "the material's axes CORDM", 0)
    n, order = linear.n_corners, [*LAYERED.get(linear.meshio_name, range(whole.n_nodes))]
    # By default (fields IN and ISOP) CHEXA has bubble functions and so no parasitic shear in bending.
    bubble = psolid.word(3) in ("", "0", "BUBBLE") and psolid.word(5) not in ("1", "FULL")
    quadratic = [not card.is_blank(2 + n, 2 + len(order)) for card in cards]
    found: list[DeckElements] = []
    for wanted in (False, True):
        chosen = [card for card, is_quadratic in zip(cards, quadratic, strict=True) if is_quadratic == wanted]
        if not chosen:
            continue
        kind = whole if wanted else linear
        nodes = grids_named(chosen, reading, 2, n)
        if wanted:
            edges = [edge for _, edge in sorted(zip(order[n:], whole.edges, strict=True))]
            nodes = np.concatenate([nodes, middles.of(chosen, edges, nodes)], axis=1)[:, order]
        nodes = _oriented_outwards(kind, nodes, reading)
        ids, lines = integer_column(chosen, 0, "the element id"), np.array([card.line for card in chosen])
        axes = _material_axes(properties.found[of], system, nodes, reading, chosen)
        bends = kind is CellType.HEXA8 and (bubble or psolid.name != "PSOLID")
        found.append(DeckElements(name, kind, nodes, ids, lines, of, axes, incompatible=bends))
    return found


def _oriented_outwards(kind: CellType, nodes: IntArray, reading: DeckReading) -> IntArray:
    """The cells, reordered if the base is left-handed about the direction to the top, as Nastran allows."""
    n = kind.n_corners
    x = reading.positions(nodes[:, :n])
    base = 3 if n in (4, 6) else 4
    across = (x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]) if base == 3 else (x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])
    up = x[:, base:].mean(axis=1) - x[:, :base].mean(axis=1)
    inverted = np.einsum("ci,ci->c", np.cross(*across), up) < 0
    return np.where(inverted[:, None], nodes[:, mirrored_order(kind)], nodes)


def _material_axes(
    made: Property,
    system: int,
    nodes: IntArray,
    reading: DeckReading,
    cards: Sequence[BulkCard],
) -> FloatArray | None:
    """Material axes (C, 3, 3) of anisotropic solids: those of CORDM at the mean of the nodes of each.

    None for isotropic solids and for basic axes.
    """
    if not isinstance(made, SolidProperty) or isinstance(made.material, IsotropicMaterial) or system == 0:
        return None
    if system < 0:
        for card in cards:
            reading.leave_out(
                card,
                "the material axes are those of the element (CORDM = -1); basic axes are used instead",
            )
        return None
    return reading.system(cards[0], system).directions(reading.positions(nodes).mean(axis=1))


class _Middles:
    """Middle nodes of quadratic solids: those of the file, and a new node on each edge without middle node.

    In Nastran displacements are linear along an edge without middle node; the displacement of a new node is
    the mean of the displacements of its two corners.
    """

    def __init__(self, reading: DeckReading) -> None:
        self._reading = reading
        self._added: dict[tuple[int, int], tuple[int, int]] = {}

    def of(self, cards: Sequence[BulkCard], edges: Sequence[tuple[int, int]], corners: IntArray) -> IntArray:
        """Numbers (C, m) of the middle nodes of the cards, in the order of a card, as of the edges."""
        nodes = grids_named(cards, self._reading, 2 + corners.shape[1], len(edges), blanks=True)
        for row, place in np.argwhere(nodes < 0).tolist():
            a, b = sorted(int(corners[row, corner]) for corner in edges[place])
            if (a, b) not in self._added:
                positions = self._reading.positions(np.array([a, b]))
                self._added[a, b] = (self._reading.add_node(positions.mean(axis=0)), cards[row].line)
            nodes[row, place] = self._added[a, b][0]
        return nodes

    def tie(self) -> None:
        """Add the constraints  u_middle = (u_a + u_b) / 2  of all new nodes."""
        for (a, b), (middle, line) in self._added.items():
            for i in range(3):
                terms = [(6 * middle + i, 1.0), (6 * a + i, -0.5), (6 * b + i, -0.5)]
                self._reading.constraints.add(terms, line, dependent=6 * middle + i)
        if self._added:
            self._reading.note(
                f"{len(self._added)} sides of quadratic solids have no middle node; an added one follows "
                "the mean of the two corners, as in Nastran."
            )


# --- shells


def read_shells(
    reading: DeckReading, materials: Materials, added: Mapping[int, float]
) -> tuple[list[DeckElements], dict[str, Property]]:
    """Triangles of CQUAD4, CQUADR, CQUAD8, CTRIA3, CTRIAR, CTRIA6 with PSHELL, PCOMP and PCOMPG.

    added : {element id: non-structural mass of NSM cards, kg/m^2}
    """
    properties = Properties(reading, *WALL_CARDS)
    found: list[DeckElements] = []
    for name, shell in _SHELLS.items():
        groups: dict[str, list[BulkCard]] = {}
        all_cards = reading.file.named(name)
        elements = integer_column(all_cards, 0, "the element id").tolist()
        numbers = integer_column(all_cards, 1, "the property id", 0).tolist()
        for card, element, number in zip(all_cards, elements, numbers, strict=True):
            options = _wall_options(card, shell, added.get(element, 0.0))
            of = properties.name(
                card,
                number or element,
                options,
                lambda wall, options=options: read_wall(wall, materials, reading, options or _PLAIN),
            )
            if of:
                groups.setdefault(of, []).append(card)
        for of, cards in groups.items():
            found.append(_shell_cells(name, shell, cards, of, reading, properties.found[of]))
    return found, properties.found


_PLAIN = WallOptions()

FLAT = 1e-12
"""Relative difference between the mean-plane area of a quadrilateral and the area of its two triangles.

Above it, the mass of the triangles is scaled to the mean-plane area; below it, the two areas count as equal.
"""


def _wall_options(card: BulkCard, shell: _Shell, added: float) -> WallOptions | None:
    """Thicknesses, offset and added mass of an element; None if it has none of these, as most elements."""
    blank = card.is_blank(shell.thickness, shell.thickness + shell.corners)
    if blank and not added and card.is_blank(shell.offset, shell.offset + 1):
        return None
    given = tuple(
        card.real(shell.thickness + i, f"T{i + 1}") if card.word(shell.thickness + i) else None
        for i in range(shell.corners)
    )
    return WallOptions(
        given if any(t is not None for t in given) else (),
        card.word(shell.flag) == "1",
        card.real(shell.offset, "ZOFFS", 0.0),
        added,
    )


def _shell_cells(
    name: str, shell: _Shell, cards: list[BulkCard], of: str, reading: DeckReading, made: Property
) -> DeckElements:
    corners = grids_named(cards, reading, 2, shell.corners)
    positions = reading.grids.positions
    if shell.corners == 4:
        crossed = crossed_quadrilaterals(positions, corners)
        if crossed.size:
            raise cards[crossed[0]].error(f"element {cards[crossed[0]].word(0)}: {CROSSED}")
    if shell.middles:
        cells, of_card = _triangles_with_middles(shell, cards, corners, reading)
    elif shell.corners == 4:
        cells, of_card = split_quadrilaterals(positions, corners), np.repeat(np.arange(len(cards)), 2)
    else:
        cells, of_card = corners, np.arange(len(cards))
    directions = None
    if not isinstance(made, ShellProperty):
        directions = _material_directions(cards, shell, corners, reading)[of_card]
    ids, lines = integer_column(cards, 0, "the element id"), np.array([card.line for card in cards])
    share = _mass_share(positions, corners)[of_card] if shell.corners == 4 and not shell.middles else None
    return DeckElements(
        *(name, CellType.TRIANGLE3, cells, ids[of_card], lines[of_card], of, directions),
        mass_share=None if share is None or (share == 1).all() else share,
    )


def _mass_share(positions: FloatArray, corners: IntArray) -> FloatArray:
    """Ratio (k,) of the mean-plane area of quadrilaterals, used for mass, to the area of their triangles."""
    halves = positions[split_quadrilaterals(positions, corners)].reshape(-1, 2, 3, 3)
    normals = np.cross(halves[:, :, 1] - halves[:, :, 0], halves[:, :, 2] - halves[:, :, 0])
    own = np.linalg.norm(normals, axis=2).sum(axis=1)
    share = np.linalg.norm(normals.sum(axis=1), axis=1) / own
    return np.where(share > 1 - FLAT, 1.0, share)


def _triangles_with_middles(
    shell: _Shell, cards: Sequence[BulkCard], corners: IntArray, reading: DeckReading
) -> tuple[IntArray, IntArray]:
    """Triangles (T, 3) of quadratic shells, and the number (T,) of the card of each.

    A triangle at each corner between two middle nodes, then triangles of the polygon that remains.
    """
    triangles: list[list[int]] = []
    of_card: list[int] = []
    n = shell.corners
    every = grids_named(cards, reading, 2 + n, n, blanks=True).tolist()
    for row, middles in enumerate(every):
        ring: list[int] = []
        for i in range(n):
            before, after = middles[i - 1], middles[i]
            if before >= 0 and after >= 0:
                triangles.append([int(corners[row, i]), after, before])
                of_card.append(row)
            else:
                ring.append(int(corners[row, i]))
            if after >= 0:
                ring.append(after)
        rest = _ring_triangles(ring, [node for node in ring if node in middles], reading.grids.positions)
        triangles += rest
        of_card += [row] * len(rest)
    return np.array(triangles, dtype=np.int64), np.array(of_card, dtype=np.int64)


def _ring_triangles(ring: list[int], middles: list[int], positions: FloatArray) -> list[list[int]]:
    """Triangles of a polygon: a quadrilateral is cut along its shorter diagonal, others from a middle node.

    A quadrilateral with exactly one middle node is also cut from this node.
    """
    if len(ring) == 4 and len(middles) != 1:
        return split_quadrilaterals(positions, np.array([ring])).tolist()
    first = ring.index(middles[0]) if middles else 0
    ring = ring[first:] + ring[:first]
    return [[ring[0], ring[i], ring[i + 1]] for i in range(1, len(ring) - 1)]


def _material_directions(
    cards: Sequence[BulkCard], shell: _Shell, corners: IntArray, reading: DeckReading
) -> FloatArray:
    """The material's x axis (k, 3): side G1-G2 rotated by THETA, or x of MCID at the mean of the corners."""
    x = reading.grids.positions[corners]
    side = x[:, 1] - x[:, 0]
    across = (x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]) if shell.corners == 4 else (side, x[:, 2] - x[:, 0])
    normal = np.cross(*across)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    side = side - np.einsum("ki,ki->k", side, normal)[:, None] * normal
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    found = side.copy()
    for row, card in enumerate(cards):
        word = card.word(shell.angle)
        if is_plain_digits(word):
            system = reading.system(card, int(word))
            found[row] = system.directions(x[row].mean(axis=0)[None])[0][:, 0]
        elif word:
            theta = np.radians(card.real(shell.angle, "THETA"))
            found[row] = np.cos(theta) * side[row] + np.sin(theta) * np.cross(normal[row], side[row])
    return found
