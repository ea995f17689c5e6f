"""Nastran bulk data (.bdf, .dat, .nas, .blk, .pch) as a Deck."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np

from supple.arrays import BoolArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.deck import (
    Deck,
    DeckElements,
    LeftOut,
    NodalMatrix,
    ScalarTerms,
)
from supple.importers.nastran.bulk_data import BulkCard, BulkFile, read_bulk_data
from supple.importers.nastran.case_control import read_case_control
from supple.importers.nastran.cells import (
    SHELL_CARDS,
    SOLID_CARDS,
    SOLID_PROPERTY_CARDS,
    read_shells,
    read_solids,
)
from supple.importers.nastran.deck_reading import DeckReading, final_freedoms, left_out_by_card
from supple.importers.nastran.grids import COORDINATE_CARDS, read_grids
from supple.importers.nastran.line_properties import BEAM_PROPERTY_CARDS, ROD_PROPERTY_CARDS
from supple.importers.nastran.lines import BEAM_CARDS, ROD_CARDS, beams_filled, read_beams, read_rods
from supple.importers.nastran.materials import MATERIAL_CARDS, Materials
from supple.importers.nastran.nonstructural_mass import NSM_CARDS, read_added_mass
from supple.importers.nastran.partition import PARTITION_CARDS, partitioned
from supple.importers.nastran.point_elements import (
    POINT_CARDS,
    POINT_PROPERTY_CARDS,
    read_point_elements,
)
from supple.importers.nastran.rigid import RIGID_CARDS, read_multipoint_constraints, read_ties, turned_by_ties
from supple.importers.nastran.superelements import SUPERELEMENT_CARDS, assembled, repeated_parts
from supple.importers.nastran.supports import SUPPORT_CARDS, read_matrices, read_supports
from supple.importers.nastran.walls import WALL_CARDS
from supple.importers.nastran.without_effect import has_no_effect
from supple.importers.plain_number import is_plain_digits

_READ = frozenset(
    (
        *("GRID", "GRDSET", "SPOINT", "EPOINT", "PARAM", "BAROR", "BEAMOR"),
        *(*COORDINATE_CARDS, *SOLID_CARDS, *SOLID_PROPERTY_CARDS, *SHELL_CARDS, *WALL_CARDS),
        *(*BEAM_CARDS, *ROD_CARDS, *BEAM_PROPERTY_CARDS, *ROD_PROPERTY_CARDS, *MATERIAL_CARDS),
        *(*POINT_CARDS, *POINT_PROPERTY_CARDS, *NSM_CARDS, *RIGID_CARDS, *SUPPORT_CARDS),
        *(*SUPERELEMENT_CARDS, *PARTITION_CARDS),
    )
)
_CELLS = (*SOLID_CARDS, *SHELL_CARDS, *BEAM_CARDS, *ROD_CARDS)


def _by_card(meanings: Mapping[str, str]) -> dict[str, str]:
    return {name: meaning for meaning, names in meanings.items() for name in names.split()}


# Cards that are not read, by their description or the effect of their omission.
CELLS_NOT_READ = _by_card({
    "curved beams of three grids": "CBEAM3",
    "axisymmetric solids": "CTRIAX CTRIAX6 CQUADX CTRAX3 CTRAX6 CQUADX4 CQUADX8",
    "axisymmetric shells": "CCONEAX",
    "elements at the tip of a crack": "CRAC2D CRAC3D",
    "a superelement from a file or an image of another": "CSUPER",
})  # fmt: skip
CONNECTIONS_NOT_READ = _by_card({
    "gaps that open and close: the parts they join are not connected": "CGAP",
    "fasteners between shells: the parts they join are not connected": "CFAST",
    "spot welds: the parts they join are not connected": "CWELD",
    "seam welds: the parts they join are not connected": "CSEAM",
    "glue between surfaces: the parts it joins are not connected": "BGSET",
    "glue between contact bodies (IGLUE): the parts it joins are not connected": "BCTABLE BCONPRG",
    "cyclic symmetry: one sector is read, not the whole body": "CYSYM",
    "sides of a sector of a cyclic body: its sectors are not connected": "CYJOIN",
    "grids on the axis of a cyclic body: its sectors are not connected": "CYAX",
})  # fmt: skip
_MEANINGS = CELLS_NOT_READ | CONNECTIONS_NOT_READ | _by_card({
    "properties of gaps": "PGAP",
    "properties of fasteners": "PFAST",
    "properties of spot welds": "PWELD",
    "properties of seam welds": "PSEAM",
    "a choice of glued surfaces": "BGADD",
    "an element by its matrix": "GENEL",
    "an interpolation between grids": "RSPLINE",
    "a connection of shell and solid": "RSSCON",
    "a section by its outline: its beams are left out, too": "PBRSECT PBMSECT",
    "a section of several materials: its beams are left out, too": "PBCOMP",
    "solids of large strain: their elements are left out, too": "PLSOLID",
    "an axisymmetric material": "MAT3",
    "a rubber": "MATHE MATHP",
    "stress that is not proportional to strain: the material stays elastic": "MATS1",
    "values of springs that depend on frequency or are not linear: those of PELAS are read": "PELAST",
    "values of dampers that depend on frequency: those of PDAMP are read": "PDAMPT",
    "values of bushings that depend on frequency or are not linear: those of PBUSH are read": "PBUSHT",
    "curved edges: elements stay straight": "FEEDGE",
    "curved faces: elements stay flat": "FEFACE",
    "curves of geometry: elements stay straight": "GMCURV",
    "surfaces of geometry: elements stay flat": "GMSURF",
    "supports of geometry": "GMBC GMSPC",
    "freedoms in which a superelement is not joined to the others": "RELEASE",
    "constraints of an axisymmetric model": "MPCAX",
    "a rotating part": "ROTORD",
})  # fmt: skip
_PROPERTIES = frozenset(
    (
        *("PGAP", "PFAST", "PWELD", "PSEAM", "PBRSECT", "PBMSECT", "PBCOMP", "PLSOLID", "PLPLANE", "PPLANE"),
        *("PBEAM3", "PELAST", "PDAMPT", "PBUSHT", "PFASTT", "PRAC2D", "PRAC3D", "PCONEAX", "PDUM8", "PDUM9"),
    )
)


def read_nastran_deck(path: str | Path) -> Deck:
    """The body described by a Nastran file.

    Cards without effect on a body are counted and ignored. Cards that would change the body but are not read
    are listed in `left_out`, and so are missing included files. A file without grids, or one that is not
    readable without its missing included files, gives a deck without nodes, and the error as a note.
    Superelements, by BEGIN SUPER or SESET, are assembled into one deck at their common grids; each
    superelement is also a deck in `superelements`.

    Raises
    ------
    ImportFormatError   missing or binary file; circular inclusions; no supported card. Unless grids or an
                        included file are missing: an element on an undefined grid; ids with two definitions;
                        fields that are not numbers
    """
    absences: list[BulkCard] = []
    return deck_of_cards(read_bulk_data(path, absences), absences)


def deck_of_cards(file: BulkFile, absences: Sequence[BulkCard]) -> Deck:
    """The deck of `read_nastran_deck` from the cards of a file; absences : its missing included files."""
    try:
        reading = start_reading(file, file)
        deck = _deck(reading)
    except ImportFormatError as error:
        if file.named("GRID") and not any(len(each.fields) == 1 for each in absences):
            raise
        return _with_absences(_deck_without_grids(file, error), absences)
    deck = _with_absences(deck, absences)
    if not file.parts:
        return partitioned(deck, reading)
    parts: dict[int, Deck] = {}
    absent: list[LeftOut] = []
    repeated = repeated_parts(file)
    for (kind, name), part in file.parts.items():
        number = int(name) if kind == "SUPER" and name.isdecimal() else None
        if number is not None and part.named("GRID"):
            parts[number] = _deck(start_reading(part, file))
        elif number not in repeated:
            line = part.cards[0].line if part.cards else 0
            what = "a separate mass case" if kind == "MASSID" else "a part without grids"
            absent.append(LeftOut(f"BEGIN {kind}", 1, line, f"{what}: {name}"))
    deck = replace(deck, left_out=(*deck.left_out, *absent))
    return assembled(deck, parts, file, reading.grids) if parts else deck


def has_no_sections(names: Iterable[str]) -> bool:
    """Whether cards of these names describe only a mesh, without properties and materials."""
    properties = (*SOLID_PROPERTY_CARDS, *WALL_CARDS, *BEAM_PROPERTY_CARDS, *ROD_PROPERTY_CARDS, *_PROPERTIES)
    return not any(name in properties or name.startswith("MAT") for name in names)


def with_sections(file: BulkFile) -> BulkFile:
    """The file of a mesh, with a property for each number that its elements name, and one material.

    Elements without a number get one together. Beams become rods, which need no orientation.
    """
    kinds = {"PSOLID": SOLID_CARDS, "PSHELL": SHELL_CARDS, "PROD": (*BEAM_CARDS, *ROD_CARDS)}
    of_element = {name: kind for kind, names in kinds.items() for name in names if name != "CONROD"}
    named = {card.word(1) for card in file.named(*of_element)}
    unnumbered = str(max((int(word) for word in named if is_plain_digits(word)), default=0) + 1)
    cards = list(file.cards)
    used: dict[tuple[str, str], BulkCard] = {}
    for place, card in enumerate(file.cards):
        kind = of_element.get(card.name)
        if kind is not None:
            number = card.word(1) or unnumbered
            fields = (card.word(0), number, *card.fields[2 : 4 if kind == "PROD" else None])
            cards[place] = card._replace(name="CROD" if kind == "PROD" else card.name, fields=fields)
            used.setdefault((kind, number), card)
    for (kind, number), card in used.items():
        size = () if kind == "PSOLID" else ("1.",)
        cards.append(card._replace(name=kind, fields=(number, "1", *size)))
        cards.append(card._replace(name="MAT1", fields=("1", "1.", "", "0.")))
    return replace(file, cards=tuple(cards))


CARDS_NOT_READ = "its cards are not read"
# Consequence of a missing included file: of the cards, of case control.
_UNREAD = {"": CARDS_NOT_READ, "CASE": "the sets that case control selects in it are not known"}


def _with_absences(deck: Deck, absences: Sequence[BulkCard]) -> Deck:
    """The deck, with missing included files added to `left_out`."""
    gone = (
        LeftOut("INCLUDE", 1, card.line, f"there is no file {card.fields[0]}: {_UNREAD[card.word(1)]}")
        for card in absences
    )
    return replace(deck, left_out=(*gone, *deck.left_out))


def _deck_without_grids(file: BulkFile, error: ImportFormatError) -> Deck:
    """A deck without nodes, with counts of cards and the note `error`.

    Raises `error` if no card is supported.
    """
    read, passed_over = _counted(file)
    if not read and not passed_over:
        raise error
    left = [*_not_read(file)]
    on_grids = (*_CELLS, *POINT_CARDS, *(name for name in RIGID_CARDS if name != "MPCADD"), "DMIG")
    left += [(card, "left out: its grids are missing") for card in file.named(*on_grids)]
    nowhere = np.empty(0, dtype=np.int64), np.empty((0, 3))
    return Deck(
        *(file.path, *nowhere, (), {}),
        read=read,
        passed_over=passed_over,
        left_out=left_out_by_card(left),
        notes=(str(error),),
    )


def _not_read(file: BulkFile) -> Iterator[tuple[BulkCard, str]]:
    """Cards that are not read, each with its meaning, without property cards that no element uses."""
    unread = {n: own for n, own in file.by_name.items() if n not in _READ and not has_no_effect(n)}
    unread |= {n: glue for n in _GLUE if (glue := [card for card in file.named(n) if _is_glue(card)])}
    used = _used_properties(file) if _PROPERTIES.intersection(unread) else set()
    for name, cards in unread.items():
        for card in cards:
            if name not in _PROPERTIES or card.word(0) in used:
                yield card, _MEANINGS.get(name, "a card that is not supported")


_GLUE = ("BCTABLE", "BCONPRG")


def _is_glue(card: BulkCard) -> bool:
    """Whether a contact card glues: IGLUE of a SLAVE row of BCTABLE, or after its name on a BCONPRG."""
    row, step = ("SLAVE", 6) if card.name == "BCTABLE" else ("IGLUE", 1)
    places = [i for i in range(len(card.fields)) if card.word(i) == row]
    return any(card.word(i + step) not in ("", "0") for i in places)


def _used_properties(file: BulkFile) -> set[str]:
    """Ids of properties in use; a blank property field stands for the id of the element."""
    elements = (n for n in file.by_name if n.startswith("C") and not n.startswith("CORD"))
    return {card.word(1) or card.word(0) for card in file.named(*elements)}


def _deck(reading: DeckReading) -> Deck:
    materials, nonstructural = Materials(reading), read_added_mass(reading)
    elements: list[DeckElements] = []
    properties = {}
    for cells, found in (
        read_solids(reading, materials),
        read_shells(reading, materials, nonstructural),
        read_beams(reading, materials, nonstructural),
        read_rods(reading, materials, nonstructural),
    ):
        elements += cells
        properties |= found
    read_point_elements(reading, materials)
    matrices = read_matrices(reading)
    read_multipoint_constraints(reading)
    turning = _with_rotations(reading, elements, [*chain(*matrices.values())])
    rigid, means = read_ties(reading, turning)
    node_sets = read_supports(reading, {n for tie in rigid for n in tie.nodes.tolist() if not turning[n]})
    read, passed_over = _counted(reading.file)
    nodes, ids = reading.grids.positions, reading.grids.ids
    if reading.added_nodes:
        nodes = np.concatenate([nodes, np.array(reading.added_nodes)])
        last = int(max(ids.max(), reading.scalar_points.max(initial=0)))
        ids = np.concatenate([ids, last + 1 + np.arange(len(reading.added_nodes))])

    def matrix(given: NodalMatrix) -> NodalMatrix:
        return replace(given, freedoms=final_freedoms(given.freedoms, len(ids)))

    def terms(given: ScalarTerms) -> ScalarTerms:
        freedoms, dependent = (final_freedoms(v, len(ids)) for v in (given.freedoms, given.dependent))
        return replace(given, freedoms=freedoms, dependent=dependent)

    deck = Deck(
        reading.file.path,
        ids,
        nodes,
        tuple(elements),
        properties,
        node_sets | {tie.name: tie.nodes for tie in (*rigid, *means)},
        _element_sets(elements),
        masses=(*reading.masses, *matrices["M2GG"]),
        stiffnesses=tuple(matrices["K2GG"]),
        dampings=tuple(matrices["B2GG"]),
        springs=reading.springs.terms(),
        dashpots=reading.dashpots.terms(),
        inertias=reading.inertias.terms(),
        constraints=reading.constraints.terms(constraints=True),
        held=reading.held.terms(constraints=True),
        rigid=tuple(rigid),
        means=tuple(means),
        read=read,
        passed_over=passed_over,
        left_out=reading.left_out,
        notes=tuple(reading.notes),
        scalar_points=reading.scalar_points,
        lumped_mass=reading.lumped_mass,
    )
    return deck.with_actions(matrix, terms)


def _with_rotations(
    reading: DeckReading, elements: list[DeckElements], matrices: list[NodalMatrix]
) -> BoolArray:
    """Mask (N,) of the grids whose rotations have an effect.

    Rotations act in elements, springs, dashpots, masses, matrices, constraints or ties.
    """
    nodes = [each.nodes.ravel() for each in elements if each.kind.dimension < 3]
    collected = (reading.springs, reading.dashpots, reading.inertias, reading.constraints)
    freedoms = [np.array(rows.freedoms, dtype=np.int64) for rows in collected]
    for own in (*freedoms, *(each.freedoms for each in (*reading.masses, *matrices))):
        nodes.append(own[own % 6 > 2] // 6)
    acted = np.concatenate(nodes)
    found = turned_by_ties(reading)
    found[acted[acted < len(found)]] = True
    return found


def start_reading(file: BulkFile, whole: BulkFile) -> DeckReading:
    """The reading of a file with its grids, parameters and case control; unsupported cards are left out.

    whole : the main file; its case control and PARAM cards also apply to a superelement `file`
    """
    file = beams_filled(_elements_once(file))
    parameters = _parameters([*whole.named("PARAM"), *(file.named("PARAM") if file is not whole else [])])
    reading = DeckReading(
        file,
        whole,
        read_grids(file),
        _scalar_points(file),
        read_case_control(whole.above),
        parameters.get("WTMASS", 1.0) * parameters.get("CM1", 1.0),
        parameters.get("CK1", 1.0),
        parameters.get("CB1", 1.0),
        {f"{kind}2GG": parameters.get(f"C{kind}2", 1.0) for kind in "KMB"},
    )
    reading.lumped_mass = not any(
        card.word(0) == "COUPMASS" and card.integer(1, "COUPMASS", -1) > 0
        for card in [*whole.named("PARAM"), *file.named("PARAM")]
    )
    if not whole.ended:
        reading.note("No ENDDATA ends the file; check that it is complete.")
    for card, meaning in _not_read(file):
        reading.leave_out(card, meaning)
    return reading


def _elements_once(file: BulkFile) -> BulkFile:
    """The file without repeated elements; ImportFormatError if elements with the same id differ."""
    again: set[int] = set()
    for names in (_CELLS, *((name,) for name in POINT_CARDS)):
        found: dict[str, BulkCard] = {}
        for card in file.named(*names):
            first = found.setdefault(card.fields[0], card)
            if first is card:
                continue
            if not card.same_as(first):
                raise card.error(
                    f"element {card.word(0)} is defined a second time and differs from the {first.name} of "
                    f"line {first.line}; renumber or remove it"
                )
            again.add(id(card))
    return replace(file, cards=tuple(c for c in file.cards if id(c) not in again)) if again else file


def _parameters(cards: list[BulkCard]) -> dict[str, float]:
    """Values of PARAM cards that scale a model; values of one name agree to 1 %, and the last is used.

    ImportFormatError if they differ by more, or are not positive.
    """
    found: dict[str, float] = {}
    for card in cards:
        name = card.word(0)
        if name not in ("WTMASS", *(f"C{kind}{n}" for kind in "KMB" for n in "12")):
            continue
        value = card.real(1, name, 1.0)
        if value <= 0:
            raise card.error(f"{name} is {value:g}; it must be positive")
        if abs(found.setdefault(name, value) - value) > 0.01 * value:
            raise card.error(f"{name} is {value:g}, and {found[name]:g} above; keep one of the two")
        found[name] = value
    return found


def _scalar_points(file: BulkFile) -> IntArray:
    """Ids (S,) of scalar points: of SPOINT and EPOINT, and other points that only scalar elements name."""
    ids: dict[int, None] = {}
    for card in file.named("SPOINT", "EPOINT"):
        for points in card.ranges(range(len(card.fields)), "a point"):
            if len(points) > 10**6:
                ends = f"{points[0]} THRU {points[-1]}"
                raise card.error(f"{ends} are over a million points; correct the range")
            ids |= dict.fromkeys(points)
    grids = {card.word(0) for card in file.named("GRID")}
    for card in file.named(*(f"{kind}{form}" for kind in ("CELAS", "CDAMP", "CMASS") for form in "34")):
        ids |= {card.integer(i, "a scalar point", 0): None for i in (2, 3) if card.word(i) not in grids}
    ids.pop(0, None)
    return np.array(list(ids), dtype=np.int64)


def _counted(file: BulkFile) -> tuple[dict[str, int], dict[str, int]]:
    counts = {name: len(cards) for name, cards in file.by_name.items()}
    read = {name: count for name, count in counts.items() if name in _READ}
    return read, {n: count for n, count in counts.items() if n not in _READ and has_no_effect(n)}


def _element_sets(elements: list[DeckElements]) -> dict[str, IntArray]:
    """Element ids by property card; pshell_7 contains the elements of pshell_7_2, too."""
    found: dict[str, list[IntArray]] = {}
    for cells in elements:
        name = "_".join(cells.property.split("_")[:2])
        found.setdefault(name, []).append(np.unique(cells.ids))
    return {name: np.concatenate(parts) for name, parts in found.items()}
