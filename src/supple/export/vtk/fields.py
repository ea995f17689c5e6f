"""Fields at the points and in the cells of a machine in motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.body import BodyForm
from supple.errors import ModelError
from supple.export.vtk.pieces import Piece
from supple.fem import FiniteElementModel
from supple.integrate import FramedMotion, Solution
from supple.machine import At, System
from supple.methods.explicit.motions import NodalMotion
from supple.quantities import displacement_from_axes, observer_of
from supple.quantities.stress_history import equivalent_stress
from supple.results.explicit_fields import element_means
from supple.units import UnitSystem, labelled

Array = NDArray[np.float64]
Evaluator = Callable[[Solution, Array], Array]
"""Function (motion, positions (t, N, 3) of a piece) -> values (t, n, ..)."""

GHOSTS = "vtkGhostType"
"""VTK's name of the array that hides cells."""
HIDDEN = 32
"""Value in that array of a hidden cell."""


@dataclass(frozen=True, eq=False)
class Field:
    """Values at the points or in the cells of some pieces.

    name : name with unit
    of_cells : whether the values are in the cells, not at the points
    width : number of components
    kind : number type in the file
    absent : value on pieces without this field
    evaluators : by piece; other pieces do not have this field
    """

    name: str
    of_cells: bool
    width: int
    kind: np.dtype
    absent: float
    evaluators: Mapping[Piece, Evaluator]


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
    bodies = [piece for piece in pieces if piece.body is not None]
    framed = [piece for piece in bodies if _form(piece).has_frame]
    # A part without a mesh is written as points, which have no values of elements.
    deleting = [piece for piece in bodies if not _form(piece).has_frame and piece.mesh is not None]
    unit, factor = units.stress_shown
    fields = [
        _field(labelled("displacement", units.length), 3, {piece: _displacement(piece) for piece in pieces}),
        _field(
            labelled("deflection", units.length),
            3,
            {piece: _deflection(system, piece, bases) for piece in framed},
        ),
        _field(
            labelled("von Mises stress", unit),
            1,
            {
                piece: _stress(piece, elements[piece.name], factor)
                for piece in bodies
                if piece.name in elements
            },
        ),
        Field(
            "plastic strain",
            of_cells=True,
            width=1,
            kind=np.dtype("<f4"),
            absent=np.nan,
            evaluators={piece: _of_elements(piece, "plastic_strain") for piece in deleting},
        ),
        Field(
            GHOSTS,
            of_cells=True,
            width=1,
            kind=np.dtype("u1"),
            absent=0,
            evaluators={piece: _hidden(piece) for piece in deleting},
        ),
    ]
    return tuple(field for field in fields if field.evaluators)


def _field(name: str, width: int, evaluators: Mapping[Piece, Evaluator]) -> Field:
    """A field at the points, in single precision."""
    return Field(name, False, width, np.dtype("<f4"), np.nan, evaluators)


def _form(piece: Piece) -> Any:
    return piece.body


def _displacement(piece: Piece) -> Evaluator:
    return lambda _part, positions: positions - piece.points


def _deflection(system: System, piece: Piece, bases: Mapping[str, At]) -> Evaluator:
    """Displacement relative to the rigid motion of an interface, in global components."""
    body: BodyForm = _form(piece)

    def deflected(part: Solution, positions: Array) -> Array:
        seen = observer_of(system, part, body.name, bases)
        assert seen is not None  # the body has a frame
        local = displacement_from_axes(positions, seen.origin[:, None], seen.axes, body.nodes - seen.rest)
        return np.einsum("tij,tnj->tni", seen.axes, local)

    return deflected


def _stress(piece: Piece, model: FiniteElementModel, factor: float) -> Evaluator:
    body = _form(piece)
    if not body.has_frame:
        return lambda part, _: factor * _node_means(body, part)
    stress = equivalent_stress(body, model)
    return lambda part, _: factor * stress(part.motion(body.name, FramedMotion).coordinates)


def _node_means(body: Any, part: Solution) -> Array:
    motion = part.motion(body.name, NodalMotion)
    return element_means(body, motion.von_mises, motion.alive)


def _of_elements(piece: Piece, name: str) -> Evaluator:
    order = _cell_order(piece)
    return lambda part, _: getattr(part.bodies[piece.name], name)[:, order]


def _hidden(piece: Piece) -> Evaluator:
    alive = _of_elements(piece, "alive")
    return lambda part, positions: HIDDEN * (alive(part, positions) == 0)


def _cell_order(piece: Piece) -> NDArray[np.int64]:
    """Numbers (E,) of the elements of an explicit part in the order of the cells of its piece."""
    body, mesh = _form(piece), piece.mesh
    assert mesh is not None
    starts = dict(zip(mesh.cells, np.cumsum([0, *map(len, mesh.cells.values())]), strict=False))
    cells = np.concatenate([starts.get(own.cell_type, 0) + own.cells for own in body.model.sections])
    if len(cells) != len(piece.cells.types):
        raise ModelError(
            f"the mesh given for part '{piece.name}' has {len(piece.cells.types)} cells and the part "
            f"{len(cells)} elements: give the mesh of which the part was made"
        )
    return np.argsort(cells, kind="stable")
