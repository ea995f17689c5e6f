"""Fields at the points and in the cells of a machine in motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray
from supple.body import BodyForm
from supple.errors import ModelError
from supple.export.vtk.pieces import Piece
from supple.fem import FiniteElementModel
from supple.integrate import FramedMotion, Solution
from supple.machine import At, System
from supple.mesh import Mesh
from supple.methods.explicit import NodalMotion
from supple.quantities import displacement_from_axes, observer_of
from supple.quantities.stress_history import equivalent_stress
from supple.results.explicit_fields import element_means, has_explicit_elements
from supple.units import UnitSystem, labelled

Evaluator = Callable[[Solution, FloatArray], FloatArray]
"""Function (motion, positions (t, N, 3) of a piece) -> values (t, n, ..)."""

GHOSTS = "vtkGhostType"
"""VTK's name of the array that hides cells."""
HIDDEN = 32
"""Value in that array of a hidden cell."""


@dataclass(frozen=True, eq=False)
class Field:
    """Values at the points or in the cells of some pieces.

    name : name with unit
    evaluators : by piece; other pieces do not have this field
    width : number of components
    of_cells : whether the values are in the cells, not at the points
    kind : number type in the file
    absent : value on pieces without this field
    """

    name: str
    evaluators: Mapping[Piece, Evaluator]
    width: int = 1
    of_cells: bool = False
    kind: str = "<f4"
    absent: float = np.nan

    @property
    def section(self) -> str:
        """Name of the section of a file that contains the field."""
        return "CellData" if self.of_cells else "PointData"

    def n_rows(self, piece: Piece) -> int:
        """Number of points or cells of a piece."""
        return len(piece.cells.types if self.of_cells else piece.points)

    def values(self, part: Solution, positions: Mapping[Piece, FloatArray]) -> NDArray:
        """Values (t, n) or (t, n, width) on all pieces, one after another, in the number type of the file.

        positions : (t, N, 3) of each piece
        """
        found = []
        for piece, own in positions.items():
            shape = (len(part.times), self.n_rows(piece), self.width)[: 2 + (self.width > 1)]
            evaluate = self.evaluators.get(piece)
            values = np.full(shape, self.absent) if evaluate is None else np.asarray(evaluate(part, own))
            found.append(values.astype(self.kind))
        return np.concatenate(found, axis=1)


def fields_of(
    system: System,
    pieces: Sequence[Piece],
    elements: Mapping[str, FiniteElementModel],
    bases: Mapping[str, At],
    units: UnitSystem,
) -> tuple[Field, ...]:
    """Displacement and deflection; if available, stress, plastic strain and deleted cells.

    Raises ModelError for elements of an unknown body.
    """
    for name in elements:
        system.placed(name, "elements")  # a misspelt name is an error
    bodies = {piece: piece.body for piece in pieces if piece.body is not None}
    unit, factor = units.stress_shown
    deflections = {each: _deflection(system, body, bases) for each, body in bodies.items() if body.has_frame}
    stresses = {
        each: _stress(body, elements[each.name], factor)
        for each, body in bodies.items()
        if each.name in elements
    }
    strains = _of_cells(pieces, lambda motion: motion.plastic_strain)
    hidden = _of_cells(pieces, lambda motion: HIDDEN * (motion.alive == 0))
    fields = (
        Field(labelled("displacement", units.length), {each: _displacement(each) for each in pieces}, 3),
        Field(labelled("deflection", units.length), deflections, 3),
        Field(labelled("von Mises stress", unit), stresses),
        Field("plastic strain", strains, of_cells=True),
        Field(GHOSTS, hidden, of_cells=True, kind="u1", absent=0),
    )
    return tuple(field for field in fields if field.evaluators)


def _displacement(piece: Piece) -> Evaluator:
    return lambda _part, positions: positions - piece.points


def _deflection(system: System, body: BodyForm, bases: Mapping[str, At]) -> Evaluator:
    """Displacement relative to the rigid motion of an interface, in global components."""

    def deflected(part: Solution, positions: FloatArray) -> FloatArray:
        seen = observer_of(system, part, body.name, bases)
        assert seen is not None  # the body has a frame
        local = displacement_from_axes(positions, seen.origin[:, None], seen.axes, body.nodes - seen.rest)
        return np.einsum("tij,tnj->tni", seen.axes, local)

    return deflected


def _stress(body: BodyForm, model: FiniteElementModel, factor: float) -> Evaluator:
    if has_explicit_elements(body):

        def at_nodes(part: Solution, _: FloatArray) -> FloatArray:
            motion = part.motion(body.name, NodalMotion)
            return factor * element_means(body, motion.von_mises, motion.alive)

        return at_nodes
    stress = equivalent_stress(body, model)
    return lambda part, _: factor * stress(part.motion(body.name, FramedMotion).coordinates)


def _of_cells(pieces: Sequence[Piece], values: Callable[[NodalMotion], FloatArray]) -> dict[Piece, Evaluator]:
    """Values of the elements of explicit parts, in the order of the cells of their pieces.

    A part without a mesh is written as points, which have no values of elements.
    """
    found: dict[Piece, Evaluator] = {}
    for piece in pieces:
        body = piece.body
        if body is not None and has_explicit_elements(body) and piece.mesh is not None:
            order = _cell_order(piece, body.model, piece.mesh)
            found[piece] = lambda part, _, piece=piece, order=order: values(
                part.motion(piece.name, NodalMotion)
            )[:, order]
    return found


def _cell_order(piece: Piece, model: FiniteElementModel, mesh: Mesh) -> NDArray[np.int64]:
    """Numbers (E,) of the elements of an explicit part in the order of the cells of its piece."""
    starts = dict(zip(mesh.cells, np.cumsum([0, *map(len, mesh.cells.values())]), strict=False))
    cells = np.concatenate([starts.get(own.cell_type, 0) + own.cells for own in model.sections])
    if len(cells) != len(piece.cells.types):
        raise ModelError(
            f"the mesh given for part '{piece.name}' has {len(piece.cells.types)} cells and the part "
            f"{len(cells)} elements: give the mesh of which the part was made"
        )
    return np.argsort(cells, kind="stable")
