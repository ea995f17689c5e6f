"""Elements of one keyword, and numbers for ids within scopes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from supple.arrays import BoolArray, IntArray
from supple.importers.abaqus.element_types import ElementType


@dataclass(frozen=True, eq=False)
class ElementBlock:
    """Elements of one keyword.

    first : number of its first element in the file;  ids : (E,);  nodes : (E, n) node numbers
    lines : (E,) indices of `KeywordFile.lines`;  set_name : the set of ELSET or NEW SET
    axis_nodes : (E,) for beams, a node towards which their first axis points; None if not given
    master : id of an element above it that is in its set as well; None without one
    """

    type: ElementType
    scope: int
    first: int
    ids: IntArray
    nodes: IntArray
    lines: IntArray
    set_name: str | None = None
    axis_nodes: IntArray | None = None
    master: int | None = None

    @property
    def numbers(self) -> IntArray:
        """Numbers (E,) of the elements among all elements of the file."""
        return self.first + np.arange(len(self.ids))


@dataclass(frozen=True, eq=False)
class Labels:
    """Scopes and ids of items; ids are unique within a scope."""

    scopes: IntArray
    ids: IntArray
    _sorted: dict[int, tuple[IntArray, IntArray]] = field(default_factory=dict)

    def numbers(self, scope: int, ids: IntArray) -> tuple[IntArray, BoolArray]:
        """Numbers of ids in a scope, and a mask of the ids that exist; only these have a valid number."""
        # Ids are looked up line by line, so they are sorted once.
        if scope not in self._sorted:
            mine = self.of(scope)
            mine = mine[np.argsort(self.ids[mine], kind="stable")]
            self._sorted[scope] = mine, self.ids[mine]
        mine, known = self._sorted[scope]
        if not len(mine):
            return np.zeros(ids.shape, dtype=np.int64), np.zeros(ids.shape, dtype=bool)
        place = np.minimum(np.searchsorted(known, ids), len(known) - 1)
        return mine[place], known[place] == ids

    def of(self, scope: int) -> IntArray:
        """Numbers of all items in a scope."""
        return np.flatnonzero(self.scopes == scope)
