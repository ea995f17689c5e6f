"""Superelements of a Nastran file: parts after BEGIN SUPER, placed and joined."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from supple.arrays import FloatArray, IntArray
from supple.importers.deck import Deck, LeftOut
from supple.importers.merged_decks import CommonNodes, merged_decks
from supple.importers.moved_deck import moved_deck
from supple.importers.nastran.bulk_data import BulkCard, BulkFile
from supple.importers.nastran.grids import GridPoints
from supple.importers.numbering import in_range, positions_of_ids
from supple.importers.restricted_deck import used_nodes

SUPERELEMENT_CARDS = ("SEBULK", "SELOC", "SEMPLN", "SECONCT", "SEBNDRY", "SEEXCLD")

# Nastran's tolerance for common grids of two superelements, in the unit of the file.
_TOLERANCE = 1e-5
# Largest misfit of the three grids that place a superelement, relative to their extent; a larger one is
# reported. Nastran requires equality.
_EQUAL = 1e-2

_IMAGES = ("MIRROR", "REPEAT", "IDENTICAL")
# The squares of larger coordinates overflow; the mesh rejects such coordinates.
_FARTHEST = 1e100

_ELSEWHERE = ("EXTERNAL", "EXTOP2", "EXTOP4", "FRFOP2")


def superelement_name(number: int) -> str:
    """Name of a superelement; 0 is the residual structure, the main bulk data."""
    return f"super_{number}"


def assembled(main: Deck, parts: Mapping[int, Deck], file: BulkFile, grids: GridPoints) -> Deck:
    """The deck of a file with its parts joined at common grids; each part is also a deck in `superelements`.

    main : the residual structure;  parts : {number: deck};  grids : those of the main bulk data
    """
    left: list[LeftOut] = []
    decks = {0: main, **_images(parts, file, left)}
    placed = {n: _placed(deck, n, file, grids, left) for n, deck in decks.items()}
    tolerance = {
        card.integer(0, "the superelement"): card.real(4, "the tolerance", _TOLERANCE)
        for card in file.named("SEBULK")
    }
    common = _by_place(placed, tolerance, file, left) + _by_hand(placed, tolerance, file, left)
    lumped = {deck.lumped_mass for n, deck in placed.items() if n or deck.elements}
    if len(lumped) > 1:
        left.append(LeftOut("PARAM", 1, 0, "COUPMASS of some superelements: the mass of all is lumped"))
    named = {superelement_name(n): deck for n, deck in placed.items()}
    merged = merged_decks(named, common)
    own = {name: deck for name, deck in merged.superelements.items() if used_nodes(deck).any()}
    return replace(
        merged,
        superelements=own,
        left_out=(*merged.left_out, *left),
        lumped_mass=True in lumped,
    )


def repeated_parts(file: BulkFile) -> set[int]:
    """Numbers of superelements that repeat another one and need no grids of their own."""
    return {card.integer(0, "the superelement") for card in file.named("SEBULK") if card.word(1) in _IMAGES}


def _images(parts: Mapping[int, Deck], file: BulkFile, left: list[LeftOut]) -> dict[int, Deck]:
    """The parts, and copies for repetitions and mirror images (SEBULK), not yet mirrored.

    Superelements in other files are omitted, with a record in `left`.
    """
    found = dict(parts)
    for card in file.named("SEBULK"):
        number, kind = card.integer(0, "the superelement"), card.word(1)
        if kind in _ELSEWHERE:
            found.pop(number, None)
            left.append(_lost(card, f"superelement {number} is in another file ({kind}), which is not read"))
        elif kind in _IMAGES:
            of = card.integer(2, "the superelement that it repeats")
            if of not in parts:
                raise card.error(f"repeats superelement {of}, which the file does not define; add it")
            found[number] = replace(parts[of], read={}, passed_over={}, left_out=())
        elif number and number not in parts and kind in ("", "PRIMARY"):
            raise card.error(f"names superelement {number}, which the file does not define; add it")
    return found


def _placed(deck: Deck, number: int, file: BulkFile, grids: GridPoints, left: list[LeftOut]) -> Deck:
    """A superelement mirrored by SEMPLN if it is a mirror image, then placed by SELOC."""
    mirrored = [card for card in _of(file, "SEBULK", number) if card.word(1) == "MIRROR"]
    for card in mirrored:
        planes = _of(file, "SEMPLN", number)
        if not planes:
            raise card.error(
                f"superelement {number} is a mirror image, and no SEMPLN gives its plane; add one"
            )
        a, b, c = _main_points(planes[0], (2, 3, 4), file, grids)
        normal = np.cross(b - a, c - a)
        if not np.linalg.norm(normal) > 0:
            raise planes[0].error("its three points lie on one line; move one of them")
        n = normal / np.linalg.norm(normal)
        deck = moved_deck(deck, np.eye(3) - 2 * np.outer(n, n), 2 * (a @ n) * n)
    for card in _of(file, "SELOC", number):
        ids = np.array([card.integer(i, "a grid of the superelement") for i in (1, 2, 3)])
        own = deck.nodes[_numbers(deck, ids, card, number)]
        given = _main_points(card, (4, 5, 6), file, grids)
        (R, first), (S, second) = _triad(own, card), _triad(given, card)
        Q = S @ R.T
        lost = np.linalg.norm((own - first) @ Q.T + second - given, axis=1).max()
        if lost > _EQUAL * np.ptp(given, axis=0).max():
            left.append(
                _lost(
                    card,
                    f"the triangles of its grids differ by {lost:.3g}; the first grid and side are matched",
                )
            )
        deck = moved_deck(deck, Q, second - Q @ first)
    return deck


def _of(file: BulkFile, name: str, number: int) -> list[BulkCard]:
    return [card for card in file.named(name) if card.integer(0, "the superelement") == number]


def _triad(points: FloatArray, card: BulkCard) -> tuple[FloatArray, FloatArray]:
    """Axes as columns, x from the first to the second point, third point in plane xy; and the first point."""
    x, y = points[1] - points[0], points[2] - points[0]
    z = np.cross(x, y)
    if not np.linalg.norm(z) > 0:
        raise card.error("three of its grids lie on one line; take others")
    y = np.cross(z, x)
    return np.column_stack([each / np.linalg.norm(each) for each in (x, y, z)]), points[0]


def _main_points(card: BulkCard, places: Iterable[int], file: BulkFile, grids: GridPoints) -> FloatArray:
    """Positions of grids and points of the main bulk data on a card."""
    found = []
    for place in places:
        number = card.integer(place, "a grid of the main bulk data")
        at, known = grids.lookup(np.array([number]))
        points = [c for c in file.named("POINT") if c.integer(0, "the id of the point") == number]
        if known[0]:
            found.append(grids.positions[at[0]])
        elif points:
            own = points[0].integer(1, "the coordinate system CP", 0)
            if own not in grids.systems:
                raise points[0].error(
                    f"names coordinate system {own}, which the file does not define; add it"
                )
            local = [points[0].reals(2, *(f"coordinate X{i}" for i in (1, 2, 3)))]
            found.append(grids.systems[own].basic(local)[0])
        else:
            raise card.error(f"names grid {number}, which the main bulk data do not define; add it")
    return np.array(found)


def _numbers(deck: Deck, ids: IntArray, card: BulkCard, number: int) -> IntArray:
    at, known = positions_of_ids(deck.node_ids, ids)
    if not known.all():
        raise card.error(
            f"names grid {ids[~known][0]} of superelement {number}, which does not define it; correct the id"
        )
    return at


def _by_place(
    decks: Mapping[int, Deck], tolerances: Mapping[int, float], file: BulkFile, left: list[LeftOut]
) -> list[CommonNodes]:
    """Coincident grids of each two superelements, without superelements that are joined manually (METHOD)."""
    method = {card.integer(0, "the superelement"): card.word(3) for card in file.named("SEBULK")}
    numbers = [n for n in decks if method.get(n) != "MANUAL" and len(decks[n].nodes)]
    used = {n: np.flatnonzero(used_nodes(decks[n])) for n in numbers}
    found = []
    for k, a in enumerate(numbers):
        for b in numbers[k + 1 :]:
            tolerance = max(tolerances.get(n, _TOLERANCE) for n in (a, b))
            nodes = [_boundary(decks[n], used[n], n, other, file) for n, other in ((a, b), (b, a))]
            pairs = _pairs(decks[a].nodes[nodes[0]], decks[b].nodes[nodes[1]], tolerance)
            single = [np.bincount(side, minlength=1)[side] == 1 for side in pairs.T]
            clear = single[0] & single[1]
            if not clear.all():
                at = decks[a].node_ids[nodes[0][pairs[~clear][0, 0]]]
                names = f"{superelement_name(a)} and {superelement_name(b)}"
                left.append(
                    LeftOut(
                        "BEGIN SUPER",
                        int((~clear).sum()),
                        0,
                        f"grid {at} of {names} has several coincident partners: such grids are not joined; "
                        "SECONCT may join them",
                    )
                )
            if clear.any():
                own = pairs[clear]
                names = superelement_name(a), superelement_name(b)
                found.append(CommonNodes(*names, nodes[0][own[:, 0]], nodes[1][own[:, 1]]))
    return found


def _boundary(deck: Deck, used: IntArray, number: int, other: int, file: BulkFile) -> IntArray:
    """Used nodes that may be common with another superelement: all or those of SEBNDRY, without SEEXCLD."""
    listed = [_listed(card, deck) for card in _between(file, "SEBNDRY", number, other)]
    excluded = [_listed(card, deck) for card in _between(file, "SEEXCLD", number, other)]
    nodes = np.intersect1d(used, np.concatenate(listed)) if listed else used
    return np.setdiff1d(nodes, np.concatenate(excluded)) if excluded else nodes


def _between(file: BulkFile, name: str, number: int, other: int) -> list[BulkCard]:
    """Cards SEIDA SEIDB|ALL G1 .. of a superelement that refer to another one."""
    return [card for card in _of(file, name, number) if card.word(1) in ("ALL", str(other))]


def _listed(card: BulkCard, deck: Deck) -> IntArray:
    """Numbers from 0 of grids in a list from the third field on, which may contain THRU or be ALL."""
    if card.word(2) == "ALL":
        return np.arange(len(deck.nodes))
    listed = card.ranges(range(2, len(card.fields)), "a grid")
    found = [np.flatnonzero(in_range(deck.node_ids, each)) for each in listed]
    return np.concatenate([np.empty(0, dtype=np.int64), *found])


def _pairs(first: FloatArray, second: FloatArray, tolerance: float) -> IntArray:
    """Numbers (k, 2) of a first and a second point that are at most `tolerance` apart."""
    a, b = (np.flatnonzero((np.abs(x) < _FARTHEST).all(axis=1)) for x in (first, second))
    near = KDTree(first[a]).sparse_distance_matrix(KDTree(second[b]), tolerance, output_type="coo_matrix")
    return np.column_stack([a[near.row], b[near.col]])


def _by_hand(
    decks: Mapping[int, Deck], tolerances: Mapping[int, float], file: BulkFile, left: list[LeftOut]
) -> list[CommonNodes]:
    """SECONCT: SEIDA SEIDB TOL LOC, and pairs of grids on its further rows."""
    found = []
    for card in file.named("SECONCT"):
        a, b = (card.integer(i, "a superelement") for i in (0, 1))
        missing = [n for n in (a, b) if n not in decks]
        if missing:
            raise card.error(f"names superelement {missing[0]}, which the file does not define; add it")
        default = max(tolerances.get(n, _TOLERANCE) for n in (a, b))
        tolerance = card.real(2, "the tolerance", default)
        ids = _connected(card)
        one, other = (_numbers(decks[n], of, card, n) for n, of in ((a, ids[:, 0]), (b, ids[:, 1])))
        distance = np.linalg.norm(decks[a].nodes[one] - decks[b].nodes[other], axis=1)
        apart = distance > tolerance
        if apart.any():
            far = int(np.argmax(distance))
            left.append(
                _lost(
                    card,
                    f"grids {ids[far, 0]} and {ids[far, 1]} lie {distance[far]:.3g} apart, more than "
                    f"{tolerance:.3g}: such grids are not joined",
                )
            )
        names = superelement_name(a), superelement_name(b)
        found.append(CommonNodes(*names, one[~apart], other[~apart]))
    return found


def _connected(card: BulkCard) -> IntArray:
    """Pairs (k, 2) of ids: GIDA1 GIDB1 .., or GIDA1 THRU GIDA2 GIDB1 THRU GIDB2."""
    places = [i for i in range(8, len(card.fields)) if card.word(i)]
    if any(card.word(i) == "THRU" for i in places):
        if len(places) != 6 or any(card.word(places[i]) != "THRU" for i in (1, 4)):
            raise card.error("a range of pairs reads GIDA1 THRU GIDA2 GIDB1 THRU GIDB2; correct it")
        a, b, c, d = (card.integer(places[i], "a grid") for i in (0, 2, 3, 5))
        if b - a != d - c or not 0 <= b - a < 10**6:
            raise card.error(f"{a} to {b} and {c} to {d} are ranges of different length; correct them")
        return np.column_stack([np.arange(a, b + 1), np.arange(c, d + 1)])
    if len(places) % 2:
        raise card.error("lists an odd number of grids; give pairs")
    ids = [card.integer(i, "a grid") for i in places]
    return np.array(ids, dtype=np.int64).reshape(-1, 2)


def _lost(card: BulkCard, meaning: str) -> LeftOut:
    return LeftOut(card.name, 1, card.line, meaning)
