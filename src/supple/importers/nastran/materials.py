"""Materials of a Nastran deck: MAT1 (MATT1 at a temperature), MAT2, MAT8, MAT9 and MAT11."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray
from supple.importers.deck import AnisotropicMaterial, IsotropicMaterial
from supple.importers.laminate import orthotropic_stiffness, plane_stress_stiffness
from supple.importers.nastran.bulk_data import BulkCard, by_id
from supple.importers.nastran.deck_reading import DeckReading

MATERIAL_CARDS = ("MAT1", "MAT2", "MAT8", "MAT9", "MAT11")

# Nastran lists strains xx yy zz xy yz zx; a deck xx yy zz yz xz xy.
_ORDER = [0, 1, 2, 4, 5, 3]

LARGEST_INCONSISTENCY = 0.01
"""Largest relative difference of G and E / (2 (1 + nu)) at which shear follows from E and nu.

Above it, shear uses G; Nastran then warns and also uses G.
"""


@dataclass(frozen=True, eq=False)
class WallMaterial:
    """A material of walls.

    plane_stress : (3, 3) stiffness, order xx, yy, xy
    shear : (2, 2) transverse shear stiffness, order xz, yz; None if rigid
    isotropic : the material of a MAT1; None for other cards
    """

    plane_stress: FloatArray
    shear: FloatArray | None
    density: float
    isotropic: IsotropicMaterial | None


class Materials:
    """Materials by id; ImportFormatError if cards with the same id differ."""

    def __init__(self, reading: DeckReading) -> None:
        self._reading = reading
        self._line: dict[int, IsotropicMaterial] = {}
        self._of_lines: dict[int, BulkCard] = {}
        self._half_rigid: set[BulkCard] = set()
        self._cards = by_id(reading.file.named(*MATERIAL_CARDS), "material")
        self._cards |= at_temperature(reading, self._cards)

    def isotropic(self, number: int) -> IsotropicMaterial | str:
        """The material of a MAT1 for beams and rods; else the reason for its absence."""
        card = self._cards.get(number)
        if card is None or card.name != "MAT1":
            return self._missing(number, card)
        if number not in self._line:
            self._line[number] = self._mat1(card)
        found = self._line[number]
        if not (found.youngs_modulus > 0 or found.shear_modulus):
            return f"its material {number} has no stiffness"
        if not -1 < found.poissons_ratio <= 0.5:
            return f"Poisson's ratio of its material {number} is {found.poissons_ratio:g}"
        return found

    def _continuum(self, number: int) -> IsotropicMaterial | str:
        """The material of a MAT1 for walls and solids; else the reason for its absence.

        Records that Poisson's ratio 0 replaces an impossible one that follows from E and G.
        """
        found = self.isotropic(number)
        if number in self._of_lines:
            meaning = "E and G give an impossible Poisson's ratio for a wall or solid: 0 is used"
            self._reading.leave_out(self._of_lines.pop(number), meaning)
        return found

    def of_solid(self, number: int) -> IsotropicMaterial | AnisotropicMaterial | str:
        """The material of solid cells; else the reason for its absence."""
        card = self._cards.get(number)
        if card is None or card.name not in ("MAT1", "MAT9", "MAT11"):
            return self._missing(number, card)
        if card.name == "MAT1":
            return self._continuum(number)
        return self._mat9(card) if card.name == "MAT9" else self._mat11(card)

    def of_wall(self, number: int) -> WallMaterial | str:
        """The material of a wall or ply; else the reason for its absence."""
        card = self._cards.get(number)
        if card is None or card.name not in ("MAT1", "MAT2", "MAT8"):
            return self._missing(number, card)
        if card.name == "MAT1":
            return self._plane_isotropic(number)
        return self._mat2(card) if card.name == "MAT2" else self._mat8(card)

    def _missing(self, number: int, card: BulkCard | None) -> str:
        if card is not None:
            return f"its material {number} is a {card.name}, which these elements do not support"
        other = next(
            (
                name
                for name, cards in self._reading.file.by_name.items()
                if name.startswith("MAT") and any(c.word(0) == str(number) for c in cards)
            ),
            None,
        )
        if other == "MAT10":
            return "they are fluid (MAT10)"
        return f"its material {number} is " + (f"a {other}, which is not read" if other else "not defined")

    def _density(self, card: BulkCard, place: int) -> float:
        return card.real(place, "the density RHO", 0.0) * self._reading.mass_factor

    def _mat1(self, card: BulkCard) -> IsotropicMaterial:
        """E, G and nu determine one another; if all three are given and inconsistent, shear uses G."""
        E, G, nu = card.reals(1, "E", "G", "NU")
        has_E, has_G, has_nu = E > 0, G > 0, bool(card.word(3))
        shear: float | None = None
        if has_G and has_E and not has_nu:
            nu = E / (2 * G) - 1
        if has_G and has_E and not -1 < nu <= 0.5:
            nu, shear = 0.0, G  # beams do not use nu
            self._of_lines[card.integer(0, "the material id")] = card
        elif nu <= -1:
            return IsotropicMaterial(E, nu, 0.0)  # `isotropic` refuses it by this nu
        elif has_G and has_nu and not has_E:
            E = 2 * G * (1 + nu)
        elif has_G and (not has_E or abs(1 - E / (2 * (1 + nu) * G)) > LARGEST_INCONSISTENCY):
            shear = G
        elif has_E and not has_nu and not has_G:
            self._reading.note(
                f"MAT1 {card.word(0)} gives E alone; NU counts as 0, G as E / 2 (Nastran: G = 0)."
            )
        factor = self._reading.stiffness_factor
        return IsotropicMaterial(
            E * factor, nu, self._density(card, 4), None if shear is None else shear * factor
        )

    def _plane_isotropic(self, number: int) -> WallMaterial | str:
        found = self._continuum(number)
        if isinstance(found, str):
            return found
        E, nu = found.youngs_modulus, found.poissons_ratio
        G = E / (2 * (1 + nu)) if found.shear_modulus is None else found.shear_modulus
        C = E / (1 - nu**2)
        Q = np.array([[C, nu * C, 0.0], [nu * C, C, 0.0], [0.0, 0.0, G]])
        return WallMaterial(Q, G * np.eye(2) if G > 0 else None, found.density, found)

    def _mat2(self, card: BulkCard) -> WallMaterial:
        G = card.reals(1, "G11", "G12", "G13", "G22", "G23", "G33")
        Q = np.array([[G[0], G[1], G[2]], [G[1], G[3], G[4]], [G[2], G[4], G[5]]])
        Q = Q * self._reading.stiffness_factor
        # A MAT2 that MID3 names gives the transverse shear stiffness by G11, G12, G22.
        shear = Q[:2, :2] if np.linalg.det(Q[:2, :2]) > 0 else None
        return WallMaterial(Q, shear, self._density(card, 7), None)

    def _mat8(self, card: BulkCard) -> WallMaterial | str:
        E1, E2, nu, G12, G1Z, G2Z = card.reals(1, "E1", "E2", "NU12", "G12", "G1Z", "G2Z")
        d = 1 - nu**2 * E2 / E1 if E1 > 0 else 0.0
        if not (E2 > 0 and d > 0):
            return f"its material {card.word(0)} has no stiffness: E1 = {E1:g}, E2 = {E2:g}, NU12 = {nu:g}"
        Q, factor = plane_stress_stiffness(E1, E2, nu, G12), self._reading.stiffness_factor
        shear = np.diag([G1Z, G2Z]) * factor if G1Z > 0 and G2Z > 0 else None
        if (G1Z > 0) != (G2Z > 0) and card not in self._half_rigid:
            self._half_rigid.add(card)
            self._reading.leave_out(card, "one of G1Z and G2Z is not positive: both count as rigid")
        return WallMaterial(Q * factor, shear, self._density(card, 7), None)

    def _mat9(self, card: BulkCard) -> AnisotropicMaterial:
        G = np.zeros((6, 6))
        G[np.triu_indices(6)] = card.reals(1, *["a stiffness G"] * 21)
        G = G + np.triu(G, 1).T
        return AnisotropicMaterial(
            G[np.ix_(_ORDER, _ORDER)] * self._reading.stiffness_factor, self._density(card, 22)
        )

    def _mat11(self, card: BulkCard) -> AnisotropicMaterial | str:
        constants = card.reals(1, "E1", "E2", "E3", "NU12", "NU13", "NU23", "G12", "G13", "G23")
        if min(*constants[:3], *constants[6:]) <= 0:
            return f"its material {card.word(0)} has a modulus that is not positive"
        C = orthotropic_stiffness(*constants)
        if not np.linalg.eigvalsh(C)[0] > 0:
            return f"its material {card.word(0)} has impossible Poisson's ratios"
        return AnisotropicMaterial(C * self._reading.stiffness_factor, self._density(card, 10))


# --- materials at the temperature selected by case control: MATT1 with TEMPD and TABLEM1

_DEPENDENT = ("MATT1", "MATT2", "MATT3", "MATT8", "MATT9", "MATT11")
_FIELDS = ("TEMP", "TEMPP1", "TEMPP3", "TEMPRB", "TEMPF", "TEMPG")
_OF_STIFFNESS_AND_MASS = range(1, 5)
"""Indices in `BulkCard.fields` of E, G, NU and RHO in a MAT1, and of their tables in a MATT1."""


def at_temperature(reading: DeckReading, cards: Mapping[int, BulkCard]) -> dict[int, BulkCard]:
    """{id: MAT1 card} with the values of MATT1 tables at the uniform temperature that case control selects.

    Empty if case control selects no temperatures. Other tables, and tables at temperatures that are not
    uniform or outside a table, are left out.
    """
    if not reading.case.temperature:
        return {}
    temperature = _uniform(reading)
    tables = by_id(reading.file.named("TABLEM1"), "table")
    found: dict[int, BulkCard] = {}
    for number, card in by_id(reading.file.named(*_DEPENDENT), "material").items():
        if number not in cards or (card.name == "MATT1" and card.is_blank(1, 5)):
            continue  # tables of thermal expansion or damping only
        fields = [*cards[number].fields, *[""] * 5]
        known = card.name == "MATT1" and temperature is not None
        for place in _OF_STIFFNESS_AND_MASS if known else ():
            if card.word(place) in ("", "0"):
                continue
            value = _interpolated(tables.get(card.integer(place, "a table")), temperature or 0.0)
            known &= value is not None
            fields[place] = repr(value)
        if known:
            found[number] = cards[number]._replace(fields=tuple(fields))
        else:
            reading.leave_out(card, "its values at the temperatures of case control are not read")
    return found


def _uniform(reading: DeckReading) -> float | None:
    """The uniform temperature by TEMPD; None without TEMPD, or if cards give grids or elements others."""
    chosen = reading.case.temperature
    if any(card.word(0) == chosen for card in reading.file.named(*_FIELDS)):
        return None
    for card in reading.file.named("TEMPD"):
        for place in range(0, len(card.fields), 2):
            if card.word(place) == chosen:
                return card.real(place + 1, "the temperature")
    return None


def _interpolated(table: BulkCard | None, at: float) -> float | None:
    """Value of a TABLEM1, linear between its points, on an axis LOG linear in the logarithm.

    None outside the range of the points, without table or points, or for values without logarithm.
    """
    if table is None:
        return None
    words = [word.upper() for word in table.fields[8:]]
    pairs = zip(range(8, len(table.fields), 2), words[::2], words[1::2], strict=False)
    points = [
        (table.real(place, "x"), table.real(place + 1, "y"))
        for place, x, y in pairs
        if x and y and "ENDT" not in (x, y) and "SKIP" not in (x, y)
    ]
    if not points:
        return None
    x, y = np.array(sorted(points)).T
    log_x, log_y = (table.word(place) == "LOG" for place in (1, 2))
    if not x[0] <= at <= x[-1] or (log_x and x[0] <= 0) or (log_y and y.min() <= 0):
        return None
    if log_x:
        x, at = np.log(x), float(np.log(at))
    return float(np.exp(np.interp(at, x, np.log(y))) if log_y else np.interp(at, x, y))
