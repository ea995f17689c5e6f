"""Beams and rods of a Nastran deck as lines: CBAR, CBEAM, CBEND, CROD, CONROD, CTUBE."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import atan2, ceil, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from supple.arrays import BoolArray, FloatArray
from supple.importers.deck import BeamProperty, DeckElements, Property
from supple.importers.nastran.bulk_data import BulkCard, BulkFile
from supple.importers.nastran.cells import Properties, grids_named
from supple.importers.nastran.deck_reading import DeckReading
from supple.importers.nastran.line_properties import (
    BEAM_PROPERTY_CARDS,
    ROD_PROPERTY_CARDS,
    has_warping,
    read_beam,
    read_rod,
    rod,
)
from supple.importers.nastran.materials import Materials
from supple.mesh import CellType

BEAM_CARDS = ("CBAR", "CBEAM", "CBEND")
ROD_CARDS = ("CROD", "CTUBE", "CONROD")

# Cards with defaults for blank fields of property, orientation and OFFT.
_DEFAULTS = {"CBAR": "BAROR", "CBEAM": "BEAMOR"}

PIECES_OF_A_RIGHT_ANGLE = 16
"""Number of straight pieces for 90 degrees of a curved beam; the error falls with its square."""


class _Line(NamedTuple):
    """A cell of a card between two nodes; direction, offsets and released freedoms as in `DeckElements`."""

    card: BulkCard
    ends: list[int]
    direction: FloatArray | None = None
    offsets: FloatArray = np.zeros((2, 3))
    released: BoolArray = np.zeros(12, dtype=bool)


_Groups = dict[tuple[str, str], list[_Line]]
"""Cells by card name and property."""


def _elements(groups: _Groups) -> list[DeckElements]:
    """The cells of each group; offsets and released freedoms are None if all are zero."""
    found = []
    for (name, of), lines in groups.items():
        nodes, offsets, released = (
            np.array([getattr(line, part) for line in lines]) for part in ("ends", "offsets", "released")
        )
        ids, places = (
            np.array(each) for each in zip(*((int(c.fields[0]), c.line) for c, *_ in lines), strict=True)
        )
        directions = [line.direction for line in lines if line.direction is not None]
        found.append(
            DeckElements(
                *(name, CellType.LINE2, nodes, ids, places, of),
                np.array(directions) if directions else None,
                offsets if offsets.any() else None,
                released if released.any() else None,
            )
        )
    return found


def read_rods(
    reading: DeckReading, materials: Materials, added: Mapping[int, float]
) -> tuple[list[DeckElements], dict[str, Property]]:
    """Cells and properties of CROD with PROD, CTUBE with PTUBE, and CONROD, which has its own values."""
    properties = Properties(reading, *ROD_PROPERTY_CARDS)
    own = Properties(reading)
    groups: _Groups = {}
    for card in reading.file.named(*ROD_CARDS):
        nsm = added.get(card.integer(0, "the element id"), 0.0)
        if card.name == "CONROD":
            number, total = card.integer(3, "the material id"), card.real(7, "NSM", 0.0) + nsm
            area, J, arm = card.reals(4, "A", "J", "C")
            material = materials.isotropic(number)
            made = material if isinstance(material, str) else rod(material, area, J, arm, total, reading)
            own.cards = {number: card}
            of = own.name(card, number, (area, J, arm, total), lambda _, made=made: made)
            ends = grids_named([card], reading, 1, 2)[0].tolist()
        else:
            number = card.property_id()
            of = properties.name(card, number, nsm, lambda c, n=nsm: read_rod(c, materials, reading, n))
            ends = grids_named([card], reading, 2, 2)[0].tolist()
        if of:
            groups.setdefault((card.name, of), []).append(_Line(card, ends))
    return _elements(groups), properties.found | own.found


def read_beams(
    reading: DeckReading, materials: Materials, added: Mapping[int, float]
) -> tuple[list[DeckElements], dict[str, Property]]:
    """Cells and properties of CBAR and CBEAM, and of CBEND as straight pieces of an arc."""
    properties = Properties(reading, *BEAM_PROPERTY_CARDS)
    groups: _Groups = {}
    for card in reading.file.named(*BEAM_CARDS):
        number, nsm = card.property_id(), added.get(card.integer(0, "the element id"), 0.0)
        ends = grids_named([card], reading, 2, 2)[0].tolist()
        if card.name == "CBEND":
            _curved(card, ends, number, nsm, properties, groups, materials, reading)
            continue
        of = properties.name(card, number, nsm, lambda c, n=nsm: read_beam(c, materials, reading, n))
        if not of:
            continue
        if not card.is_blank(16, 18) and has_warping(properties.cards[number]):
            reading.leave_out(card, "its warping (SA, SB, CW) is not read: the beam is too soft in torsion")
        direction, offsets = _orientation(card, ends, reading)
        released = np.zeros(12, dtype=bool)
        for end, place in enumerate((8, 9)):
            pins = card.word(place)
            if not set(pins) <= set("0123456"):
                raise card.error(f"a pin flag is '{pins}'; it lists some of 123456")
            released[[6 * end + int(pin) - 1 for pin in pins if pin != "0"]] = True
        line = _Line(card, ends, direction, offsets, released)
        groups.setdefault((card.name, of), []).append(line)
    return _elements(groups), properties.found


def beams_filled(file: BulkFile) -> BulkFile:
    """The file with the blank fields of its beams filled from BAROR and BEAMOR."""
    defaults = {name: next(iter(file.named(of)), None) for name, of in _DEFAULTS.items()}
    if not any(defaults.values()):
        return file
    return replace(file, cards=tuple(_filled(card, defaults.get(card.name)) for card in file.cards))


def _filled(card: BulkCard, default: BulkCard | None) -> BulkCard:
    """A card with its blank fields filled from BAROR or BEAMOR, if there is one for it."""
    if default is None:
        return card
    fields = list(card.fields) + [""] * (8 - len(card.fields))
    if not fields[1]:
        fields[1] = default.word(1)
    if not any(fields[4:7]):
        fields[4:7] = [default.word(place) for place in (4, 5, 6)]
    if not fields[7]:
        fields[7] = default.word(7)
    return card._replace(fields=tuple(fields))


def _orientation(card: BulkCard, ends: list[int], reading: DeckReading) -> tuple[FloatArray, FloatArray]:
    """A unit vector in plane 1 and the offsets (2, 3) of the ends, in basic axes.

    The flag OFFT has three letters. For the vector, G selects the axes CD of end A, B the basic axes. For the
    offset of an end, G selects the axes CD of its grid, O or E the element axes with x from GA to GB.
    """
    flag = card.word(7)
    if len(flag) != 3 or not set(flag) <= set("GBOE"):
        flag = "GGG"  # blank, or the number BIT of p-elements
    start, end = reading.grids.positions[ends]
    vector = _vector(card, ends[0], start, reading, basic=flag[0] == "B")
    offsets = np.array([card.reals(10, "W1A", "W2A", "W3A"), card.reals(13, "W1B", "W2B", "W3B")])
    chord = end - start
    for i, letter in enumerate(flag[1:]):
        if not offsets[i].any():
            continue
        axes = reading.grids.axes[ends[i]] if letter in "GB" else _element_axes(card, chord, vector)
        offsets[i] = axes @ offsets[i]
    _element_axes(card, end + offsets[1] - start - offsets[0], vector)
    return vector, offsets


def _vector(card: BulkCard, node: int, start: FloatArray, reading: DeckReading, *, basic: bool) -> FloatArray:
    """Unit vector from `start` to grid G0, or along (X1, X2, X3) in axes CD of `node`, or basic ones."""
    vector = reading.vector(card, node, start, basic=basic)
    length = np.linalg.norm(vector)
    if not length > 0:
        raise card.error("its orientation (X1 X2 X3, or G0) is missing; give a vector across the beam")
    return vector / length


def _element_axes(card: BulkCard, chord: FloatArray, vector: FloatArray) -> FloatArray:
    """Axes (3, 3) of a beam as columns: x along the beam, y in plane 1."""
    z = np.cross(chord, vector)
    if not np.linalg.norm(z) > 1e-6 * np.linalg.norm(chord):
        raise card.error(
            "its orientation (X1 X2 X3, or G0) lies along the beam, or the beam has no length; give one "
            "across it"
        )
    x, z = chord / np.linalg.norm(chord), z / np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _curved(
    card: BulkCard,
    ends: list[int],
    number: int,
    nsm: float,
    properties: Properties,
    groups: _Groups,
    materials: Materials,
    reading: DeckReading,
) -> None:
    """Add a curved beam as straight pieces between nodes on its arc; the pieces have the mass of the arc."""
    start, end = reading.grids.positions[ends]
    known = properties.cards.get(number)
    arc = None if known is None else _arc(card, known, start, end, ends[0], reading)
    if arc is None or not np.isfinite(arc).all():
        reading.leave_out(
            card,
            "elements left out: their arc (GEOM, RB, THETAB) or property is not defined, or the arc is over "
            "180 degrees",
        )
        return
    centre, tangent = arc
    a, b = start - centre, end - centre
    radius = float(np.linalg.norm(a))
    angle = atan2(float(np.linalg.norm(np.cross(a, b))), float(a @ b))
    pieces = max(2, ceil(PIECES_OF_A_RIGHT_ANGLE * angle / (pi / 2)))
    longer = (angle / pieces / 2) / sin(angle / pieces / 2)

    def make(property_card: BulkCard) -> BeamProperty | str:
        made = read_beam(property_card, materials, reading, nsm)
        if isinstance(made, str):
            return made
        return replace(made, first=replace(made.first, mass_per_length=made.first.mass_per_length * longer))

    of = properties.name(card, number, (nsm, round(longer, 12)), make)
    if not of:
        return
    angles = angle * np.arange(pieces + 1) / pieces
    arms = np.cos(angles)[:, None] * a + np.sin(angles)[:, None] * radius * tangent
    nodes = [ends[0], *(reading.add_node(centre + arm) for arm in arms[1:-1]), ends[1]]
    middles = (arms[1:] + arms[:-1]) / (2 * radius)
    lines = [_Line(card, nodes[i : i + 2], middles[i]) for i in range(pieces)]
    groups.setdefault((card.name, of), []).extend(lines)
    reading.note(
        f"Curved beams (CBEND) are {PIECES_OF_A_RIGHT_ANGLE} straight pieces a right angle, between nodes on "
        "their arc."
    )


def _arc(
    card: BulkCard, known: BulkCard, start: FloatArray, end: FloatArray, node: int, reading: DeckReading
) -> tuple[FloatArray, FloatArray] | None:
    """Centre and unit tangent at GA of the arc of a CBEND; None if its data define no arc up to 180 degrees.

    GEOM 1: the centre lies on the line of the vector through GA;  2: the vector is the tangent at GA;
    3: radius RB;  4: angle THETAB. For 3 and 4, centre and vector are on opposite sides of the chord.
    """
    geometry = card.integer(7, "GEOM", 1)
    vector, chord = _vector(card, node, start, reading, basic=False), end - start
    length = float(np.linalg.norm(chord))
    least, along = 1e-9 * length, float(vector @ chord)
    if not length > 0:
        return None
    if geometry in (1, 2):
        across = chord - along * vector
        size = float(np.linalg.norm(across))
        if size <= least or (abs(along) <= least if geometry == 1 else along < -least):
            return None
        if geometry == 1:
            return start + vector * (chord @ chord) / (2 * along), across / size
        return start + across * (chord @ chord) / (2 * size * size), vector
    side = vector - along / length * (chord / length)
    size = float(np.linalg.norm(side))
    radius = known.real(6, "RB", 0.0)
    if geometry == 4:
        angle = np.radians(known.real(7, "THETAB", 0.0))
        radius = length / 2 / sin(angle / 2) if 0 < angle <= pi else 0.0
    if size <= 1e-9 or radius < length / 2 - least:
        return None
    depth = sqrt(max(radius * radius - length * length / 4, 0.0))
    tangent = depth * chord / length + length / 2 * side / size
    return start + chord / 2 - side / size * depth, tangent / np.linalg.norm(tangent)
