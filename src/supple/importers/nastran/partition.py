"""Superelements within one bulk data section: SESET, SEELT and the SEID of GRID."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from supple.arrays import BoolArray, IntArray
from supple.importers.deck import Deck, NodalMatrix, RigidTie, ScalarTerms, WeightedMean
from supple.importers.nastran.bulk_data import BulkCard, integer_column
from supple.importers.nastran.deck_reading import DeckReading
from supple.importers.nastran.superelements import superelement_name
from supple.importers.numbering import in_range
from supple.importers.restricted_deck import kept_elements, kept_terms, restricted_deck, used_nodes

PARTITION_CARDS = ("SESET", "SEELT")


def partitioned(deck: Deck, reading: DeckReading) -> Deck:
    """The deck with an element set, a node set and an entry of `superelements` for each superelement.

    An element, matrix, linear combination or tie belongs to the superelement of its interior grids, or to the
    one with the lowest number if there are several. Without interior grids it belongs to the residual
    structure, number 0. For elements, SEELT overrides these rules. A deck without superelements is unchanged.
    """
    interior = _interior(deck, reading)
    numbers = [n for n in np.unique(interior).tolist() if n]
    if not numbers:
        return deck
    owners = [_owners(interior, each.nodes) for each in deck.elements]
    for card in reading.file.named("SEELT"):
        number = card.integer(0, "the superelement")
        for each, owner in zip(deck.elements, owners, strict=True):
            owner[_listed(card, each.ids)] = number
    owner_of_point = np.append(interior, np.zeros(len(deck.scalar_points), dtype=np.int64))
    found = {number: _part(deck, owner_of_point, owners, number) for number in (0, *numbers)}
    none = np.empty(0, dtype=np.int64)
    elements = {
        superelement_name(n): np.unique(np.concatenate([none, *(each.ids for each in part.elements)]))
        for n, part in found.items()
    }
    nodes = {superelement_name(n): np.flatnonzero(interior == n) for n in numbers}
    return replace(
        deck,
        superelements={superelement_name(n): part for n, part in found.items() if len(part.nodes)},
        element_sets={**deck.element_sets, **{name: ids for name, ids in elements.items() if len(ids)}},
        node_sets={**deck.node_sets, **nodes},
    )


def _interior(deck: Deck, reading: DeckReading) -> IntArray:
    """Number (N,) of the superelement to which each node is interior; 0 for the residual structure."""
    file = reading.file
    found = np.zeros(len(deck.nodes), dtype=np.int64)
    default = next((card.integer(7, "SEID", 0) for card in file.named("GRDSET")), 0)
    grids = reading.grids.cards
    found[: len(grids)] = integer_column(grids, 7, "SEID", default)
    for card in file.named("SESET"):
        found[_listed(card, deck.node_ids)] = card.integer(0, "the superelement")
    return found


def _listed(card: BulkCard, ids: IntArray) -> BoolArray:
    """Mask of the ids that a card lists from its second field on."""
    found = np.zeros(len(ids), dtype=bool)
    for listed in card.ranges(range(1, len(card.fields))):
        found |= in_range(ids, listed)
    return found


def _owners(interior: IntArray, nodes: IntArray) -> IntArray:
    """The superelement of each group of nodes (C, k): the lowest number above 0 in the group, or 0."""
    own = interior[nodes]
    far = np.iinfo(np.int64).max
    lowest = np.where(own > 0, own, far).min(axis=1, initial=far)
    return np.where(lowest == far, 0, lowest)


def _part(deck: Deck, interior: IntArray, owners: list[IntArray], number: int) -> Deck:
    """One superelement: its elements, and matrices, linear combinations and ties that belong to it.

    interior : (N + S,) as in `_interior`, and 0 for scalar points
    """

    def is_own(nodes: IntArray) -> bool:
        return int(_owners(interior, nodes[None])[0]) == number

    def matrix(given: NodalMatrix) -> NodalMatrix | None:
        return given if is_own(given.freedoms // 6) else None

    def terms(given: ScalarTerms) -> ScalarTerms:
        own = interior[given.freedoms // 6]
        far = np.iinfo(np.int64).max
        lowest = np.full(len(given.lines), far)
        np.minimum.at(lowest, given.rows, np.where(own > 0, own, far))
        return kept_terms(given, np.where(lowest == far, 0, lowest) == number)

    def tied(given: RigidTie | WeightedMean) -> bool:
        return is_own(np.append(given.nodes, given.reference))

    elements = [
        kept_elements(each, own)
        for each, owner in zip(deck.elements, owners, strict=True)
        if (own := owner == number).any()
    ]
    part = replace(
        deck.with_actions(matrix, terms),
        elements=tuple(elements),
        rigid=tuple(each for each in deck.rigid if tied(each)),
        means=tuple(each for each in deck.means if tied(each)),
    )
    return restricted_deck(part, used_nodes(part))
