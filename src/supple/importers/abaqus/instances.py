"""Instances of an assembly as separate decks, for machines with a body for each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from supple.arrays import BoolArray
from supple.importers.abaqus.deck_model import AbaqusModel
from supple.importers.deck import Deck
from supple.importers.restricted_deck import restricted_deck


def decks_of_instances(deck: Deck, model: AbaqusModel) -> Deck:
    """The deck; if it has several instances, `superelements` contains a deck for each of them."""
    names = [scope.name for scope in model.scopes[1:]]
    if len(names) < 2:
        return deck
    parts = {
        name: _part(deck, name, model.nodes.scopes == number)
        for number, name in enumerate(names, start=1)
        if (model.nodes.scopes == number).any()
    }
    return replace(deck, superelements=parts)


def _part(deck: Deck, name: str, mine: BoolArray) -> Deck:
    """The deck of one instance, on its nodes and reference nodes, with set names without INSTANCE.

    Constraints, springs and ties to other instances are omitted; joints between bodies replace them.
    """
    own = mine.copy()
    ties = (*deck.rigid, *deck.means)
    for tie in ties:
        own[tie.reference] |= mine[tie.nodes].all()
    made = restricted_deck(deck, own)
    ids = np.unique(np.concatenate([np.empty(0, dtype=np.int64), *(each.ids for each in made.elements)]))
    element_sets = {key: of[np.isin(of, ids)] for key, of in deck.element_sets.items()}
    used = {each.property for each in made.elements}
    before = f"{name}."
    crossing = sum(bool(own[tie.nodes].any()) and not own[tie.nodes].all() for tie in ties)
    for terms in (*deck.springs, *deck.dashpots, *deck.constraints):
        inside, rows = own[terms.freedoms // 6], len(terms.lines)
        count = np.bincount(terms.rows[inside], minlength=rows)
        crossing += int(np.count_nonzero((count > 0) & (count < np.bincount(terms.rows, minlength=rows))))
    note = (
        f"{crossing} constraints or springs join instance '{name}' to others; between bodies, use joints "
        "instead"
    )
    return replace(
        made,
        properties={key: given for key, given in deck.properties.items() if key in used},
        node_sets={key.removeprefix(before): of for key, of in made.node_sets.items()},
        element_sets={key.removeprefix(before): of for key, of in element_sets.items() if len(of)},
        notes=(*deck.notes, note) if crossing else deck.notes,
    )
