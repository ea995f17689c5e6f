"""Shared state of the reader of a Nastran deck: grids, freedoms and the record of omitted cards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.importers.deck import LeftOut, NodalMatrix
from supple.importers.freedom_sums import FreedomSums, Terms, motion_along
from supple.importers.nastran.bulk_data import BulkCard, BulkFile
from supple.importers.nastran.case_control import CaseControl
from supple.importers.nastran.grids import CoordinateSystem, GridPoints
from supple.importers.numbering import positions_of_ids
from supple.importers.plain_number import is_plain_digits

# Provisional number of the first scalar point; `final_freedoms` replaces it by the number of nodes.
_SCALARS = 2**40


def final_freedoms(given: IntArray, n_nodes: int) -> IntArray:
    """Freedoms in final numbers: `n_nodes`, the number of all nodes, is that of the first scalar point."""
    return np.where(given >= 6 * _SCALARS, given - 6 * (_SCALARS - n_nodes), given)


@dataclass(eq=False)
class DeckReading:
    """A deck under construction, with the data that all parts of the reader use.

    whole : the main file, with the sections of all superelements
    scalar_points : (S,) ids of points with one freedom
    mass_factor, stiffness_factor, damping_factor : factors by PARAM
    matrix_factors : {"K2GG": factor on the matrices that K2GG adds, ..}, without WTMASS
    added_nodes : positions (3,) of nodes that the reader adds on arcs and edges
    springs, dashpots, inertias, constraints, held, masses, notes : as in `Deck`
    lumped_mass : Nastran's default; PARAM,COUPMASS above 0 selects the consistent mass
    """

    file: BulkFile
    whole: BulkFile
    grids: GridPoints
    scalar_points: IntArray
    case: CaseControl
    mass_factor: float
    stiffness_factor: float
    damping_factor: float
    matrix_factors: Mapping[str, float]
    added_nodes: list[FloatArray] = field(default_factory=list)
    springs: FreedomSums = field(default_factory=FreedomSums)
    dashpots: FreedomSums = field(default_factory=FreedomSums)
    inertias: FreedomSums = field(default_factory=FreedomSums)
    constraints: FreedomSums = field(default_factory=FreedomSums)
    held: FreedomSums = field(default_factory=FreedomSums)
    masses: list[NodalMatrix] = field(default_factory=list)
    notes: dict[str, None] = field(default_factory=dict)
    lumped_mass: bool = True
    _left: list[tuple[BulkCard, str]] = field(default_factory=list)

    def leave_out(self, card: BulkCard, meaning: str) -> None:
        """Record that a card or a part of it is left out, and the consequence."""
        self._left.append((card, meaning))

    def note(self, sentence: str) -> None:
        """Record a note for the user, once."""
        self.notes[sentence] = None

    @property
    def left_out(self) -> tuple[LeftOut, ...]:
        """All omitted cards, counted by name and consequence."""
        return left_out_by_card(self._left)

    def chosen_sets(self, command: str, adder: str, cards: Sequence[BulkCard]) -> set[int]:
        """Ids of the sets of a command that case control selects, with those that `adder` (SPCADD) combines.

        Without case control: the only set of the file; none if there are several, with a record.

        cards : those of all sets of the command in the file
        """
        sets = {card.integer(0, "the set id") for card in cards}
        number = self.case.number(command)
        if number is None:
            if self.case.present or len(sets) != 1:
                if sets:
                    why = "case control chooses none" if self.case.present else "no case control chooses"
                    self.note(f"{command} sets {', '.join(map(str, sorted(sets)))} are not applied: {why}.")
                if command != "SPC" and not self.case.present:  # joints of the machine replace supports
                    for card in self.file.named(command, f"{command}1", f"{command}L", f"{command}L1"):
                        self.leave_out(card, "left out: the file has no case control that selects a set")
                return set()
            return sets
        if command in self.case.varied:
            self.note(f"Subcases differ in their {command} set; {number}, the first one, is read.")
        joined = {number}
        for card in self.file.named(adder):
            if card.integer(0, "the set id") == number:
                joined |= {card.integer(i, "a set") for i in range(1, len(card.fields)) if card.word(i)}
        return joined

    def has_local_axes(self, node: int, components: str) -> bool:
        """Whether some, not all, translations or rotations are listed, and axes CD are not the basic axes."""
        parts = ({"1", "2", "3"} & set(components), {"4", "5", "6"} & set(components))
        return any(len(part) in (1, 2) for part in parts) and not np.array_equal(
            self.grids.axes[node], np.eye(3)
        )

    def system(self, card: BulkCard, number: int) -> CoordinateSystem:
        """The coordinate system of a card; ImportFormatError if missing."""
        if number not in self.grids.systems:
            raise card.error(f"names coordinate system {number}, which the file does not define; add it")
        return self.grids.systems[number]

    def node(self, card: BulkCard, place: int, what: str) -> int:
        """Number from 0 of the grid in a field; ImportFormatError for a missing grid."""
        return int(self.grids.numbers(card, [card.integer(place, what)])[0])

    def vector(self, card: BulkCard, node: int, start: FloatArray, *, basic: bool = False) -> FloatArray:
        """The vector X1 X2 X3 of an element in axes CD of a node, or basic ones; to G0 from `start`."""
        if is_plain_digits(card.word(4)) and card.is_blank(5, 7):
            return self.grids.positions[self.node(card, 4, "the grid G0")] - start
        given = np.array([card.real(4 + i, f"X{i + 1}", 0.0) for i in range(3)])
        return given if basic else self.grids.axes[node] @ given

    def positions(self, nodes: IntArray) -> FloatArray:
        """Positions (.., 3) of nodes, also of added nodes."""
        if not self.added_nodes or nodes.max(initial=0) < len(self.grids.ids):
            return self.grids.positions[nodes]
        return np.concatenate([self.grids.positions, np.array(self.added_nodes)])[nodes]

    def add_node(self, position: FloatArray) -> int:
        """Add a node at a position; returns its number."""
        self.added_nodes.append(position)
        return len(self.grids.ids) + len(self.added_nodes) - 1

    def is_scalar(self, number: int) -> bool:
        """Whether an id is that of a scalar point."""
        return bool(positions_of_ids(self.scalar_points, np.array([number]))[1][0])

    def freedom(self, card: BulkCard, point: int, component: int) -> Terms:
        """Terms of a displacement component (1 to 6, in the axes CD of a grid) in basic freedoms.

        A scalar point is one freedom, whatever the component. ImportFormatError for a missing point, or a
        component of a grid that is not 1 to 6.
        """
        number, known = positions_of_ids(self.scalar_points, np.array([point]))
        if known[0]:
            return [(6 * (_SCALARS + int(number[0])), 1.0)]
        (node,) = self.grids.numbers(card, [point]).tolist()
        if not 1 <= component <= 6:
            raise card.error(f"component {component} of grid {point}; give 1 to 6")
        return self.node_freedom(node, component - 1)

    def node_freedom(self, node: int, component: int) -> Terms:
        """Terms of component 0 to 5, in the axes CD, of a grid given by its number."""
        return motion_along(node, self.grids.axes[node][:, component % 3], rotation=component > 2)


def left_out_by_card(given: Sequence[tuple[BulkCard, str]]) -> tuple[LeftOut, ...]:
    """Omitted cards with their consequence, counted by name and consequence."""
    lines: dict[tuple[str, str], list[int]] = {}
    for card, meaning in given:
        lines.setdefault((card.name, meaning), []).append(card.line)
    return tuple(LeftOut(name, len(own), min(own), meaning) for (name, meaning), own in lines.items())


def times(terms: Terms, factor: float) -> Terms:
    """Terms multiplied by a factor."""
    return [(freedom, factor * value) for freedom, value in terms]
