"""Grid points and coordinate systems of a Nastran file: GRID, CORD, in basic coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.arrays import BoolArray, FloatArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.nastran.bulk_data import BulkCard, BulkFile, by_id, integer_column, real_column
from supple.importers.numbering import positions_of_ids


class CoordinateKind(Enum):
    """Coordinates of a point; angles are in degrees."""

    RECTANGULAR = auto()
    """x, y, z"""
    CYLINDRICAL = auto()
    """r, theta about z, z"""
    SPHERICAL = auto()
    """r, theta from the z axis, phi about z"""


@dataclass(frozen=True, eq=False)
class CoordinateSystem:
    """A coordinate system, expressed in the basic coordinate system.

    origin : (3,)      in basic coordinates
    axes   : (3, 3)    unit vectors of its x, y, z as columns, in basic axes
    """

    coordinates: CoordinateKind
    origin: FloatArray
    axes: FloatArray

    def basic(self, points: ArrayLike) -> FloatArray:
        """Basic coordinates (k, 3) of points given in the coordinates of this system."""
        first, second, third = np.moveaxis(np.asarray(points, dtype=np.float64), -1, 0)
        match self.coordinates:
            case CoordinateKind.RECTANGULAR:
                x, y, z = first, second, third
            case CoordinateKind.CYLINDRICAL:
                theta = np.radians(second)
                x, y, z = first * np.cos(theta), first * np.sin(theta), third
            case CoordinateKind.SPHERICAL:
                theta, phi = np.radians(second), np.radians(third)
                x, y = first * np.sin(theta) * np.cos(phi), first * np.sin(theta) * np.sin(phi)
                z = first * np.cos(theta)
        return self.origin + np.stack([x, y, z], axis=-1) @ self.axes.T

    def directions(self, points: FloatArray) -> FloatArray:
        """Unit vectors (k, 3, 3) of the coordinate lines at points (k, 3), as columns; all in basic axes.

        On the axis of a cylindrical or spherical system, where the angle is undefined, they are axes x, y, z.
        """
        x, y, z = np.moveaxis((points - self.origin) @ self.axes, -1, 0)
        rho = np.hypot(x, y)
        on_axis = rho <= 1e-9 * float(np.abs(points - self.origin).max(initial=0.0))
        phi = np.where(on_axis, 0.0, np.arctan2(y, x))
        c, s, o, e = np.cos(phi), np.sin(phi), np.zeros_like(phi), np.ones_like(phi)
        match self.coordinates:
            case CoordinateKind.RECTANGULAR:
                rows = [[e, o, o], [o, e, o], [o, o, e]]
            case CoordinateKind.CYLINDRICAL:
                rows = [[c, -s, o], [s, c, o], [o, o, e]]
            case CoordinateKind.SPHERICAL:
                theta = np.arctan2(rho, z)
                ct, st = np.cos(theta), np.sin(theta)
                rows = [[st * c, ct * c, -s], [st * s, ct * s, c], [ct, -st, o]]
        local = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
        local[on_axis] = np.eye(3)
        return self.axes @ local


BASIC = CoordinateSystem(CoordinateKind.RECTANGULAR, np.zeros(3), np.eye(3))


def through_points(
    coordinates: CoordinateKind, origin: FloatArray, on_axis: FloatArray, in_plane: FloatArray
) -> CoordinateSystem | None:
    """System with z axis from `origin` to `on_axis`, and `in_plane` in the x-z plane; None if collinear.

    origin, on_axis, in_plane : (3,) in basic coordinates
    """
    z, arm = on_axis - origin, in_plane - origin
    y = np.cross(z, arm)
    if not np.linalg.norm(y) > 1e-9 * np.linalg.norm(z) * np.linalg.norm(arm):
        return None
    z, y = z / np.linalg.norm(z), y / np.linalg.norm(y)
    return CoordinateSystem(coordinates, origin, np.stack([np.cross(y, z), y, z], axis=-1))


COORDINATE_CARDS = ("CORD2R", "CORD2C", "CORD2S", "CORD1R", "CORD1C", "CORD1S")
_COORDINATES = {
    "R": CoordinateKind.RECTANGULAR,
    "C": CoordinateKind.CYLINDRICAL,
    "S": CoordinateKind.SPHERICAL,
}


@dataclass(frozen=True, eq=False)
class GridPoints:
    """All grid points of a file, in its order.

    ids       : (N,)
    positions : (N, 3)      in basic coordinates
    axes      : (N, 3, 3)   directions of the displacements (CD) as columns, in basic axes
    supports  : (N,)        permanent supports (PS), components as written; an empty string without supports
    cards     : the GRID card of each point
    systems   : {id: coordinate system}; 0 is the basic coordinate system
    """

    ids: IntArray
    positions: FloatArray
    axes: FloatArray
    supports: NDArray[np.str_]
    cards: tuple[BulkCard, ...]
    systems: dict[int, CoordinateSystem]

    def lookup(self, ids: IntArray) -> tuple[IntArray, BoolArray]:
        """Numbers from 0 of grid ids, and whether the grids exist."""
        return positions_of_ids(self.ids, ids)

    def numbers(self, card: BulkCard, ids: list[int]) -> IntArray:
        """Numbers from 0 of the grid points that a card names; ImportFormatError for a missing grid."""
        wanted = np.array(ids, dtype=np.int64)
        numbers, known = self.lookup(wanted)
        if not known.all():
            raise card.error(
                f"names grid {wanted[~known][0]}, which the file does not define; add its GRID card, "
                "or remove this card"
            )
        return numbers


def read_grids(file: BulkFile) -> GridPoints:
    """Grid points of a file.

    Raises
    ------
    ImportFormatError   no GRID card, unless superelements have some; a grid id with two different cards;
                        coordinate systems that are missing, given twice, circular, or by points on one line;
                        fields that are not numbers
    """
    cards = _once(file.named("GRID"))
    if not cards and not file.parts:
        raise ImportFormatError(f"{file.path}: no GRID card; is this a mesh file, and complete?")
    ids = integer_column(cards, 0, "the grid id")
    given_in, moved_in, supported = _defaults(file)
    given_in = integer_column(cards, 1, "the coordinate system CP", given_in)
    moved_in = integer_column(cards, 5, "the coordinate system CD", moved_in)
    moved_in[moved_in == -1] = 0  # -1 marks a grid of a fluid
    local = np.stack([real_column(cards, 2 + i, f"coordinate X{i + 1}", 0.0) for i in range(3)], axis=1)
    systems, positions = _resolve(file, ids, given_in, local)
    axes = np.broadcast_to(np.eye(3), (len(ids), 3, 3)).copy()
    for system in np.unique(np.concatenate([given_in, moved_in])).tolist():
        if system not in systems:
            wrong = int(np.flatnonzero((given_in == system) | (moved_in == system))[0])
            raise cards[wrong].error(
                f"names coordinate system {system}, which the file does not define; add its CORD card"
            )
        members = moved_in == system
        axes[members] = systems[system].directions(positions[members])
    supports = np.array([card.word(6) or supported for card in cards])
    return GridPoints(ids, positions, axes, supports, tuple(cards), systems)


def _defaults(file: BulkFile) -> tuple[int, int, str]:
    """CP, CD and PS of GRDSET, for grids with blank fields."""
    cards = file.named("GRDSET")
    if not cards:
        return 0, 0, ""
    if len(cards) > 1:
        raise cards[1].error("occurs a second time; keep one of the two")
    return cards[0].integer(1, "CP", 0), cards[0].integer(5, "CD", 0), cards[0].word(6)


def _once(cards: list[BulkCard]) -> list[BulkCard]:
    """The cards without repetitions; ImportFormatError if cards with the same id differ."""
    ids = integer_column(cards, 0, "the grid id")
    if np.unique(ids).size == len(ids):
        return cards
    return list(by_id(cards, "grid").values())


def _resolve(
    file: BulkFile, ids: IntArray, given_in: IntArray, local: FloatArray
) -> tuple[dict[int, CoordinateSystem], FloatArray]:
    """Coordinate systems in basic coordinates and grid positions (N, 3), each after those that define it."""
    systems = {0: BASIC}
    positions = np.full(local.shape, np.nan)
    waiting = _definitions(file)
    while True:
        for system in np.unique(given_in):
            members = given_in == system
            if system in systems and np.isnan(positions[members]).any():
                positions[members] = systems[system].basic(local[members])
        found = {
            system: resolved
            for system, (card, place) in waiting.items()
            if (resolved := _system(card, place, systems, ids, positions)) is not None
        }
        if not found:
            break
        systems |= found
        waiting = {system: card for system, card in waiting.items() if system not in found}
    for system, (card, _) in waiting.items():
        raise card.error(
            f"coordinate system {system} refers to a system or grid that the file does not define, or to "
            "itself; add the missing card"
        )
    return systems, positions


def _definitions(file: BulkFile) -> dict[int, tuple[BulkCard, int]]:
    """The card of each coordinate system, and its first field: a CORD1 card may define two systems."""
    found: dict[int, tuple[BulkCard, int]] = {}
    for card in file.named(*COORDINATE_CARDS):
        places = [0, 4] if card.name.startswith("CORD1") and card.word(4) else [0]
        for place in places:
            system = card.integer(place, "the id of the coordinate system")
            if system in found or system == 0:
                raise card.error(
                    f"coordinate system {system} is defined a second time; renumber or remove it"
                )
            found[system] = (card, place)
    return found


def _system(
    card: BulkCard,
    place: int,
    systems: dict[int, CoordinateSystem],
    ids: IntArray,
    positions: FloatArray,
) -> CoordinateSystem | None:
    """The coordinate system of a card; None while a system or grid that defines it is still unknown."""
    if card.name.startswith("CORD2"):
        reference = systems.get(card.integer(1, "the reference system", 0))
        if reference is None:
            return None
        points = reference.basic([card.reals(2 + 3 * i, *["a point"] * 3) for i in range(3)])
    else:
        wanted = np.array([card.integer(place + i, "a grid") for i in (1, 2, 3)])
        numbers, known = positions_of_ids(ids, wanted)
        points = positions[numbers]
        if not known.all() or np.isnan(points).any():
            return None
    made = through_points(_COORDINATES[card.name[-1]], *points)
    if made is None:
        raise card.error("its three points lie on one line; move one of them")
    return made
