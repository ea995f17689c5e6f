"""Assembly of several decks into one by their common nodes (superelements)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from supple.arrays import IntArray
from supple.importers.deck import Deck, DeckElements
from supple.importers.restricted_deck import renumbered_deck


@dataclass(frozen=True, eq=False)
class CommonNodes:
    """Common nodes (k,) of two decks, `first` and `second`, given by name."""

    first: str
    second: str
    first_nodes: IntArray
    second_nodes: IntArray


def merged_decks(decks: Mapping[str, Deck], common: Sequence[CommonNodes]) -> Deck:
    """One deck of several decks; the nodes and the elements of each deck become sets of its name.

    `superelements` contains the given decks. Sets, properties and ties are renamed to NAME.SET, except those
    of the first deck. A common node has the position and id in the first deck that contains it; an id that is
    in use is replaced by a free one.
    """
    numbers, first = _numbers(decks, common)
    ids = np.concatenate([deck.node_ids for deck in decks.values()])[first]
    places = np.concatenate([deck.nodes for deck in decks.values()])[first]
    taken, parts, n_scalars = ids[:0], list[Deck](), 0
    for name, deck in decks.items():
        scalars = len(first) + n_scalars + np.arange(len(deck.scalar_points))
        n_scalars += len(scalars)
        before = f"{name}." if parts else ""
        part = _renumbered(deck, np.concatenate([numbers[name], scalars]), before, taken)
        own = np.unique(np.concatenate([ids[:0], *(each.ids for each in part.elements)]))
        taken = np.concatenate([taken, own])
        node_sets = {name: np.unique(numbers[name])} if len(deck.nodes) else {}
        parts.append(
            replace(
                part,
                node_sets={**part.node_sets, **node_sets},
                element_sets={**part.element_sets, **({name: own} if len(own) else {})},
            )
        )
    return replace(
        _together(parts),
        node_ids=_without_repeats(ids, ids[:0]),
        nodes=places,
        superelements=dict(decks),
    )


def _numbers(
    decks: Mapping[str, Deck], common: Sequence[CommonNodes]
) -> tuple[dict[str, IntArray], IntArray]:
    """Assembly numbers of each deck's nodes; first place of each assembly node in the nodes of all decks."""
    start = dict(zip(decks, np.cumsum([0, *(len(each.nodes) for each in decks.values())]), strict=False))
    total = sum(len(each.nodes) for each in decks.values())
    none = np.empty(0, dtype=np.int64)
    one = np.concatenate([none, *(start[each.first] + each.first_nodes for each in common)])
    other = np.concatenate([none, *(start[each.second] + each.second_nodes for each in common)])
    graph = sparse.coo_array((np.ones(len(one)), (one, other)), shape=(total, total))
    _, group = connected_components(graph, directed=False)
    _, first, place = np.unique(group, return_index=True, return_inverse=True)
    order = np.argsort(first)
    number = np.argsort(order)[place]
    return {name: number[start[name] : start[name] + len(deck.nodes)] for name, deck in decks.items()}, first[
        order
    ]


def _without_repeats(ids: IntArray, taken: IntArray) -> IntArray:
    """The ids; repeated ids and ids in use are replaced by free ones above all others."""
    _, first = np.unique(ids, return_index=True)
    free = np.ones(len(ids), dtype=bool)
    free[first] = False
    free |= np.isin(ids, taken)
    last = max(int(ids.max(initial=0)), int(taken.max(initial=0)))
    return np.where(free, last + np.cumsum(free), ids)


def _renumbered(deck: Deck, number: IntArray, before: str, taken: IntArray) -> Deck:
    """The deck in the node numbers of the assembly; element ids in use are replaced by free ones."""
    made = renumbered_deck(deck, number)
    named = {name: f"{before}{name}" for name in deck.properties}
    old = np.unique(np.concatenate([taken[:0], *(each.ids for each in deck.elements)]))
    new = _without_repeats(old, taken)

    def elements(given: DeckElements) -> DeckElements:
        own = named.get(given.property, given.property)
        return replace(given, ids=new[np.searchsorted(old, given.ids)], property=own)

    return replace(
        made,
        elements=tuple(elements(each) for each in made.elements),
        properties={named[name]: each for name, each in deck.properties.items()},
        node_sets={f"{before}{name}": nodes for name, nodes in made.node_sets.items()},
        element_sets={
            f"{before}{name}": new[np.searchsorted(old, of[np.isin(of, old)])]
            for name, of in deck.element_sets.items()
        },
        rigid=tuple(replace(each, name=f"{before}{each.name}") for each in made.rigid),
        means=tuple(replace(each, name=f"{before}{each.name}") for each in made.means),
    )


def _together(parts: Sequence[Deck]) -> Deck:
    """The union of decks in the node numbers of the assembly; nodes and lumping are those of the first."""
    lists = ("elements", "masses", "stiffnesses", "dampings", "springs", "dashpots", "inertias")
    joined = {
        name: tuple(each for part in parts for each in getattr(part, name))
        for name in (*lists, "constraints", "held", "rigid", "means", "left_out")
    }
    named = {
        name: {key: each for part in parts for key, each in getattr(part, name).items()}
        for name in ("properties", "node_sets", "element_sets")
    }
    return replace(
        parts[0],
        **joined,
        **named,
        read=_sum(part.read for part in parts),
        passed_over=_sum(part.passed_over for part in parts),
        notes=tuple(dict.fromkeys(note for part in parts for note in part.notes)),
        scalar_points=np.concatenate([part.scalar_points for part in parts]),
    )


def _sum(counts: Iterable[Mapping[str, int]]) -> dict[str, int]:
    total: Counter[str] = Counter()
    for each in counts:
        total.update(each)
    return dict(total)
