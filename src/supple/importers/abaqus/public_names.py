"""Names and ids of a body's nodes, elements and sets, unique over all instances."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from supple.arrays import IntArray
from supple.importers.abaqus.deck_model import AbaqusModel
from supple.importers.numbering import Labels


def public_ids(model: AbaqusModel) -> tuple[IntArray, IntArray]:
    """Ids of nodes (N,) and of elements (E,), without repetition.

    They are those of the file; if instances use the same ids, those of scope k are raised by k 10^m.
    10^m is the first power of ten above all ids; k counts the instances from 0, then the model outside all
    instances. If these ids exceed 64 bits, ids are 1, 2, .. instead.
    """
    order = [*range(1, len(model.scopes)), 0]
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    return _unique(model, model.nodes, rank), _unique(model, model.element_labels, rank)


def public_name(model: AbaqusModel, scope: int, name: str, taken: Mapping[tuple[int, str], object]) -> str:
    """The name of a set; INSTANCE.SET if there are several instances, or the model also has that name."""
    alone = len(model.scopes) < 3 and (0, name.upper()) not in taken
    return name if not scope or alone else f"{model.scopes[scope].name}.{name}"


def public_sets(
    model: AbaqusModel, sets: Mapping[tuple[int, str], tuple[str, IntArray]]
) -> dict[str, IntArray]:
    """Members of sets by their public names."""
    return {public_name(model, scope, name, sets): members for (scope, _), (name, members) in sets.items()}


def _unique(model: AbaqusModel, labels: Labels, rank: IntArray) -> IntArray:
    if len(np.unique(labels.ids)) == len(labels.ids):
        return labels.ids
    unit = 10 ** len(str(int(np.abs(labels.ids).max())))
    if unit * len(rank) > np.iinfo(np.int64).max:
        return np.arange(1, len(labels.ids) + 1)
    model.report.note(
        f"instances use the same ids: those of the second are raised by {unit}, the third by {2 * unit}, .."
    )
    return labels.ids + unit * rank[labels.scopes]
