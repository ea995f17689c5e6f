"""Freedoms of nodes in the axes of *TRANSFORM; linear combinations of freedoms for springs and ties."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.importers.abaqus.deck_model import AbaqusModel
from supple.importers.abaqus.orientation import cylindrical_axes
from supple.importers.deck import ScalarTerms
from supple.importers.keyword_file import fields, numbers

Terms = list[tuple[int, float]]


class Rows:
    """Linear combinations of freedoms, one a row, under construction."""

    def __init__(self, lines: IntArray) -> None:
        self._lines = lines
        self._row: list[int] = []
        self._freedoms: list[int] = []
        self._factors: list[float] = []
        self._line: list[int] = []
        self._values: list[float] = []
        self._dependent: list[int] = []

    def add(self, terms: Terms, line: int, *, value: float = 0.0, dependent: int = -1) -> None:
        """Add a row; terms of the same freedom are summed, and a row of zeros is omitted.

        line : index of `KeywordFile.lines`;  dependent : the freedom that the row eliminates, or -1
        """
        total: dict[int, float] = {}
        for freedom, factor in terms:
            total[freedom] = total.get(freedom, 0.0) + factor
        kept = {freedom: factor for freedom, factor in total.items() if factor}
        if not kept:
            return
        self._row += [len(self._line)] * len(kept)
        self._freedoms += kept
        self._factors += kept.values()
        self._line.append(int(self._lines[line]))
        self._values.append(value)
        self._dependent.append(dependent)

    def __len__(self) -> int:
        return len(self._line)

    def terms(self, *, with_values: bool) -> tuple[ScalarTerms, ...]:
        """The rows as one object, of springs (with values) or constraints; empty without rows."""
        if not self._line:
            return ()
        return (
            ScalarTerms(
                np.array(self._row, dtype=np.int64),
                np.array(self._freedoms, dtype=np.int64),
                np.array(self._factors),
                np.array(self._line, dtype=np.int64),
                np.array(self._values) if with_values else np.empty(0),
                np.empty(0, dtype=np.int64) if with_values else np.array(self._dependent, dtype=np.int64),
            ),
        )


class Freedoms:
    """Terms of the freedoms 1 to 6 of nodes, in the axes of *TRANSFORM or in global axes.

    rotation_nodes : {node: reference} of ROT NODE: freedoms 1 to 3 of the node are rotations of the reference
    """

    def __init__(self, model: AbaqusModel) -> None:
        self._axes: dict[int, FloatArray] = {}
        self.rotation_nodes: dict[int, int] = {}
        self.lines = np.array([number for _, number, _ in model.file.lines], dtype=np.int64)
        for placed in model.named("TRANSFORM"):
            block = placed.block
            if not block.data:
                raise model.file.error(block.line, "*TRANSFORM without its points; is the file cut short?")
            line, text = block.data[0]
            values = np.array([*numbers(model.file, line, fields(text)), *6 * [0.0]][:6]).reshape(2, 3)
            name = block.options.get("NSET", "")
            nodes = model.nodes_of(placed.scope, name, block.line, "*TRANSFORM")
            scope = model.scopes[placed.scope]
            kind = block.options.get("TYPE", "R").upper()[:1]
            a, b = values @ scope.rotation.T
            third = np.cross(a, b)
            if not np.linalg.norm(third if kind == "R" else b - a) > 0:
                raise model.file.error(line, "*TRANSFORM: its points give no axes; correct them")
            if kind == "R":
                axes = np.column_stack([a, np.cross(third, a), third])
                axes = np.broadcast_to(axes / np.linalg.norm(axes, axis=0), (len(nodes), 3, 3))
            elif kind == "C":
                axes = cylindrical_axes(a + scope.shift, b + scope.shift, model.positions[nodes])
            else:
                model.report.leave_out(
                    f"*TRANSFORM, TYPE={kind}", block.line, "supports and constraints there are not rotated"
                )
                continue
            self._axes.update(zip(nodes.tolist(), axes, strict=True))

    def of(self, node: int, component: int, factor: float = 1.0) -> Terms:
        """A freedom (component 1 to 6) times `factor`, as terms of global freedoms 6 * node + 0 to 5."""
        rotation = component > 3
        if node in self.rotation_nodes:
            node, rotation = self.rotation_nodes[node], True
        first = 6 * node + (3 if rotation else 0)
        place = (component - 1) % 3
        axes = self._axes.get(node)
        if axes is None:
            return [(first + place, factor)]
        column = axes[:, place]
        return [(first + i, factor * float(column[i])) for i in range(3) if abs(column[i]) > 1e-14]


def along(first: int, second: int, direction: Iterable[float]) -> Terms:
    """The elongation (u_second - u_first) . direction between two nodes."""
    terms: Terms = []
    for i, component in enumerate(direction):
        terms += [(6 * second + i, float(component)), (6 * first + i, -float(component))]
    return terms


def rigid_terms(node: int, reference: int, arm: FloatArray, component: FloatArray) -> Terms:
    """Terms of c . (u_node - u_ref - theta_ref x arm), with c = `component` (3,).

    arm : (3,) from the reference node to the node
    """
    terms: Terms = []
    turn = np.cross(arm, component)  # c . (theta x arm) = theta . (arm x c)
    for i in range(3):
        terms += [
            (6 * node + i, float(component[i])),
            (6 * reference + i, -float(component[i])),
            (6 * reference + 3 + i, -float(turn[i])),
        ]
    return terms
