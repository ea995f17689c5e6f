"""Freedoms of nodes in the axes of *TRANSFORM, and those that *BOUNDARY fixes."""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray
from supple.importers.abaqus.deck_model import AbaqusModel
from supple.importers.abaqus.orientation import by_points
from supple.importers.deck import ScalarTerms
from supple.importers.freedom_sums import FreedomSums, Terms, motion_along
from supple.importers.keyword_file import fields, numbers
from supple.importers.plain_number import is_plain_digits

_NAMED = {
    "ENCASTRE": (1, 2, 3, 4, 5, 6), "PINNED": (1, 2, 3), "XSYMM": (1, 5, 6), "YSYMM": (2, 4, 6),
    "ZSYMM": (3, 4, 5), "XASYMM": (2, 3, 4), "YASYMM": (1, 3, 5), "ZASYMM": (1, 2, 6), "NOWARP": (),
    "NOOVAL": (), "NODEFORM": (),
}  # fmt: skip


class Freedoms:
    """Terms of the freedoms 1 to 6 of nodes, in the axes of *TRANSFORM or in global axes.

    rotation_nodes : {node: reference} of ROT NODE: freedoms 1 to 3 of the node are rotations of the reference
    """

    def __init__(self, model: AbaqusModel) -> None:
        self._axes: dict[int, FloatArray] = {}
        self.rotation_nodes: dict[int, int] = {}
        for placed in model.named("TRANSFORM"):
            block = placed.block
            if not block.data:
                raise model.file.error(block.line, "*TRANSFORM without its points; is the file cut short?")
            line, text = block.data[0]
            name = block.options.get("NSET", "")
            nodes = model.nodes_of(placed.scope, name, block.line, "*TRANSFORM")
            kind = block.options.get("TYPE", "R").upper()[:1]
            if kind not in ("R", "C"):
                model.report.leave_out(
                    f"*TRANSFORM, TYPE={kind}", block.line, "supports and constraints there are not rotated"
                )
                continue
            # Directions from the origin of the instance, or an axis.
            system = by_points(model, "*TRANSFORM", kind, 0, 0.0, placed.scope, line, fields(text)[:6])
            axes = system.axes(model.positions[nodes], np.full(len(nodes), -1))
            self._axes.update(zip(nodes.tolist(), axes, strict=True))

    def of(self, node: int, component: int, factor: float = 1.0) -> Terms:
        """A freedom (component 1 to 6) times `factor`, as terms of global freedoms 6 * node + 0 to 5."""
        rotation = component > 3
        if node in self.rotation_nodes:
            node, rotation = self.rotation_nodes[node], True
        place = (component - 1) % 3
        if node not in self._axes:
            return [(6 * node + (3 if rotation else 0) + place, factor)]
        return motion_along(node, self._axes[node][:, place], factor, rotation=rotation)


def read_supports(model: AbaqusModel, freedoms: Freedoms) -> tuple[ScalarTerms, ...]:
    """The freedoms that *BOUNDARY of the model or of its first step fixes, each once, as constraints.

    Driven freedoms are left out.

    Raises
    ------
    ImportFormatError   words instead of numbers; an unknown type of support
    """
    rows = FreedomSums()
    held: set[tuple[int, int]] = set()
    for placed in model.blocks:
        block = placed.block
        # These options prescribe motions.
        driven = {"SUBMODEL", "USER", "TYPE"} & block.options.keys()
        if block.key != "BOUNDARY" or placed.step > 1 or (driven and placed.step):
            continue
        if placed.step == 0:
            model.report.read[block.name] += 1
        for line, text in block.data:
            words = fields(text)
            nodes = model.nodes_of(placed.scope, words[0], line, "*BOUNDARY")
            for component in _components(model, line, words):
                for node in nodes.tolist():
                    if (node, component) not in held:
                        held.add((node, component))
                        rows.add(freedoms.of(node, component), model.file.numbers[line])
    return rows.terms(constraints=True)


def _components(model: AbaqusModel, line: int, words: list[str]) -> list[int]:
    """Freedoms 1 to 6 that a line fixes; none if it gives a displacement other than 0."""
    if len(words) < 2 or not words[1]:
        return []
    if words[1].upper() in _NAMED:
        return list(_NAMED[words[1].upper()])
    if not is_plain_digits(words[1]) or (len(words) > 2 and words[2] and not is_plain_digits(words[2])):
        raise model.file.error(
            line, f"*BOUNDARY fixes freedoms 1 to 6, or {', '.join(_NAMED)}; '{words[1][:40]}' is none"
        )
    first = int(words[1])
    last = int(words[2]) if len(words) > 2 and words[2] else first
    if len(words) > 3 and numbers(model.file, line, words[3:4])[0]:
        return []
    return list(range(max(first, 1), min(last, 6) + 1))
