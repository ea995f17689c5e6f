"""Walls of a Nastran deck: PSHELL, PCOMP and PCOMPG as `ShellProperty` or `WallProperty`."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from supple.importers.deck import ShellProperty, WallProperty
from supple.importers.laminate import Ply, laminate, moved_wall
from supple.importers.nastran.bulk_data import BulkCard
from supple.importers.nastran.deck_reading import DeckReading
from supple.importers.nastran.materials import Materials, WallMaterial

WALL_CARDS = ("PSHELL", "PCOMP", "PCOMPG")


@dataclass(frozen=True)
class WallOptions:
    """Wall data of an element.

    thicknesses : T1 .. T4 at the corners; None (blank) stands for T of the property; the wall has the mean
    relative : whether T1 .. T4 are factors on T of the property
    offset : ZOFFS, m;  added_mass : of NSM cards, kg/m^2, not yet multiplied by PARAM,WTMASS
    """

    thicknesses: tuple[float | None, ...] = ()
    relative: bool = False
    offset: float = 0.0
    added_mass: float = 0.0


def read_wall(
    card: BulkCard, materials: Materials, reading: DeckReading, options: WallOptions
) -> ShellProperty | WallProperty | str:
    """The wall of a property card with the options of an element, or the reason why the card is not read."""
    if card.name == "PSHELL":
        return _pshell(card, materials, reading, options)
    return _pcomp(card, materials, reading, options)


def _pshell(
    card: BulkCard, materials: Materials, reading: DeckReading, options: WallOptions
) -> ShellProperty | WallProperty | str:
    """The wall of a PSHELL: MID1 membrane, MID2 bending, MID3 transverse shear, MID4 coupling.

        A = T G1,  D = 12I/T^3 T^3/12 G2,  H = TS/T T G3,  B = -T^2 G4

    G1, G2, G4 are plane-stress stiffnesses, G3 is a transverse shear stiffness. B is negative because the
    curvature of Nastran has the opposite sign.
    """
    if card.word(3) == "-1":
        return "its bending is that of plane strain (MID2 = -1), which is not read"
    used: dict[int, WallMaterial] = {}
    for place in (1, 3, 5, 10):
        if card.word(place) not in ("", "0"):
            found = materials.of_wall(card.integer(place, "a material"))
            if isinstance(found, str):
                return found
            used[place] = found
    if not used:
        return "its property names no material"
    T = card.real(2, "the thickness T", 0.0)
    factor = T if options.relative else 1.0
    given = [T if value is None else factor * value for value in options.thicknesses]
    t = sum(given) / len(given) if given else T
    if t <= 0:
        return "its property has no thickness"
    ratio, shear_ratio = card.real(4, "12I/T^3", 1.0), card.real(6, "TS/T", 5 / 6)
    added = (card.real(7, "NSM", 0.0) + options.added_mass) * reading.mass_factor
    membrane, bending, shear, coupling = (used.get(place) for place in (1, 3, 5, 10))
    material = membrane.isotropic if membrane else None
    if (
        material is not None
        and material.shear_modulus is None
        and card.word(1) == card.word(3)
        and abs(ratio - 1) < 1e-9
        and coupling is None
        and (shear is None or card.word(5) == card.word(1))
    ):
        return ShellProperty(material, t, added, options.offset, shear_ratio if shear else 0.0)
    none = np.zeros((3, 3))
    density = (membrane or bending or next(iter(used.values()))).density
    wall = WallProperty(
        membrane=t * membrane.plane_stress if membrane else none,
        coupling=-(t**2) * coupling.plane_stress if coupling else none,
        bending=ratio * t**3 / 12 * bending.plane_stress if bending else none,
        shear=shear_ratio * t * shear.shear if shear and shear.shear is not None else None,
        mass_per_area=density * t + added,
        rotary_inertia_per_area=(density + added / t) * t**3 / 12,
        thickness=t,
    )
    return moved_wall(wall, options.offset) if options.offset else wall


def _pcomp(
    card: BulkCard, materials: Materials, reading: DeckReading, options: WallOptions
) -> WallProperty | str:
    """The wall of a PCOMP or PCOMPG, with plies from the bottom up; Z0 is the position of the lower face."""
    plies: list[Ply] = []
    for material, thickness, angle in _rows(card):
        found = materials.of_wall(material)
        if isinstance(found, str):
            return found
        plies.append(Ply(found.plane_stress, found.shear, found.density, thickness, float(np.radians(angle))))
    option = card.word(7)
    if option == "SYM":
        plies += plies[::-1]
    plies = [ply for ply in plies if ply.thickness > 0]
    if not plies:
        return "its property has no plies"
    if option not in ("", "SYM", "MEM", "BEND", "SMEAR", "SMCORE"):
        return f"the option LAM = {option} of its property is not read"
    if option == "SMCORE":
        return "its property smears the faces about a core (LAM = SMCORE), which is not read"
    total = sum(ply.thickness for ply in plies)
    bottom = card.real(1, "Z0", -total / 2)
    added = (card.real(2, "NSM", 0.0) + options.added_mass) * reading.mass_factor
    wall = _with_option(laminate(plies, added_mass=added), option)
    middle = bottom + total / 2 + options.offset
    return moved_wall(wall, middle) if abs(middle) > 1e-12 * total else wall


def _with_option(wall: WallProperty, option: str) -> WallProperty:
    """The wall with smeared plies (SMEAR), or with only its membrane (MEM) or bending (BEND) stiffness."""
    none = np.zeros((3, 3))
    if option == "SMEAR":
        return replace(wall, coupling=none, bending=wall.membrane * wall.thickness**2 / 12)
    if option == "MEM":
        return replace(wall, coupling=none, bending=none)
    if option == "BEND":
        return replace(wall, coupling=none, membrane=none)
    return wall


def _rows(card: BulkCard) -> list[tuple[int, float, float]]:
    """Material, thickness and angle of each ply; a blank material or thickness is that of the ply before."""
    # PCOMP: two plies in a row, four fields each; PCOMPG: one ply in a row, after its global ply id.
    start, step, first = (8, 4, 0) if card.name == "PCOMP" else (8, 8, 1)
    found: list[tuple[int, float, float]] = []
    material, thickness = 0, 0.0
    for place in range(start, len(card.fields), step):
        if card.is_blank(place, place + step):
            continue
        material = card.integer(place + first, "a ply's material", material or None)
        thickness = card.real(place + first + 1, "a ply's thickness", thickness or None)
        found.append((material, thickness, card.real(place + first + 2, "a ply's angle", 0.0)))
    return found
