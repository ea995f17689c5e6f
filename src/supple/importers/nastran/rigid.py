"""Ties of a Nastran deck: RBE1, RBE2, RBE3, RBAR, RBAR1, RROD, RTRPLT and MPC."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain

import numpy as np

from supple.arrays import BoolArray, FloatArray
from supple.importers.deck import RigidTie, WeightedMean
from supple.importers.freedom_sums import Terms, relative_motion
from supple.importers.nastran.bulk_data import BulkCard, by_id
from supple.importers.nastran.deck_reading import DeckReading, times
from supple.importers.numbering import in_range

RIGID_CARDS = ("RBE2", "RBE3", "RBE1", "RBAR", "RBAR1", "RROD", "RTRPLT", "MPC", "MPCADD")

# A node, and which of its six components: one side of a tie.
Side = tuple[int, str]


def read_ties(reading: DeckReading, turning: BoolArray) -> tuple[list[RigidTie], list[WeightedMean]]:
    """Full rigid ties and plain means of translations; other elements are added to `reading.constraints`.

    turning : (N,) whether anything but supports acts on the rotations of a grid; if not, as on nodes of
              solids, a tie of its translations is equivalent to a tie of all six freedoms
    """
    rigid: list[RigidTie] = []
    means: list[WeightedMean] = []
    cards = reading.file.named(*(name for name in RIGID_CARDS if name[0] == "R"))
    for card in by_id(cards, "element").values():
        match card.name:
            case "RBE2":
                _rbe2(card, reading, turning, rigid)
            case "RBE3":
                _rbe3(card, reading, turning, means)
            case "RBAR" | "RBAR1":
                _rbar(card, reading, rigid)
            case "RROD":
                _rrod(card, reading)
            case "RTRPLT":
                _rtrplt(card, reading, rigid)
            case _:
                _rigid_rows(card, *_rbe1_sides(card, reading), reading)
    return rigid, means


def turned_by_ties(reading: DeckReading) -> BoolArray:
    """Mask (N,) of the grids whose rotations a tie uses; an RBE3 uses no rotations of its averaged grids."""
    found = np.zeros(len(reading.grids.ids), dtype=bool)

    def mark(ids: list[int]) -> None:
        numbers, known = reading.grids.lookup(np.array(ids, dtype=np.int64))
        found[numbers[known]] = True

    def turns(word: str) -> bool:
        return bool(set(word) & set("456"))

    for card in reading.file.named("RBE2"):
        mark([card.integer(1, "the grid GN")])
        if turns(card.word(2)):
            found[_grid_list(card, _listed_grids(card), reading)] = True
    for card in reading.file.named("RBE3"):
        if turns(card.word(3)):
            mark([card.integer(2, "the reference grid")])
    for card in reading.file.named("RBAR", "RBAR1"):
        mark([card.integer(1, "the grid GA"), card.integer(2, "the grid GB")])
    for card in reading.file.named("RTRPLT"):
        mark([card.integer(1 + i, "a grid") for i in range(3)])
    for card in reading.file.named("RBE1"):
        for node, components in chain(*_rbe1_sides(card, reading)):
            found[node] |= turns(components)
    return found


def _components(card: BulkCard, word: str, what: str) -> str:
    if not word or len(set(word)) < len(word) or not set(word) <= set("123456"):
        raise card.error(f"{what} are '{word}', not some of 123456, each once; correct them")
    return "".join(sorted(word))


def _some_components(card: BulkCard, place: int) -> str:
    """Components of a field; none if it is blank or 0."""
    word = card.word(place)
    return "" if word in ("", "0") else _components(card, word, "its components")


def _grid_list(card: BulkCard, places: Iterable[int], reading: DeckReading) -> list[int]:
    """Numbers from 0 of the grids in a list of fields; of A THRU B, A is a grid, other ids need not be."""
    ids: list[int] = []
    for listed in card.ranges(places, "a grid"):
        known = reading.grids.ids
        ids += [listed.start, *np.sort(known[in_range(known, listed[1:])]).tolist()]
    return reading.grids.numbers(card, ids).tolist() if ids else []


def _rbe2(card: BulkCard, reading: DeckReading, turning: BoolArray, rigid: list[RigidTie]) -> None:
    """EID GN CM GM1 .. [ALPHA]: components CM of GM1 .. follow GN rigidly, in the axes CD of each GM."""
    ties = _components(card, card.word(2), "its components")
    reference = reading.node(card, 1, "the grid GN")
    listed = _grid_list(card, _listed_grids(card), reading)
    nodes = [node for node in dict.fromkeys(listed) if node != reference]
    if not nodes:
        reading.leave_out(card, "ties no grids")
        return
    if ties == "123456" or (ties == "123" and not turning[nodes].any()):
        rigid.append(RigidTie(f"rbe2_{card.word(0)}", reference, np.array(nodes, dtype=np.int64), card.line))
        return
    for node in nodes:
        for component in ties:
            _follows(card, node, int(component) - 1, reference, reading)


def _listed_grids(card: BulkCard) -> list[int]:
    """Indices of the fields GM of an RBE2; ALPHA and TREF, which are thermal, are skipped."""
    return [i for i in range(3, len(card.fields)) if "." not in card.word(i)]


def _follows(card: BulkCard, node: int, component: int, reference: int, reading: DeckReading) -> None:
    """Add the constraint that a component of a node follows the rigid motion of the reference node."""
    grids, turns = reading.grids, component > 2
    arm = grids.positions[node] - grids.positions[reference]
    terms = relative_motion(node, reference, grids.axes[node][:, component % 3], arm=arm, rotation=turns)
    own = reading.node_freedom(node, component)
    reading.constraints.add(terms, card.line, dependent=_alone(own))


def _alone(terms: Terms) -> int:
    """The freedom of a component with the given terms if its axis is a basic axis; else -1."""
    return terms[0][0] if len(terms) == 1 else -1


def _rigid_motions(
    sides: Sequence[Side], origin: FloatArray, reading: DeckReading
) -> tuple[FloatArray, list[Terms]]:
    """Directions and moments about the origin of the components of some sides (k, 6), and their terms."""
    T, own = [], []
    for node, components in sides:
        arm = reading.grids.positions[node] - origin
        for component in (int(c) - 1 for c in components):
            e = reading.grids.axes[node][:, component % 3]
            T.append([*e, *np.cross(arm, e)] if component < 3 else [0.0, 0.0, 0.0, *e])
            own.append(reading.node_freedom(node, component))
    return np.array(T), own


def _rigid_rows(
    card: BulkCard, independent: Iterable[Side], dependent: Iterable[Side], reading: DeckReading
) -> None:
    """Add constraints: dependent components follow the rigid motion that six independent ones determine.

    The motion q (6,) of the rigid body follows from the independent components,  u_I = T_I q,  so that the
    dependent ones are  u_M = T_M T_I^-1 u_I.  A row of T is the direction of a component and its moment about
    the first independent node.
    """
    independent, dependent = ([side for side in sides if side[1]] for sides in (independent, dependent))
    if not independent or not dependent:
        reading.leave_out(card, "left out: it has no independent, or no dependent components")
        return
    origin = reading.grids.positions[independent[0][0]]
    T_I, u_I = _rigid_motions(independent, origin, reading)
    # The negated comparison is also true for NaN.
    if T_I.shape != (6, 6) or not abs(np.linalg.det(T_I)) > 1e-12 * np.prod(np.linalg.norm(T_I, axis=1)):
        reading.leave_out(card, "left out: its independent components do not determine a rigid motion")
        return
    T_M, u_M = _rigid_motions(dependent, origin, reading)
    weights = T_M @ np.linalg.inv(T_I)
    for own, row in zip(u_M, weights, strict=True):
        _follow_sum(card, own, row, u_I, 1e-12, reading)


def _follow_sum(
    card: BulkCard, own: Terms, row: FloatArray, terms: Sequence[Terms], least: float, reading: DeckReading
) -> None:
    """Add the constraint  own = row . terms,  without factors below `least` of the largest one."""
    found = list(own)
    for factor, term in zip(row, terms, strict=True):
        if abs(factor) > least * np.abs(row).max():
            found += times(term, -float(factor))
    reading.constraints.add(found, card.line, dependent=_alone(own))


def _rest(components: str) -> str:
    return "".join(c for c in "123456" if c not in components)


def _rbar(card: BulkCard, reading: DeckReading, rigid: list[RigidTie]) -> None:
    """RBAR: EID GA GB CNA CNB CMA CMB; RBAR1: EID GA GB CB, all of GA independent."""
    a, b = reading.node(card, 1, "the grid GA"), reading.node(card, 2, "the grid GB")
    if card.name == "RBAR1":
        cna, cnb, cma, cmb = "123456", "", "", _some_components(card, 3) or "123456"
    else:
        cna, cnb, cma, cmb = (_some_components(card, i) for i in (3, 4, 5, 6))
        if not cma and not cmb:
            cma, cmb = _rest(cna), _rest(cnb)
    name = f"rbar_{card.word(0)}"
    for reference, own, node, ties in ((a, cna, b, cmb), (b, cnb, a, cma)):
        if sorted(own) == list("123456") == sorted(ties):
            rigid.append(RigidTie(name, reference, np.array([node]), card.line))
            return
    _rigid_rows(card, [(a, cna), (b, cnb)], [(a, cma), (b, cmb)], reading)


def _rrod(card: BulkCard, reading: DeckReading) -> None:
    """EID GA GB CMA CMB: two grids at a constant distance."""
    a, b = reading.node(card, 1, "the grid GA"), reading.node(card, 2, "the grid GB")
    chord = reading.grids.positions[b] - reading.grids.positions[a]
    length = np.linalg.norm(chord)
    if not length > 0:
        raise card.error("its two grids coincide; move one, or remove it")
    terms = relative_motion(b, a, chord / length)
    node, component = (a, card.word(3)) if card.word(3) else (b, card.word(4))
    own = reading.node_freedom(node, int(component) - 1) if component in ("1", "2", "3") else []
    reading.constraints.add(terms, card.line, dependent=_alone(own))


def _rtrplt(card: BulkCard, reading: DeckReading, rigid: list[RigidTie]) -> None:
    """EID GA GB GC CNA CNB CNC - CMA CMB CMC: a rigid triangle."""
    nodes = [reading.node(card, 1 + i, "a grid") for i in range(3)]
    own = [_some_components(card, 4 + i) for i in range(3)]
    ties = [_some_components(card, 8 + i) for i in range(3)]
    if not any(ties):
        ties = [_rest(c) for c in own]
    if sorted(own[0]) == list("123456") and all(sorted(c) == list("123456") for c in ties[1:]):
        rigid.append(RigidTie(f"rtrplt_{card.word(0)}", nodes[0], np.array(nodes[1:]), card.line))
        return
    _rigid_rows(card, zip(nodes, own, strict=True), zip(nodes, ties, strict=True), reading)


def _rbe1_sides(card: BulkCard, reading: DeckReading) -> tuple[list[Side], list[Side]]:
    """EID GN1 CN1 .. GN6 CN6, then UM GM1 CM1 .. [ALPHA]: independent and dependent components."""
    independent: list[Side] = []
    dependent: list[Side] = []
    sides = independent
    place = 1
    while place < len(card.fields):
        word = card.word(place)
        if word == "UM":
            sides, place = dependent, place + 1
            continue
        if not word or "." in word:  # an empty field, or ALPHA
            place += 1
            continue
        node = reading.node(card, place, "a grid")
        sides.append((node, _components(card, card.word(place + 1), f"the components of grid {word}")))
        place += 2
    return independent, dependent


def _rbe3(card: BulkCard, reading: DeckReading, turning: BoolArray, means: list[WeightedMean]) -> None:
    """EID - REFGRID REFC WT1 C1 G1,1 G1,2 .. WT2 C2 G2,1 .. [UM ..] [ALPHA ..].

    UM is not used: it selects the dependent freedoms, and does not change the equations.
    """
    reference = reading.node(card, 2, "the reference grid")
    follows = _components(card, card.word(3), "the components of its reference grid")
    groups = _weighted(card, reading)
    if not groups:
        reading.leave_out(card, "averages no grids")
        return
    plain = all(
        components == "123" or (components == "123456" and not turning[nodes].any())
        for _, components, nodes in groups
    )
    if plain and not reading.has_local_axes(reference, follows):
        weights: dict[int, float] = {}
        for weight, _, members in groups:
            for node in members:
                weights[node] = weights.get(node, 0.0) + weight
        means.append(
            WeightedMean(
                f"rbe3_{card.word(0)}",
                reference,
                np.array(list(weights), dtype=np.int64),
                np.array(list(weights.values())),
                card.line,
                tuple(str(i) in follows for i in range(1, 7)),
            )
        )
        return
    _mean_rows(card, reference, follows, groups, reading)


def _weighted(card: BulkCard, reading: DeckReading) -> list[tuple[float, str, list[int]]]:
    """Weight, components and grids of each group of an RBE3."""
    found: list[tuple[float, str, list[int]]] = []
    place = 4
    while place < len(card.fields):
        word = card.word(place)
        if word in ("UM", "ALPHA"):
            break
        if not word:
            place += 1
            continue
        weight = card.real(place, "a weight")
        if "." not in word and "E" not in word and "+" not in word[1:]:
            raise card.error(f"'{word}' stands where a weight is expected; weights are written with a point")
        components = _components(card, card.word(place + 1), "components that it averages")
        place += 2
        first = place
        while place < len(card.fields) and (card.word(place) in ("", "THRU") or card.word(place).isdecimal()):
            place += 1
        nodes = _grid_list(card, range(first, place), reading)
        if weight > 0 and nodes:
            found.append((weight, components, nodes))
    return found


def _mean_rows(
    card: BulkCard,
    reference: int,
    follows: str,
    groups: list[tuple[float, str, list[int]]],
    reading: DeckReading,
) -> None:
    """Add constraints: the reference grid follows the least-squares rigid motion of averaged components.

        u_ref = (S^T W S)^-1 S^T W u,   u averaged components, S rigid motions about the reference, W weights;

    rotations have the weight L^2, with L the mean distance of the grids from the reference; the constraints
    are then independent of units.
    Source: MSC Nastran, Linear Static Analysis User's Guide, "RBE3".
    """
    origin = reading.grids.positions[reference]
    nodes = [node for _, _, members in groups for node in members]
    L = float(np.linalg.norm(reading.grids.positions[nodes] - origin, axis=1).mean()) or 1.0
    sides = [(node, components) for _, components, members in groups for node in members]
    S, own = _rigid_motions(sides, origin, reading)
    W = np.array(
        [
            w * (1.0 if c in "123" else L**2)
            for w, components, members in groups
            for _ in members
            for c in components
        ]
    )
    scale = np.array([1.0, 1.0, 1.0, L, L, L])
    normal = (S / scale).T @ (W[:, None] * S / scale)
    if (
        not np.isfinite(normal).all()
        or np.linalg.matrix_rank(normal, tol=1e-10 * np.abs(normal).max(), hermitian=True) < 6
    ):
        reading.leave_out(card, "left out: the components it averages do not determine a rigid motion")
        return
    mean = np.linalg.solve(normal, (S / scale).T * W) / scale[:, None]
    for component in (int(c) - 1 for c in follows):
        e = reading.grids.axes[reference][:, component % 3]
        row = e @ mean[3 * (component // 3) : 3 * (component // 3) + 3]
        _follow_sum(card, reading.node_freedom(reference, component), row, own, 1e-13, reading)


def read_multipoint_constraints(reading: DeckReading) -> None:
    """Add the constraints of the MPC cards in the sets of `DeckReading.chosen_sets`."""
    cards = reading.file.named("MPC")
    chosen = reading.chosen_sets("MPC", "MPCADD", cards)
    for card in (each for each in cards if each.integer(0, "the set id") in chosen):
        terms: Terms = []
        dependent = -1
        # A row of eight fields has two terms G C A, which start in its second and fifth field.
        for place in range(1, len(card.fields)):
            at = place % 8
            if at not in (1, 4) or not card.word(place):
                continue
            factor = card.real(place + 2, "a factor", 0.0)
            of = reading.freedom(
                card, card.integer(place, "a grid"), card.integer(place + 1, "a component", 0)
            )
            if not terms:
                dependent = _alone(of)
            terms += times(of, factor)
        if terms:
            reading.constraints.add(terms, card.line, dependent=dependent)
