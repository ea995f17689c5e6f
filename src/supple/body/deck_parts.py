"""Parts of a deck: groups of nodes connected by cells, springs, masses, constraints or ties, as decks."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from supple.arrays import IntArray
from supple.errors import ModelError, SuppleWarning, did_you_mean
from supple.importers.deck import Deck, ScalarTerms
from supple.importers.restricted_deck import kept_terms, restricted_deck

__all__ = [
    "deck_links",
    "deck_parts",
    "named_part",
    "warn_of_scalar_points",
    "with_scalar_points",
    "without_scalar_points",
]


def deck_parts(deck: Deck) -> dict[str, Deck]:
    """The connected parts of a deck, largest number of nodes first: {"part_1": .., "part_2": ..}.

    The name of a single part is "". Unused nodes and scalar points are in no part.
    """
    deck = without_scalar_points(deck)
    n, links = len(deck.node_ids), deck_links(deck)
    cells = [each.nodes for each in deck.elements]
    start = np.concatenate([links[:, 0], *(nodes[:, :-1].ravel() for nodes in cells)])
    end = np.concatenate([links[:, 1], *(nodes[:, 1:].ravel() for nodes in cells)])
    used = np.zeros(n, dtype=bool)
    used[start] = used[end] = True
    graph = sparse.coo_array((np.ones(len(start)), (start, end)), shape=(n, n))
    _, group = connected_components(graph, directed=False)
    numbers, first, count = np.unique(group[used], return_index=True, return_counts=True)
    order = np.lexsort([first, -count])
    if len(order) == 1:
        return {"": restricted_deck(deck, used)}
    return {
        f"part_{k}": restricted_deck(deck, used & (group == numbers[which]))
        for k, which in enumerate(order, 1)
    }


def without_scalar_points(deck: Deck) -> Deck:
    """The deck without scalar points, which have no position, and without terms that act on them."""
    n = len(deck.node_ids)
    if not len(deck.scalar_points):
        return deck

    placed = deck.with_actions(
        lambda matrix: matrix if (matrix.freedoms < 6 * n).all() else None,
        lambda terms: _without(terms, terms.freedoms >= 6 * n),
    )
    return replace(placed, scalar_points=deck.scalar_points[:0])


def warn_of_scalar_points(deck: Deck, stacklevel: int) -> None:
    """SuppleWarning if scalar points have an effect on the nodes of a deck, which a free body omits.

    Constraints have none if they only define the motion of scalar points, one each, without springs or
    masses on these.
    """
    first = 6 * len(deck.node_ids)
    acting, defining, joins = list[int](), list[int](), False
    for terms in (*deck.springs, *deck.dashpots, *deck.inertias, *deck.constraints):
        scalar = terms.freedoms >= first
        rows = np.unique(terms.rows[scalar])
        joins |= bool(np.isin(terms.rows[~scalar], rows).any())
        (acting if len(terms.values) else defining).extend(terms.lines[rows].tolist())
    points = {int(f) for terms in deck.constraints for f in terms.freedoms[terms.freedoms >= first]}
    if joins and (acting or len(defining) > len(points)):
        lines = [*acting, *defining]
        warnings.warn(
            f"{deck.path}: {len(lines)} springs, dashpots, masses and constraints on scalar points, first on "
            f"line {min(lines)}, are omitted, since a free body has no scalar points: replace each by a "
            "grid with its mass, joined by a spring in its direction and by constraints in all others",
            SuppleWarning,
            stacklevel=stacklevel,
        )


def with_scalar_points(deck: Deck) -> Deck:
    """The deck with its scalar points as nodes, which added supports restrict to motion along x."""
    n, k = len(deck.node_ids), len(deck.scalar_points)
    if not k:
        return deck
    place = deck.nodes.mean(axis=0) if n else np.zeros(3)
    rest = 6 * (n + np.repeat(np.arange(k), 5)) + np.tile(np.arange(1, 6), k)
    still = ScalarTerms(np.arange(5 * k), rest, np.ones(5 * k), np.zeros(5 * k, dtype=np.int64))
    return replace(
        deck,
        scalar_points=deck.scalar_points[:0],
        node_ids=np.append(deck.node_ids, deck.scalar_points),
        nodes=np.vstack([deck.nodes.reshape(-1, 3), np.tile(place, (k, 1))]),
        held=(*deck.held, still),
    )


def _without(given: ScalarTerms, refused: NDArray[np.bool_]) -> ScalarTerms:
    """The linear combinations that contain none of the refused terms.

    refused : (T,) mask of terms
    """
    kept = np.ones(len(given.lines), dtype=bool)
    kept[given.rows[refused]] = False
    return kept_terms(given, kept)


def named_part(deck: Deck, name: str | None) -> Deck:
    """The part or superelement of that name in a deck; the only part if `name` is None.

    Raises ModelError for several parts and no name; an unknown name; a deck or superelement without parts, or
    a superelement with several parts.
    Warns SuppleWarning as for `warn_of_scalar_points`.
    """
    if name is not None and name in deck.superelements:
        return named_part(deck.superelements[name], None)
    warn_of_scalar_points(deck, 4)
    parts = deck_parts(deck)
    if not parts:
        raise ModelError(f"{deck.path}: it has no elements, springs or masses for a body")
    if name is None:
        if len(parts) > 1:
            sizes = ", ".join(f"{key} ({len(part.node_ids)} nodes)" for key, part in list(parts.items())[:8])
            raise ModelError(
                f"{deck.path}: it has {len(parts)} disconnected parts: {sizes}; choose one "
                f'(part = "part_1"), or connect them'
            )
        return next(iter(parts.values()))
    if name not in parts:
        known = [*(key for key in parts if key), *deck.superelements]
        raise ModelError(f"{deck.path}: it has no part '{name}'{did_you_mean(name, known)}")
    return parts[name]


def deck_links(deck: Deck) -> IntArray:
    """Pairs (L, 2) of nodes connected by springs, dashpots, masses, constraints, ties or weighted means.

    The first node of a connection is paired with each node of the connection, itself included. The first node
    of a tie or mean is its reference node.
    """
    stars = [np.array(nodes, dtype=np.int64) for nodes in _stars(deck)]
    pairs = [np.column_stack([np.full(len(nodes), nodes[0]), nodes]) for nodes in stars]
    return np.concatenate([np.empty((0, 2), dtype=np.int64), *pairs])


def _stars(deck: Deck) -> Iterator[IntArray]:
    for matrix in (*deck.masses, *deck.stiffnesses, *deck.dampings):
        nodes = np.unique(matrix.freedoms // 6)
        if len(nodes):
            yield nodes
    for terms in (*deck.springs, *deck.dashpots, *deck.inertias, *deck.constraints):
        order = np.argsort(terms.rows, kind="stable")
        bounds = np.flatnonzero(np.diff(terms.rows[order])) + 1
        yield from np.split(terms.freedoms[order] // 6, bounds) if len(order) else ()
    for tie in deck.rigid:
        yield np.append(tie.reference, tie.nodes)
    for mean in deck.means:
        yield np.append(mean.reference, mean.nodes)
