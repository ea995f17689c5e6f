"""Decks on some of their nodes, for one part or one instance of an assembly, and in other node numbers."""

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

    def matrix(given: NodalMatrix) -> NodalMatrix | None:
        return given if len(given.freedoms) and points[given.freedoms // 6].all() else None

    def terms(given: ScalarTerms) -> ScalarTerms:
        rows = np.ones(len(given.lines), dtype=bool)
        rows[given.rows[~points[given.freedoms // 6]]] = False
        return kept_terms(given, rows)

    def inside(tie: RigidTie | WeightedMean) -> bool:
        return bool(own[tie.reference] and own[tie.nodes].all())

    node_sets = {name: of[own[of]] for name, of in deck.node_sets.items()}
    elements = (kept_elements(each, np.all(own[each.nodes], axis=1)) for each in deck.elements)
    kept = replace(
        deck.with_actions(matrix, terms),
        node_ids=deck.node_ids[own],
        nodes=deck.nodes[own],
        elements=tuple(each for each in elements if len(each.ids)),
        node_sets={name: nodes for name, nodes in node_sets.items() if len(nodes)},
        rigid=tuple(each for each in deck.rigid if inside(each)),
        means=tuple(each for each in deck.means if inside(each)),
    )
    return renumbered_deck(kept, np.cumsum(points) - 1)


def renumbered_deck(deck: Deck, number: IntArray) -> Deck:
    """The deck with the node or scalar point j numbered number[j], in all that refers to it."""

    def freedoms(given: IntArray) -> IntArray:
        return np.where(given < 0, given, 6 * number[given // 6] + given % 6)

    def matrix(given: NodalMatrix) -> NodalMatrix:
        return replace(given, freedoms=freedoms(given.freedoms))

    def terms(given: ScalarTerms) -> ScalarTerms:
        return replace(given, freedoms=freedoms(given.freedoms), dependent=freedoms(given.dependent))

    def tied(given: Tie) -> Tie:
        return replace(given, reference=int(number[given.reference]), nodes=number[given.nodes])

    return replace(
        deck.with_actions(matrix, terms),
        elements=tuple(replace(each, nodes=number[each.nodes]) for each in deck.elements),
        node_sets={name: number[nodes] for name, nodes in deck.node_sets.items()},
        rigid=tuple(tied(each) for each in deck.rigid),
        means=tuple(tied(each) for each in deck.means),
    )


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
