"""Elements of a Nastran file as cells: their grids, and the cell set of what they are made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.errors import ImportFormatError
from supple.importers.nastran.beams import BEAM_OPTIONS, Orientation, beam_orientation
from supple.importers.nastran.bulk_data import BulkCard, BulkFile
from supple.importers.nastran.grids import GridPoints
from supple.importers.nastran.properties import PROPERTY_CARDS
from supple.importers.numbering import first_repeated
from supple.importers.quadrilateral import CROSSED, crossed_quadrilaterals, split_quadrilaterals
from supple.mesh import CellType

IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class _Element:
    """How an element card names its grids: the places allowed for them and the cells they make."""

    kinds: Mapping[int, CellType]
    order: Mapping[int, tuple[int, ...]]
    forbidden: tuple[tuple[int, str], ...] = ()


# Nastran lists the middle nodes of a hexahedron bottom, upright, top; a CellType bottom, top, upright.
_HEXA20_ORDER = (*range(12), *range(16, 20), *range(12, 16))
_ELEMENTS = {
    "CTETRA": _Element({4: CellType.TETRA4, 10: CellType.TETRA10}, {}),
    "CHEXA": _Element({8: CellType.HEXA8, 20: CellType.HEXA20}, {20: _HEXA20_ORDER}),
    "CTRIA3": _Element(
        {3: CellType.TRIANGLE3}, {}, ((6, "an offset ZOFFS"), *((10 + i, f"T{i + 1}") for i in range(3)))
    ),
    "CBAR": _Element({2: CellType.LINE2}, {}, BEAM_OPTIONS),
    "CBEAM": _Element({2: CellType.LINE2}, {}, BEAM_OPTIONS),
    "CQUAD4": _Element(
        {4: CellType.TRIANGLE3}, {}, ((7, "an offset ZOFFS"), *((10 + i, f"T{i + 1}") for i in range(4)))
    ),
}
ELEMENT_CARDS = tuple(_ELEMENTS)
_GRID_COUNT = {"CTRIA3": 3, "CQUAD4": 4, "CBAR": 2, "CBEAM": 2}
_PROPERTIES = {
    "CTETRA": ("PSOLID",),
    "CHEXA": ("PSOLID",),
    "CTRIA3": ("PSHELL",),
    "CQUAD4": ("PSHELL",),
    "CBAR": ("PBAR", "PBARL"),
    "CBEAM": ("PBEAM", "PBEAML"),
}


@dataclass(frozen=True, eq=False)
class MadeOf:
    """Property card of a cell set, and the orientation of its beams."""

    card: BulkCard
    orientation: Orientation | None


@dataclass(frozen=True, eq=False)
class ElementCells:
    """The elements of one card name and number of grids, as cells of one type.

    set_names : the cell set of each card;  sections : what each cell set is made of
    """

    kind: CellType
    nodes: IntArray
    cards: tuple[BulkCard, ...]
    set_names: tuple[str, ...]
    sections: dict[str, MadeOf]

    @property
    def per_card(self) -> int:
        """Cells of each element: 2 of a quadrilateral."""
        return len(self.nodes) // len(self.cards)


def read_cells(file: BulkFile, grids: GridPoints) -> list[ElementCells]:
    """All elements of a file, alike ones together.

    Raises
    ------
    ImportFormatError   none at all; ids given twice; grids or properties that are missing or of another kind;
                        options that our elements do not have
    """
    cards = file.named(*_ELEMENTS)
    if not cards:
        raise ImportFormatError(
            f"{file.path}: no element ({', '.join(_ELEMENTS)}); is this a mesh file, and whole?"
        )
    ids = np.array([card.integer(0, "the element id") for card in cards], dtype=np.int64)
    second = first_repeated(ids)
    if second is not None:
        raise cards[second].error(f"element {ids[second]} is defined a second time; renumber or remove it")
    properties = _properties_by_id(file)
    alike: dict[tuple[str, int], list[BulkCard]] = {}
    for card in cards:
        alike.setdefault((card.name, _grid_count(card)), []).append(card)
    return [_cells(name, count, members, grids, properties) for (name, count), members in alike.items()]


def _grid_count(card: BulkCard) -> int:
    element = _ELEMENTS[card.name]
    for place, what in element.forbidden:
        if card.word(place) and card.real(place, what) != 0:
            raise card.error(f"{what} is not read; write the element without it")
    fixed = _GRID_COUNT.get(card.name)
    if fixed is not None:
        return fixed
    count = sum(1 for word in card.fields[2:] if word)
    allowed = sorted(element.kinds)
    if count not in allowed:
        raise card.error(
            f"element {card.word(0)} names {count} grids; it takes {' or '.join(map(str, allowed))} "
            "(is a continuation missing?)"
        )
    return count


def _cells(
    name: str, count: int, cards: list[BulkCard], grids: GridPoints, properties: dict[int, BulkCard]
) -> ElementCells:
    element = _ELEMENTS[name]
    ids = np.array([[card.integer(2 + i, f"grid G{i + 1}") for i in range(count)] for card in cards])
    nodes, known = grids.lookup(ids)
    if not known.all():
        row, corner = np.argwhere(~known)[0]
        raise cards[row].error(
            f"element {cards[row].word(0)} names grid {ids[row, corner]}, which the file does not define; "
            "add its GRID card, or remove the element"
        )
    set_names, sections = _sections(cards, properties, grids, nodes)
    if count in element.order:
        nodes = nodes[:, element.order[count]]
    if name == "CQUAD4":
        crossed = crossed_quadrilaterals(grids.positions, nodes)
        if crossed.size:
            raise cards[crossed[0]].error(f"element {cards[crossed[0]].word(0)}: {CROSSED}")
        nodes = split_quadrilaterals(grids.positions, nodes)
    return ElementCells(element.kinds[count], nodes, tuple(cards), set_names, sections)


def _sections(
    cards: list[BulkCard], properties: dict[int, BulkCard], grids: GridPoints, nodes: IntArray
) -> tuple[tuple[str, ...], dict[str, MadeOf]]:
    """Cell set of each element: one a property, and of beams one a direction of their sections."""
    names: dict[tuple[int, Orientation | None], str] = {}
    sections: dict[str, MadeOf] = {}
    of_cards = []
    for card, ends in zip(cards, nodes, strict=True):
        number = card.integer(1, "the property id", card.integer(0, "the element id"))
        found, wanted = properties.get(number), _PROPERTIES[card.name]
        if found is None or found.name not in wanted:
            other = "which the file does not define" if found is None else f"which is a {found.name}"
            raise card.error(
                f"element {card.word(0)} names property {number}, {other}; "
                f"add {' or '.join(wanted)} {number}, or correct the id"
            )
        orientation = beam_orientation(card, grids, ends) if card.name in ("CBAR", "CBEAM") else None
        if (number, orientation) not in names:
            same = sum(known == number for known, _ in names)
            name = f"{found.name.lower()}_{number}" + (f"_{same + 1}" if same else "")
            names[number, orientation] = name
            sections[name] = MadeOf(found, orientation)
        of_cards.append(names[number, orientation])
    return tuple(of_cards), sections


def _properties_by_id(file: BulkFile) -> dict[int, BulkCard]:
    found: dict[int, BulkCard] = {}
    for card in file.named(*PROPERTY_CARDS):
        number = card.integer(0, "the property id")
        if number in found:
            raise card.error(f"property {number} is defined a second time; renumber or remove it")
        found[number] = card
    return found
