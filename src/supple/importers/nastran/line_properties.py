"""Beams and rods of a Nastran deck by their properties: PBAR(L), PBEAM(L), PBEND, PROD, PTUBE."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from inspect import signature
from math import nan, pi

import numpy as np

from supple.importers.deck import BeamProperty, BeamValues, IsotropicMaterial, RodProperty
from supple.importers.nastran.bulk_data import BulkCard
from supple.importers.nastran.deck_reading import DeckReading
from supple.importers.nastran.materials import Materials
from supple.importers.nastran.section_shapes import SHAPES
from supple.mesh import SectionGeometry

BEAM_PROPERTY_CARDS = ("PBAR", "PBARL", "PBEAM", "PBEAML", "PBEND")
ROD_PROPERTY_CARDS = ("PROD", "PTUBE")

# Fields of the points of stress recovery: for each point its distances along y and z.
_POINTS = ("C1", "C2", "D1", "D2", "E1", "E2", "F1", "F2")
# Largest difference between a value at a station and linear interpolation between the ends, relative to the
# larger end value, that is not reported.
_OFF_THE_LINE = 0.01

# Flags FSI of pipes, the third field of a PBEND, where other sections have their area.
_PIPES = ("1", "2", "3", "4", "5", "6")

# Number of rows of a station of a PBEAM: one for its section, and after YES one for its stress points.
_STATIONS = {"YES": 2, "YESA": 1, "NO": 1}


def read_beam(card: BulkCard, materials: Materials, reading: DeckReading, added: float) -> BeamProperty | str:
    """The property of a beam; else the reason for its absence.

    added : non-structural mass from NSM cards, kg/m, without PARAM,WTMASS
    """
    material = materials.isotropic(card.integer(1, "the material id"))
    return material if isinstance(material, str) else _BEAMS[card.name](card, material, reading, added)


def read_rod(card: BulkCard, materials: Materials, reading: DeckReading, added: float) -> RodProperty | str:
    """The property of a rod; else the reason for its absence.

    PROD: MID A J C NSM. PTUBE: MID OD T NSM OD2, a tube of outer diameter OD, tapered to OD2; a blank T
    is a solid rod. A tapered tube has its mean area, as in Nastran.

    A wall thicker than the radius is refused with a reason.
    """
    material = materials.isotropic(card.integer(1, "the material id"))
    if isinstance(material, str):
        return material
    if card.name == "PROD":
        area, J, arm, nsm = card.reals(2, "A", "J", "C", "NSM")
        return rod(material, area, J, arm, nsm + added, reading)
    outer = card.real(2, "OD")
    thickness, nsm, other = card.reals(3, "T", "NSM", "OD2")
    if not 0 <= 2 * thickness <= min(outer, other or outer):
        return f"its thickness T = {thickness:g} is not between 0 and half the outer diameter OD"
    areas, twists = [], []
    for diameter in (outer, other or outer):
        inner = diameter - 2 * thickness if thickness else 0.0
        areas.append(pi / 4 * (diameter**2 - inner**2))
        twists.append(pi / 32 * (diameter**4 - inner**4))
    arm = max(outer, other) / 2
    return rod(material, sum(areas) / 2, sum(twists) / 2, arm, nsm + added, reading)


def rod(
    material: IsotropicMaterial, area: float, J: float, arm: float, added: float, reading: DeckReading
) -> RodProperty:
    """A rod's property; its shear stress is `arm` M / J.

    added : all non-structural mass, kg/m, without PARAM,WTMASS
    """
    return RodProperty(material, area, J, material.density * area + added * reading.mass_factor, arm)


def _pbar(card: BulkCard, material: IsotropicMaterial, reading: DeckReading, added: float) -> BeamProperty:
    area, I1, I2, J, nsm = card.reals(2, "A", "I1", "I2", "J", "NSM")
    K1, K2, I12 = card.reals(16, "K1", "K2", "I12")
    mass = material.density * area + (nsm + added) * reading.mass_factor
    points = _points(card.reals(8, *_POINTS), card.fields[8:16])
    return BeamProperty(material, BeamValues(area, I1, I2, J, K1, K2, mass, I12, geometry=points))


def _points(values: Sequence[float], words: Sequence[str]) -> SectionGeometry | None:
    """Points C, D, E, F of stress recovery; None if their fields, `words`, are blank."""
    given = [any(words[i : i + 2]) for i in range(0, 8, 2)]
    points = tuple((values[2 * i], values[2 * i + 1]) for i in range(4) if given[i])
    return SectionGeometry(points) if points else None


def _pbend(
    card: BulkCard, material: IsotropicMaterial, reading: DeckReading, added: float
) -> BeamProperty | str:
    """A curved beam given by A I1 I2 J .. K1 K2 NSM, or a pipe by FSI, mean radius RM, thickness T .. NSM."""
    offsets = 19
    if card.word(2) in _PIPES:
        middle, t = card.real(3, "the mean radius RM"), card.real(4, "the thickness T")
        if card.word(2) != "1":
            reading.leave_out(
                card, "the flexibility of bent pipes (FSI above 1) is not read: the pipes are too stiff"
            )
        section = SHAPES["TUBE"](middle + t / 2, middle - t / 2) if 0 <= t <= 2 * middle else None
        if section is None:
            return f"its mean radius RM = {middle:g} and thickness T = {t:g} do not make a pipe"
        values, nsm, offsets = section.beam_values(material.density), card.real(10, "NSM", 0.0), 11
    else:
        area, I1, I2, J = card.reals(2, "A", "I1", "I2", "J")
        geometry = _points(card.reals(8, *_POINTS), card.fields[8:16])
        K1, K2, nsm = card.reals(16, "K1", "K2", "NSM")
        values = BeamValues(area, I1, I2, J, K1, K2, material.density * area, geometry=geometry)
    names = ("RC", "ZC") if offsets == 11 else ("RC", "ZC", "DELTAN")
    if any(card.reals(offsets, *names)):
        reading.leave_out(card, f"the offsets {', '.join(names)} of a curved beam are not read")
    mass = values.mass_per_length + (nsm + added) * reading.mass_factor
    return BeamProperty(material, replace(values, mass_per_length=mass))


def _pbeam(card: BulkCard, material: IsotropicMaterial, reading: DeckReading, added: float) -> BeamProperty:
    """Values A I1 I2 I12 J NSM of stations, then K1 K2 S1 S2 NSI CW M1 M2 N1 N2; linear between the ends."""
    at_a = card.reals(2, "A", "I1", "I2", "I12", "J", "NSM")
    stations, rest, points_a = _rows_of_beam(card)
    at_b, points_b, between = at_a, points_a, []
    for row, points in stations:
        place, words = _number(card, row[1], 1.0), (*row[2:8], *[""] * 6)[:6]
        # Blank values are those of A at the end, and interpolated elsewhere.
        blank = at_a if place == 1.0 else [nan] * 6
        values = [_number(card, word, default) for word, default in zip(words, blank, strict=True)]
        if place == 1.0:
            at_b, points_b = values, points if any(points) else points_a
        else:
            between.append((place, values))
    _leave_out_between(card, at_a, at_b, between, reading)
    last = [_number(card, word, 0.0) if word else None for word in (*rest, *[""] * 16)[:16]]
    K1, K2 = (1.0 if value is None else value for value in last[:2])
    if (last[2] and K1) or (last[3] and K2):
        reading.leave_out(card, "the shear relief S1, S2 of its taper is not read")

    def ends(a: int, b: int) -> tuple[float, float]:
        """Value at A and value at B; if the field of B is blank, B has the value of A."""
        first, second = last[a] or 0.0, last[b]
        return first, first if second is None else second

    nsi, m1, m2, n1, n2 = (ends(a, b) for a, b in ((4, 5), (8, 10), (9, 11), (12, 14), (13, 15)))
    first, second = (
        replace(
            _values(values, (K1, K2), nsi[i], (m1[i], m2[i]), (n1[i], n2[i]), material, reading, added),
            geometry=_points([_number(card, word, 0.0) for word in points], points),
        )
        for i, (values, points) in enumerate(((at_a, points_a), (at_b, points_b)))
    )
    return BeamProperty(material, first, None if first == second else second)


def _leave_out_between(
    card: BulkCard,
    at_a: Sequence[float],
    at_b: Sequence[float],
    between: Sequence[tuple[float, Sequence[float]]],
    reading: DeckReading,
) -> None:
    """Record the omission of stations between the ends if one deviates from linear interpolation."""
    a, b = np.array(at_a), np.array(at_b)
    for place, values in between:
        straight = a + place * (b - a)
        if (np.abs(values - straight) > _OFF_THE_LINE * np.maximum(np.abs(a), np.abs(b))).any():
            reading.leave_out(card, "sections between its ends are interpolated linearly from the ends")
            return


def _number(card: BulkCard, word: str, default: float) -> float:
    return card._replace(fields=(word,)).real(0, "a value of a station", default)


def has_warping(card: BulkCard) -> bool:
    """Whether a property is a PBEAM with a warping coefficient CW."""
    if card.name != "PBEAM":
        return False
    _, rest, _ = _rows_of_beam(card)
    return any(_number(card, word, 0.0) for word in rest[6:8])


def _values(
    given: list[float],
    K: tuple[float, float],
    nsi: float,
    nsm_at: tuple[float, float],
    neutral: tuple[float, float],
    material: IsotropicMaterial,
    reading: DeckReading,
    added: float,
) -> BeamValues:
    """Values of a station; structural mass is at the neutral axis, other mass at `nsm_at` (M1, M2)."""
    area, I1, I2, I12, J, nsm = given
    own, other = material.density * area, (nsm + added) * reading.mass_factor
    mass = own + other
    centre = tuple(
        (own * n + other * m) / mass if mass else 0.0 for n, m in zip(neutral, nsm_at, strict=True)
    )
    rotary = None
    if nsi or (other and nsm_at != neutral):
        # Second moments about y and z use distances along z and y.
        y2, z2 = (
            own * (neutral[i] - centre[i]) ** 2 + other * (nsm_at[i] - centre[i]) ** 2 for i in range(2)
        )
        Iyy, Izz = material.density * I2 + z2, material.density * I1 + y2
        rotary = (Iyy + Izz + nsi * reading.mass_factor, Iyy, Izz)
    return BeamValues(area, I1, I2, J, *K, mass, I12, neutral, (centre[0], centre[1]), rotary)


_Row = tuple[str, ...]


def _rows_of_beam(card: BulkCard) -> tuple[list[tuple[_Row, _Row]], _Row, _Row]:
    """Stations of a PBEAM (row SO, X/XB, A ..; row of stress points), the fields from K1 on, points at A."""
    rows = [(*card.fields[i : i + 8], *[""] * 8)[:8] for i in range(8, len(card.fields), 8)]
    stations: list[tuple[_Row, _Row]] = []
    place = 0 if rows and rows[0][0].upper() in _STATIONS else 1
    at_a = rows[0] if place and rows else ()
    while place < len(rows) and (kind := rows[place][0].upper()) in _STATIONS:
        points = rows[place + 1] if kind == "YES" and place + 1 < len(rows) else ()
        stations.append((rows[place], points))
        place += _STATIONS[kind]
    return stations, tuple(word for row in rows[place:] for word in row), at_a


def _shaped(
    card: BulkCard, material: IsotropicMaterial, reading: DeckReading, added: float
) -> BeamProperty | str:
    """PBARL, PBEAML: TYPE, then DIM1 .. NSM at A, and after SO, X/XB those of further stations.

    The shear centre lies on the line of the grids. In a PBARL it is at the centroid for every shape; in a
    PBEAML it is the shear centre of the shape. For an unsupported shape, the reason is returned.
    """
    word = card.word(3)
    shape = SHAPES.get(word)
    if shape is None:
        return f"its section {word or 'of no type'} is not read"
    n = len(signature(shape).parameters)
    stations = [(0.0, _sizes(card, 8, n, None))]
    place = 8 + n + 1
    while card.name == "PBEAML" and not card.is_blank(place, place + n + 3):
        at = card.real(place + 1, "X/XB", 1.0)
        stations.append((at, _sizes(card, place + 2, n, stations[0][1])))
        place += n + 3
    made: list[BeamValues] = []
    for _, sizes in stations:
        section = shape(*sizes[:-1]) if min(sizes[:-1]) >= 0 else None
        if section is None or not section.area > 0:
            return f"the sizes {list(sizes[:-1])} do not make a section {word}"
        if card.name == "PBARL":
            section = replace(section, shear_centre=(0.0, 0.0))
        made.append(section.beam_values(material.density, (sizes[-1] + added) * reading.mass_factor))
    places = [place for place, _ in stations]
    second = made[places.index(1.0)] if 1.0 in places else made[0]
    listed = [[s.area, s.I1, s.I2, s.J, s.mass_per_length] for s in (made[0], second, *made[1:])]
    between = list(zip(places[1:], listed[2:], strict=True))
    _leave_out_between(card, listed[0], listed[1], between, reading)
    return BeamProperty(material, made[0], None if second == made[0] else second)


def _sizes(card: BulkCard, place: int, count: int, default: tuple[float, ...] | None) -> tuple[float, ...]:
    """DIM1 .. and NSM from a field on; blank values of further stations are those of the first."""
    sizes = tuple(
        card.real(place + i, f"DIM{i + 1}", None if default is None else default[i]) for i in range(count)
    )
    return (*sizes, card.real(place + count, "NSM", 0.0 if default is None else default[count]))


_BEAMS: dict[str, Callable[[BulkCard, IsotropicMaterial, DeckReading, float], BeamProperty | str]] = {
    "PBAR": _pbar,
    "PBARL": _shaped,
    "PBEAM": _pbeam,
    "PBEAML": _shaped,
    "PBEND": _pbend,
}
