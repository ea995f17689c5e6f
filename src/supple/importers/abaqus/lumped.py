"""Concentrated masses and inertias, springs and dashpots of Abaqus and CalculiX."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.importers.abaqus.assembly import ScopedBlock
from supple.importers.abaqus.deck_model import AbaqusModel
from supple.importers.abaqus.element_types import ElementBlock, Family
from supple.importers.abaqus.freedoms import Freedoms
from supple.importers.abaqus.orientation import Orientations, nodal_axes
from supple.importers.deck import NodalMatrix, ScalarTerms
from supple.importers.freedom_sums import FreedomSums, motion_along, relative_motion
from supple.importers.keyword_file import number_rows


def read_masses(
    model: AbaqusModel, orientations: Orientations
) -> tuple[tuple[ScalarTerms, ...], tuple[NodalMatrix, ...]]:
    """*MASS as terms, *ROTARY INERTIA as matrices of the rotations of a node.

    Raises
    ------
    ImportFormatError   a mass that is missing or negative; an inertia that is not positive semidefinite;
                        words instead of numbers
    """
    rows = FreedomSums()
    matrices: list[NodalMatrix] = []
    for placed in model.named("MASS"):
        values = list(chain(*number_rows(model.file, placed.block)))
        by_axis = placed.block.options.get("TYPE", "").upper().startswith("ANISO")
        m = values[:3] if by_axis else 3 * values[:1]
        if len(m) < 3 or min(m) < 0:
            needed = "three numbers" if by_axis else "one number"
            raise model.file.error(
                placed.block.line, f"*MASS needs {needed} of at least zero; correct the line"
            )
        for block, places in _elements(model, placed, Family.MASS):
            nodes = block.nodes[places, 0]
            axes, line = np.tile(np.eye(3), (len(nodes), 1, 1)), model.file.numbers[placed.block.line]
            if by_axis:
                axes = _axes(model, placed, orientations, nodes)
            for node, own in zip(nodes.tolist(), axes, strict=True):
                for i in range(3):
                    if m[i]:
                        rows.add(motion_along(node, own[:, i]), line, value=m[i])
    for placed in model.named("ROTARYINERTIA"):
        v = [*chain(*number_rows(model.file, placed.block)), *6 * [0.0]][:6]
        given = np.array([[v[0], v[3], v[4]], [v[3], v[1], v[5]], [v[4], v[5], v[2]]])
        if np.linalg.eigvalsh(given)[0] < -1e-9 * np.abs(given).max():
            raise model.file.error(
                placed.block.line,
                "*ROTARY INERTIA: I11, I22, I33, I12, I13, I23 are not an inertia tensor; correct them",
            )
        for block, places in _elements(model, placed, Family.ROTARY_INERTIA):
            nodes = block.nodes[places, 0]
            for node, axes in zip(nodes.tolist(), _axes(model, placed, orientations, nodes), strict=True):
                matrices.append(NodalMatrix(6 * node + np.arange(3, 6), axes @ given @ axes.T))
    return rows.terms(), tuple(matrices)


def _axes(model: AbaqusModel, placed: ScopedBlock, orientations: Orientations, nodes: IntArray) -> FloatArray:
    """Axes (n, 3, 3) of a mass or inertia at nodes as columns: those of ORIENTATION, or of the instance."""
    found = nodal_axes(model, placed, orientations, nodes)
    if found is not None:
        return found
    name = placed.block.options.get("ORIENTATION", "").upper()
    if name:
        model.report.leave_out_block(placed.block, f"its axes '{name}' are not read; global axes are used")
    return np.tile(model.scopes[placed.scope].rotation, (len(nodes), 1, 1))


def read_springs(
    model: AbaqusModel, freedoms: Freedoms, family: Family, keyword: str
) -> tuple[ScalarTerms, ...]:
    """Springs or dashpots: along the line of two nodes (A), between two freedoms (2), to the ground (1).

    Raises
    ------
    ImportFormatError   values or freedoms that are missing; words instead of numbers
    """
    rows = FreedomSums()
    for placed in model.named(keyword):
        block = placed.block
        values = number_rows(model.file, block)
        if "ORIENTATION" in block.options:
            model.report.leave_out_block(block, "its direction is not read; global axes are used")
        for elements, places in _elements(model, placed, family):
            of_line = elements.type.name.endswith("A")
            wanted = 1 if of_line else 2
            if len(values) < wanted or (
                not of_line and len(values[0]) < (2 if elements.type.n_nodes == 2 else 1)
            ):
                raise model.file.error(
                    block.line, f"*{block.name} lacks its freedoms or its value; is the file cut short?"
                )
            if not of_line and not all(1 <= component <= 6 for component in values[0][:2]):
                model.report.leave_out_block(block, "it acts on freedoms other than 1 to 6")
                continue
            value = _slope(model, placed, values[wanted - 1 :])
            for nodes, at in zip(
                elements.nodes[places].tolist(), elements.lines[places].tolist(), strict=True
            ):
                first, second, line = nodes[0], nodes[-1], model.file.numbers[at]
                span = model.positions[second] - model.positions[first]
                if elements.type.n_nodes == 1:
                    rows.add(freedoms.of(first, int(values[0][0])), line, value=value)
                elif not of_line:
                    i, j = (int(component) for component in values[0][:2])
                    terms = [*freedoms.of(second, j), *freedoms.of(first, i, -1.0)]
                    rows.add(terms, line, value=value)
                elif np.linalg.norm(span) > 0:
                    terms = relative_motion(second, first, span / np.linalg.norm(span))
                    rows.add(terms, line, value=value)
                else:
                    model.report.leave_out(
                        f"*ELEMENT, TYPE={elements.type.name}", at, "without length it has no direction"
                    )
    return rows.terms()


def _slope(model: AbaqusModel, placed: ScopedBlock, rows: list[list[float]]) -> float:
    """The value, or the slope at zero of a table of force over displacement."""
    if "NONLINEAR" not in placed.block.options:
        return rows[0][0]
    table = np.array([[*row, 0.0][:2] for row in rows])
    model.report.note(f"a nonlinear *{placed.block.name} is linearised at zero")
    order = np.argsort(table[:, 1])
    force, stretch = table[order].T
    if len(table) < 2 or not stretch[-1] > stretch[0]:
        raise model.file.error(
            placed.block.line, f"*{placed.block.name} needs two points of its table or more"
        )
    i = int(np.clip(np.searchsorted(stretch, 0.0, side="right"), 1, len(table) - 1))
    return float((force[i] - force[i - 1]) / (stretch[i] - stretch[i - 1]))


def _elements(
    model: AbaqusModel, placed: ScopedBlock, family: Family
) -> Iterator[tuple[ElementBlock, IntArray]]:
    name = placed.block.options.get("ELSET", "")
    members = model.elements_of(placed.scope, name, placed.block.line, f"*{placed.block.name}")
    for block, places in model.positions_of_elements(members):
        if block.type.family is family:
            yield block, places
