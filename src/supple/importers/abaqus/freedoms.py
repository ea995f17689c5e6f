"""Freedoms of nodes in the axes of *TRANSFORM."""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray
from supple.importers.abaqus.deck_model import AbaqusModel
from supple.importers.abaqus.orientation import by_points
from supple.importers.freedom_sums import Terms, motion_along
from supple.importers.keyword_file import fields


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
