"""Materials and properties of a Nastran file: MAT1, PSOLID, PSHELL, and beam sections."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, tanh
from typing import NamedTuple

from supple.importers.nastran.bulk_data import BulkCard, BulkFile

__all__ = ["BeamProperty", "ElasticMaterial", "ShellProperty", "SolidProperty"]

# E, G and nu of a MAT1 may all be given; beyond this they no longer describe one isotropic material.
LARGEST_INCONSISTENCY = 0.01


@dataclass(frozen=True)
class ElasticMaterial:
    """E, Pa; nu; density, kg/m^3."""

    youngs_modulus: float
    poissons_ratio: float
    density: float


@dataclass(frozen=True)
class SolidProperty:
    """PSOLID: the material of solid cells."""

    material: ElasticMaterial


@dataclass(frozen=True)
class ShellProperty:
    """PSHELL: a homogeneous shell section; non-structural mass is in the density."""

    material: ElasticMaterial
    thickness: float


@dataclass(frozen=True)
class BeamProperty:
    """PBAR, PBARL, PBEAM, PBEAML: a constant section; non-structural mass is in the mass per length.

    Bending in plane 1 (element x-y) uses I1 = I_zz, in plane 2 (x-z) I2 = I_yy; K1 and K2 are the shear
    factors of these planes, zero where shear is rigid. `orientation` lies in plane 1, in basic axes.
    """

    material: ElasticMaterial
    area: float
    I1: float
    I2: float
    J: float
    K1: float
    K2: float
    mass_per_length: float
    orientation: tuple[float, float, float] = (0.0, 0.0, 1.0)


class _SectionValues(NamedTuple):
    """Area, second moments, torsion constant and shear factors of a section."""

    area: float
    I1: float
    I2: float
    J: float
    K1: float
    K2: float


Property = SolidProperty | ShellProperty | BeamProperty

# Rows that a station of a PBEAM takes: its section, and after YES its stress points.
_STATIONS = {"YES": 2, "YESA": 1, "NO": 1}

PROPERTY_CARDS = ("PSOLID", "PSHELL", "PBAR", "PBARL", "PBEAM", "PBEAML")


def read_property(card: BulkCard, file: BulkFile) -> Property:
    """Property of a PSOLID, PSHELL, PBAR(L) or PBEAM(L) card with its material.

    Raises
    ------
    ImportFormatError   a missing material or one without density; options that our elements do not have
    """
    return _READERS[card.name](card, file)


def _solid(card: BulkCard, file: BulkFile) -> SolidProperty:
    if card.word(2) not in ("", "0"):
        raise card.error("a material coordinate system (CORDM) is not read; isotropic solids need none")
    if card.word(6) not in ("", "SMECH"):
        raise card.error(f"FCTN is {card.word(6)}, a fluid; only structure (SMECH) is read")
    return SolidProperty(_material(card, file, card.integer(1, "the material id")))


def _shell(card: BulkCard, file: BulkFile) -> ShellProperty:
    membrane = card.integer(1, "the membrane material MID1")
    if card.integer(3, "the bending material MID2", 0) != membrane:
        raise card.error(
            f"the bending material MID2 is {card.word(3) or 'blank'}, the membrane's is {membrane}; our "
            "shells are homogeneous, so give both the same"
        )
    if abs(card.real(4, "12 I/T^3", 1.0) - 1.0) > 1e-12:
        raise card.error(f"12 I/T^3 is {card.word(4)}; only homogeneous walls (1.0) are read")
    if card.word(10) not in ("", "0"):
        raise card.error("a coupling material MID4 is not read; only walls symmetric about their middle are")
    thickness = card.real(2, "the thickness T")
    if thickness <= 0:
        raise card.error(f"the thickness T is {thickness:g}; it must be positive")
    added = card.real(7, "the non-structural mass NSM", 0.0) * _mass_factor(file)
    return ShellProperty(_material(card, file, membrane, added / thickness), thickness)


def _bar(card: BulkCard, file: BulkFile) -> BeamProperty:
    area, I1, I2, J = (card.real(2 + i, what, 0.0) for i, what in enumerate(("A", "I1", "I2", "J")))
    K1, K2 = card.real(16, "K1", 0.0), card.real(17, "K2", 0.0)
    if card.real(18, "I12", 0.0) != 0.0:
        raise card.error("a product of inertia I12 is not read; turn the section to its principal axes")
    return _section(card, file, _SectionValues(area, I1, I2, J, K1, K2), card.real(6, "NSM", 0.0))


def _beam(card: BulkCard, file: BulkFile) -> BeamProperty:
    names = ("A", "I1", "I2", "I12", "J", "NSM")
    area, I1, I2, I12, J, added = (card.real(2 + i, what, 0.0) for i, what in enumerate(names))
    if I12 != 0.0:
        raise card.error("a product of inertia I12 is not read; turn the section to its principal axes")
    own = (area, I1, I2, I12, J, added)
    stations, last = _rows_of_beam(card)
    for row in stations:
        if any(
            word and abs(_number(card, word) - value) > 1e-9 * abs(value)
            for word, value in zip(row[2:8], own, strict=False)
        ):
            raise card.error("a tapered section is not read; cut the beam into pieces of constant section")
    if any(word and _number(card, word) != 0 for word in last[2:]):
        raise card.error("shear relief, NSI, warping and offsets (S1 .. N2) are not read; leave them blank")
    K1, K2 = (_number(card, word) if word else 1.0 for word in (*last, "", "")[:2])
    return _section(card, file, _SectionValues(area, I1, I2, J, K1, K2), added)


def _rows_of_beam(card: BulkCard) -> tuple[list[tuple[str, ...]], tuple[str, ...]]:
    """Stations of a PBEAM (SO, X/XB, section there) and the fields from K1 on, without stress points."""
    rows = [card.fields[i : i + 8] for i in range(8, len(card.fields), 8)]
    stations: list[tuple[str, ...]] = []
    place = 0 if rows and rows[0][0].upper() in _STATIONS else 1
    while place < len(rows) and rows[place][0].upper() in _STATIONS:
        stations.append(rows[place])
        place += _STATIONS[rows[place][0].upper()]
    return stations, tuple(word for row in rows[place:] for word in row)


def _number(card: BulkCard, word: str) -> float:
    return BulkCard(card.name, (word,), card.path, card.line).real(0, "a section value")


def _shaped(card: BulkCard, file: BulkFile) -> BeamProperty:
    shape = card.word(3)
    if shape not in _SHAPES:
        raise card.error(
            f"section {shape or 'of no type'} is not read; write PBAR or PBEAM, or one of "
            f"{', '.join(_SHAPES)}"
        )
    count, section = _SHAPES[shape]
    sizes = [card.real(8 + i, f"DIM{i + 1}") for i in range(count)]
    if min(sizes) <= 0:
        raise card.error(f"sizes {sizes} of section {shape}; they must be positive")
    if any(card.word(8 + count + 1 + i) for i in range(8)):
        raise card.error("a tapered section is not read; cut the beam into pieces of constant section")
    return _section(card, file, section(*sizes), card.real(8 + count, "NSM", 0.0))


def _rod(radius: float) -> _SectionValues:
    return _SectionValues(pi * radius**2, *_round(radius, 0.0), 0.9, 0.9)


def _tube(outer: float, inner: float) -> _SectionValues:
    return _SectionValues(pi * (outer**2 - inner**2), *_round(outer, inner), 0.5, 0.5)


def _round(outer: float, inner: float) -> tuple[float, float, float]:
    """I1, I2 and J of a circular section."""
    second_moment = pi * (outer**4 - inner**4) / 4
    return second_moment, second_moment, 2 * second_moment


def _rectangle(width: float, height: float) -> _SectionValues:
    """J by its series [Timoshenko & Goodier, Theory of Elasticity, 3rd ed., eq. (170)]."""
    long, short = max(width, height), min(width, height)
    odd = range(1, 20, 2)
    series = sum(tanh(n * pi * long / (2 * short)) / n**5 for n in odd)
    J = long * short**3 / 3 * (1 - 192 / pi**5 * short / long * series)
    return _SectionValues(width * height, width * height**3 / 12, height * width**3 / 12, J, 5 / 6, 5 / 6)


_SHAPES: dict[str, tuple[int, Callable[..., _SectionValues]]] = {
    "ROD": (1, _rod),
    "TUBE": (2, _tube),
    "BAR": (2, _rectangle),
}


def _section(card: BulkCard, file: BulkFile, values: _SectionValues, added: float) -> BeamProperty:
    area, I1, I2, J, K1, K2 = values
    for what, value in (("the area", area), ("I1", I1), ("I2", I2), ("J", J)):
        if value <= 0:
            raise card.error(f"{what} is {value:g}; a beam of ours needs area, I1, I2 and J, all positive")
    material = _material(card, file, card.integer(1, "the material id"))
    mass = material.density * area + added * _mass_factor(file)
    return BeamProperty(material, area, I1, I2, J, K1, K2, mass)


def _material(card: BulkCard, file: BulkFile, number: int, added_density: float = 0.0) -> ElasticMaterial:
    """The MAT1 of that number with its density in units of mass; E, G and nu fill each other in."""
    cards = [m for m in file.named("MAT1") if m.integer(0, "the material id") == number]
    if not cards:
        raise card.error(
            f"names material {number}, which no MAT1 defines; add it (other materials are not read)"
        )
    if len(cards) > 1:
        raise cards[1].error(f"material {number} is defined a second time; renumber or remove it")
    mat = cards[0]
    E, G, nu = (mat.real(1 + i, what, 0.0) for i, what in enumerate(("E", "G", "NU")))
    has_nu = bool(mat.word(3))
    if E <= 0 and G > 0 and has_nu:
        E = 2 * G * (1 + nu)
    if E <= 0:
        raise mat.error("E is missing or not positive; give E, or G and NU")
    if not has_nu:
        if G <= 0:
            raise mat.error("NU and G are both missing, and Nastran would take 0 for both; give one of them")
        nu = E / (2 * G) - 1
    if G > 0 and has_nu and abs(G - E / (2 * (1 + nu))) > LARGEST_INCONSISTENCY * G:
        raise mat.error(
            f"G = {G:g} does not fit E = {E:g} and NU = {nu:g}, which give {E / (2 * (1 + nu)):g}; our "
            "materials are isotropic, so leave one of the three blank"
        )
    if not -1 < nu < 0.5:
        raise mat.error(f"Poisson's ratio is {nu:g}; it lies between -1 and 0.5")
    density = mat.real(4, "the density RHO", 0.0) * _mass_factor(file) + added_density
    if density <= 0:
        raise mat.error("no density; a moving body needs mass, so give RHO (field 6)")
    return ElasticMaterial(E, nu, density)


def _mass_factor(file: BulkFile) -> float:
    """PARAM,WTMASS: turns weights into masses."""
    cards = [card for card in file.named("PARAM") if card.word(0) == "WTMASS"]
    factors = [card.real(1, "WTMASS") for card in cards]
    for card, factor in zip(cards, factors, strict=True):
        if factor <= 0:
            raise card.error(f"WTMASS is {factor:g}; it must be positive")
        if factor != factors[0]:
            raise card.error(f"WTMASS is {factor:g}, and {factors[0]:g} above; keep one of the two")
    return factors[0] if factors else 1.0


_READERS: dict[str, Callable[[BulkCard, BulkFile], Property]] = {
    "PSOLID": _solid,
    "PSHELL": _shell,
    "PBAR": _bar,
    "PBARL": _shaped,
    "PBEAM": _beam,
    "PBEAML": _shaped,
}
