"""Instances of an assembly as decks of their own, for machines that take one each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from supple.importers.abaqus.model import AbaqusModel
from supple.importers.deck import Deck, DeckElements, ScalarTerms

__all__ = ["decks_of_instances"]

IntArray = NDArray[np.int64]


def decks_of_instances(deck: Deck, model: AbaqusModel) -> Deck:
    """The deck with one deck of each instance in `superelements`, where there are several."""
    names = [scope.name for scope in model.scopes[1:]]
    if len(names) < 2:
        return deck
    parts = {
        name: _part(deck, name, model.nodes.scopes == number)
        for number, name in enumerate(names, start=1)
        if (model.nodes.scopes == number).any()
    }
    return replace(deck, superelements=parts)


def _part(deck: Deck, name: str, mine: NDArray[np.bool_]) -> Deck:
    """What lies on some nodes alone, and on reference nodes of the model that nothing else uses.

    Constraints, springs and couplings to other instances are not in it, as joints take their place.
    """
    mine = mine.copy()
    for tie in (*deck.rigid, *deck.means):
        if mine[tie.nodes].all():
            mine[tie.reference] = True
    number = np.cumsum(mine) - 1
    lost = 0

    def terms(all_terms: tuple[ScalarTerms, ...]) -> tuple[ScalarTerms, ...]:
        nonlocal lost
        found = []
        for each in all_terms:
            inside = mine[each.freedoms // 6]
            outside_rows = np.zeros(len(each.lines), dtype=bool)
            outside_rows[each.rows[~inside]] = True
            touched = np.zeros(len(each.lines), dtype=bool)
            touched[each.rows[inside]] = True
            lost += int(np.count_nonzero(touched & outside_rows))
            kept = touched & ~outside_rows
            of = kept[each.rows]
            row = np.cumsum(kept) - 1
            moved = 6 * number[each.freedoms // 6] + each.freedoms % 6
            dependent = each.dependent[kept] if len(each.dependent) else each.dependent
            found.append(
                ScalarTerms(
                    row[each.rows[of]],
                    moved[of],
                    each.factors[of],
                    each.lines[kept],
                    each.values[kept] if len(each.values) else each.values,
                    np.where(dependent >= 0, 6 * number[dependent // 6] + dependent % 6, -1),
                )
            )
        return tuple(each for each in found if len(each.lines))

    elements = tuple(_of_elements(each, mine, number) for each in deck.elements)
    elements = tuple(each for each in elements if len(each.nodes))
    ids = np.unique(np.concatenate([np.empty(0, dtype=np.int64), *(each.ids for each in elements)]))
    used = {each.property for each in elements}
    made = replace(
        deck,
        node_ids=deck.node_ids[mine],
        nodes=deck.nodes[mine],
        elements=elements,
        properties={key: given for key, given in deck.properties.items() if key in used},
        node_sets=_sets(deck, name, mine, number),
        element_sets={
            key.removeprefix(f"{name}."): kept
            for key, of in deck.element_sets.items()
            if len(kept := of[np.isin(of, ids)])
        },
        masses=tuple(
            replace(each, freedoms=6 * number[each.freedoms // 6] + each.freedoms % 6)
            for each in deck.masses
            if mine[each.freedoms // 6].all()
        ),
        springs=terms(deck.springs),
        dashpots=terms(deck.dashpots),
        inertias=terms(deck.inertias),
        constraints=terms(deck.constraints),
        held=terms(deck.held),
        rigid=tuple(
            replace(tie, reference=int(number[tie.reference]), nodes=number[tie.nodes])
            for tie in deck.rigid
            if mine[tie.nodes].all()
        ),
        means=tuple(
            replace(tie, reference=int(number[tie.reference]), nodes=number[tie.nodes])
            for tie in deck.means
            if mine[tie.nodes].all()
        ),
    )
    crossing = sum(
        bool(mine[tie.nodes].any()) and not mine[tie.nodes].all() for tie in (*deck.rigid, *deck.means)
    )
    if not lost + crossing:
        return made
    note = (
        f"{lost + crossing} constraints or springs join instance '{name}' to others; between bodies, joints "
        "take their place"
    )
    return replace(made, notes=(*made.notes, note))


def _of_elements(each: DeckElements, mine: NDArray[np.bool_], number: IntArray) -> DeckElements:
    kept = mine[each.nodes].all(axis=1)

    def of(array):
        return None if array is None else array[kept]

    return replace(
        each,
        nodes=number[each.nodes[kept]],
        ids=each.ids[kept],
        lines=each.lines[kept],
        directions=of(each.directions),
        offsets=of(each.offsets),
        released=of(each.released),
    )


def _sets(deck: Deck, name: str, mine: NDArray[np.bool_], number: IntArray) -> dict[str, IntArray]:
    """Members that are in the part; its own sets without its name before them."""
    found = {key: number[of[mine[of]]] for key, of in deck.node_sets.items() if mine[of].any()}
    own = {key.removeprefix(f"{name}."): of for key, of in found.items() if key.startswith(f"{name}.")}
    return found | own
