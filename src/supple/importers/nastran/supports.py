"""Supports and sets of a Nastran deck: SPC, SPC1, SPCADD, PS of GRID, ASET; and matrices by DMIG."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from supple.arrays import IntArray
from supple.errors import ImportFormatError
from supple.importers.deck import NodalMatrix
from supple.importers.nastran.bulk_data import BulkCard
from supple.importers.nastran.deck_reading import DeckReading
from supple.importers.nastran.retained_freedoms import retained_freedoms
from supple.importers.numbering import in_range, positions_of_ids
from supple.importers.plain_number import number_of_word

SUPPORT_CARDS = ("SPC", "SPC1", "SPCADD", "ASET", "ASET1", "DMIG")


def read_supports(reading: DeckReading, tied: Collection[int] = ()) -> dict[str, IntArray]:
    """Node sets `spcS_C` of support set S and components C, `spc_C` of PS fields, `aset`; each node once.

    Constraints of the selected set and of the PS fields are added to `reading.held`.

    tied : grids whose tied translations count as a tie of all six freedoms, since nothing acts on their
           rotations; supports of these rotations are ignored
    """
    found: dict[str, dict[int, None]] = {}
    cards = reading.file.named("SPC", "SPC1")
    chosen = reading.chosen_sets("SPC", "SPCADD", cards)
    held: dict[tuple[int, int], int] = {}
    for node, word in enumerate(reading.grids.supports.tolist()):
        if word and word != "0":
            card = reading.grids.cards[node]
            components = _components(card, word)
            found.setdefault(f"spc_{components}", {})[node] = None
            held |= {(node, int(c) - 1): card.line for c in components}
    for card in cards:
        number = card.integer(0, "the set id")
        points, grids = _supported(card, reading)
        for point in points if number in chosen else ():
            reading.held.add(reading.freedom(card, point, 1), card.line)
        for node, components in grids:
            found.setdefault(f"spc{number}_{components}", {})[node] = None
            if number in chosen:
                for component in components:
                    held.setdefault((node, int(component) - 1), card.line)
    try:
        physical = retained_freedoms(reading.file, reading.grids.ids, modal=False)
    except ImportFormatError as error:  # the analysis set does not change the body
        reading.note(f"The analysis set is not read: {error}")
        physical = None
    if physical is not None:
        ids = np.unique(physical[physical[:, 1] > 0, 0])
        found["aset"] = dict.fromkeys(reading.grids.lookup(ids)[0].tolist())
    for (node, component), line in held.items():
        if component > 2 and node in tied:
            continue
        reading.held.add(reading.node_freedom(node, component), line)
    return {name: np.array(list(nodes), dtype=np.int64) for name, nodes in found.items() if nodes}


def _supported(card: BulkCard, reading: DeckReading) -> tuple[list[int], list[tuple[int, str]]]:
    """Ids of the scalar points of an SPC or SPC1, and node and components of each of its grids.

    In an SPC1, G1 THRU G2 is all grids in the range, without components all scalar points. Other ids are
    ignored, with a note.
    """
    if card.name == "SPC1":
        word, listed = card.word(1), card.ranges(range(2, len(card.fields)), "a grid")
        between = np.sort(reading.scalar_points if word in ("", "0") else reading.grids.ids)
        inside = (each if len(each) == 1 else between[in_range(between, each)].tolist() for each in listed)
        given = [(number, word) for each in inside for number in each]
    else:
        if any(card.real(i + 2, "a displacement", 0.0) for i in (1, 4) if card.word(i)):
            reading.note("Enforced displacements of SPC are not read; their freedoms are fixed.")
        places = (i for i in range(1, len(card.fields), 3) if card.word(i) not in ("", "0"))
        given = [(card.integer(i, "a grid"), card.word(i + 1)) for i in places]
    ids = np.array([number for number, _ in given], dtype=np.int64)
    is_scalar = positions_of_ids(reading.scalar_points, ids)[1]
    nodes, known = reading.grids.lookup(ids)
    if not (known | is_scalar).all():
        reading.note(f"{card.name} cards name grids that the file does not define; these are ignored.")
    grids = np.flatnonzero(known & ~is_scalar).tolist()
    return ids[is_scalar].tolist(), [(int(nodes[i]), _components(card, given[i][1])) for i in grids]


def _components(card: BulkCard, word: str) -> str:
    word = "".join(c for c in word if c != "0")
    if len(set(word)) < len(word) or not set(word) <= set("123456"):
        raise card.error(f"components '{word}' are not some of 123456, each once; correct them")
    return "".join(sorted(word))


# --- DMIG that case control adds to the matrices of the elements


def read_matrices(reading: DeckReading) -> dict[str, list[NodalMatrix]]:
    """DMIG matrices by the command that adds them: K2GG stiffness, M2GG mass, B2GG damping."""
    found: dict[str, list[NodalMatrix]] = {"K2GG": [], "M2GG": [], "B2GG": []}
    cards: dict[str, list[BulkCard]] = {}
    for card in reading.file.named("DMIG"):
        cards.setdefault(card.word(0), []).append(card)
    sections = (reading.whole, *reading.whole.parts.values())
    anywhere = {card.word(0) for section in sections for card in section.named("DMIG")}
    used: set[str] = set()
    for command, matrices in found.items():
        for word in reading.case.chosen.get(command, "").replace("+", ",").split(","):
            factor, name = _scaled(word.strip())
            if name in cards:
                used.add(name)
                matrices.append(_matrix(cards[name], factor * reading.matrix_factors[command], reading))
            elif name and name not in anywhere:
                absent = BulkCard(command, (name,), reading.file.path, 0)
                reading.leave_out(absent, f"case control adds {name}, and the file has no such DMIG")
    for command in ("K2PP", "M2PP", "B2PP"):
        name = reading.case.chosen.get(command, "")
        if name in cards:
            used.add(name)
            reading.leave_out(cards[name][0], f"{command} = {name}, which direct solutions use, is not read")
    for name, unused in cards.items():
        if name not in used and not reading.case.present:
            use = f"add K2GG, M2GG or B2GG = {name}, or give matrices alone as a matrices body"
            reading.leave_out(unused[0], f"no case control states the use of the matrix {name}; {use}")
    return found


def _scaled(word: str) -> tuple[float, str]:
    factor, star, name = word.rpartition("*")
    try:
        return (number_of_word(factor) if star else 1.0), name.strip()
    except ValueError:
        return 1.0, word


def _matrix(cards: list[BulkCard], factor: float, reading: DeckReading) -> NodalMatrix:
    """The matrix of DMIG cards in basic axes, made symmetric; for IFO = 6 the file has one triangle of it."""
    headers = [card for card in cards if card.word(1) == "0"]
    if len(headers) != 1:
        raise cards[0].error(
            f"{len(headers)} header cards for {cards[0].word(0)}; a DMIG has one: give each matrix a name"
        )
    is_triangle, is_complex = headers[0].word(2) == "6", headers[0].word(3) in ("3", "4")
    entries: dict[tuple[int, int], float] = {}
    points: set[int] = set()
    has_imaginary = False
    given: set[tuple[tuple[tuple[int, float], ...], ...]] = set()
    for card in cards:
        if card.word(1) == "0":
            continue
        number = card.integer(1, "the grid of the column")
        column = tuple(reading.freedom(card, number, card.integer(2, "its component", 0)))
        points.add(number)
        for place in range(4, len(card.fields), 4):
            if card.is_blank(place, place + 3):
                continue
            number = card.integer(place, "a grid")
            row = tuple(reading.freedom(card, number, card.integer(place + 1, "a component", 0)))
            points.add(number)
            value = factor * card.real(place + 2, "an entry")
            has_imaginary |= is_complex and card.real(place + 3, "an imaginary part", 0.0) != 0.0
            is_beside = is_triangle and row != column
            if is_beside:
                given.add((row, column))
                if (column, row) in given:
                    raise card.error(
                        f"{card.word(0)} has form 6 (symmetric), which takes one triangle, but the entry of "
                        f"points {number} and {card.word(1)} is on both sides of its diagonal; remove one, "
                        "or give it form 1 (square)"
                    )
            for i, a in row:
                for j, b in column:
                    entries[i, j] = entries.get((i, j), 0.0) + a * b * value
                    if is_beside:
                        entries[j, i] = entries.get((j, i), 0.0) + a * b * value
    if has_imaginary:
        reading.leave_out(
            headers[0],
            f"{cards[0].word(0)} is complex: its imaginary part (structural damping) is not read",
        )
    scalar = {point for point in points if reading.is_scalar(point)}
    if scalar and scalar != points:
        reading.leave_out(
            cards[0],
            f"{cards[0].word(0)} also acts on scalar points, which a free body omits: the matrix is omitted "
            "with them",
        )
    freedoms, places = np.unique(np.array(list(entries), dtype=np.int64), return_inverse=True)
    places = places.reshape(-1, 2)
    values = np.zeros((len(freedoms), len(freedoms)))
    np.add.at(values, (places[:, 0], places[:, 1]), list(entries.values()))
    return NodalMatrix(freedoms, (values + values.T) / 2)
