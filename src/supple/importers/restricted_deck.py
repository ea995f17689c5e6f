"""Restriction of a deck to some of its nodes, for one part or one instance of an assembly."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from supple.arrays import BoolArray, IntArray
from supple.importers.deck import Deck, DeckElements, NodalMatrix, RigidTie, ScalarTerms, WeightedMean

Tie = TypeVar("Tie", RigidTie, WeightedMean)


def restricted_deck(deck: Deck, own: BoolArray) -> Deck:
    """The deck on the nodes of the mask `own` (N,); properties and element sets are unchanged.

    Cells, matrices, rows and ties with other nodes are removed, and so are other nodes of node sets. Scalar
    points stay.
    """
    if own.all():
        return deck
    points = np.append(own, np.ones(len(deck.scalar_points), dtype=bool))
    number = np.cumsum(points) - 1

    def matrix(given: NodalMatrix) -> NodalMatrix | None:
        if not len(given.freedoms) or not points[given.freedoms // 6].all():
            return None
        return replace(given, freedoms=_renumbered(given.freedoms, number))

    node_sets = {name: number[of[own[of]]] for name, of in deck.node_sets.items()}
    elements = (_elements(each, own, number) for each in deck.elements)
    return replace(
        deck.with_actions(matrix, lambda each: _terms(each, points, number)),
        node_ids=deck.node_ids[own],
        nodes=deck.nodes[own],
        elements=tuple(each for each in elements if len(each.ids)),
        node_sets={name: nodes for name, nodes in node_sets.items() if len(nodes)},
        rigid=tuple(_tie(each, number) for each in deck.rigid if _inside(each, own)),
        means=tuple(_tie(each, number) for each in deck.means if _inside(each, own)),
    )


def _inside(tie: RigidTie | WeightedMean, own: BoolArray) -> bool:
    return bool(own[tie.reference] and own[tie.nodes].all())


def _tie(tie: Tie, number: IntArray) -> Tie:
    return replace(tie, reference=int(number[tie.reference]), nodes=number[tie.nodes])


def _renumbered(freedoms: IntArray, number: IntArray) -> IntArray:
    return 6 * number[freedoms // 6] + freedoms % 6


def _elements(given: DeckElements, own: BoolArray, number: IntArray) -> DeckElements:
    kept = kept_elements(given, np.all(own[given.nodes], axis=1))
    return replace(kept, nodes=number[kept.nodes])


def kept_elements(given: DeckElements, own: BoolArray) -> DeckElements:
    """The cells where `own` (C,) is true."""
    arrays = ("nodes", "ids", "lines", "directions", "offsets", "released", "mass_share")
    values = {name: getattr(given, name) for name in arrays}
    return replace(given, **{name: None if array is None else array[own] for name, array in values.items()})


def kept_terms(given: ScalarTerms, own: BoolArray) -> ScalarTerms:
    """The rows where `own` (rows,) is true."""
    kept, count = own[given.rows], np.cumsum(own) - 1
    return ScalarTerms(
        rows=count[given.rows[kept]],
        freedoms=given.freedoms[kept],
        factors=given.factors[kept],
        lines=given.lines[own],
        values=given.values[own] if len(given.values) else given.values,
        dependent=given.dependent[own] if len(given.dependent) else given.dependent,
    )


def _terms(given: ScalarTerms, own: BoolArray, number: IntArray) -> ScalarTerms:
    """The rows whose freedoms all belong to points of the mask `own`, with point numbers `number`."""
    rows = np.ones(len(given.lines), dtype=bool)
    rows[given.rows[~own[given.freedoms // 6]]] = False
    kept = kept_terms(given, rows)
    dependent = np.where(
        kept.dependent < 0, kept.dependent, _renumbered(np.maximum(kept.dependent, 0), number)
    )
    return replace(kept, freedoms=_renumbered(kept.freedoms, number), dependent=dependent)


def used_nodes(deck: Deck) -> BoolArray:
    """Mask (N,) of the nodes that cells, matrices, rows or ties use."""
    terms = (*deck.springs, *deck.dashpots, *deck.inertias, *deck.constraints, *deck.held)
    matrices = (*deck.masses, *deck.stiffnesses, *deck.dampings)
    named = [
        np.empty(0, dtype=np.int64),
        *(each.nodes.ravel() for each in deck.elements),
        *(each.freedoms // 6 for each in (*terms, *matrices)),
        *(np.append(each.nodes, each.reference) for each in (*deck.rigid, *deck.means)),
    ]
    numbers = np.concatenate(named)
    used = np.zeros(len(deck.nodes), dtype=bool)
    used[numbers[numbers < len(used)]] = True
    return used
