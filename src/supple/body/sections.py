"""Force and moment across a section of an elastic body, from the forces of the adjacent elements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from supple.arguments import check_fields
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.fem import FiniteElementModel, QuadraticStrain, RigidPiece
from supple.fem.node_sparsity import cell_nodes
from supple.fem.quadratic_strain import internal_forces
from supple.integrate.motion import FloatingMotion, Motion

if TYPE_CHECKING:
    from supple.body.body_form import BodyForm

ROUNDING = 1e-9
"""Points up to this distance from the plane, relative to the size of the body, count as on the plane."""

ROOM = 2**22
"""Largest number of element values in memory at a time, unless one output time needs more."""


@dataclass(frozen=True)
class CuttingPlane:
    """A plane across an undeformed body, in the axes of its mesh.

    point : (3,)     point of the plane, m; reference point of moments
    normal : (3,)    towards the far side; of any length except zero
    """

    point: tuple[float, float, float]
    normal: tuple[float, float, float]

    def __post_init__(self) -> None:
        check_fields(self)
        if not (np.isfinite([*self.point, *self.normal]).all() and np.linalg.norm(self.normal) > 0):
            raise ModelError(
                f"a plane needs a finite point and a normal that is not zero, got {self.point} and "
                f"{self.normal}"
            )

    def heights(self, places: FloatArray) -> FloatArray:
        """Signed distances (...) of points (..., 3) from the plane along the normal; zero within ROUNDING."""
        heights = (places - self.point) @ (np.asarray(self.normal) / np.linalg.norm(self.normal))
        size = np.ptp(places.reshape(-1, 3), axis=0).max(initial=0.0)
        return np.where(abs(heights) <= ROUNDING * size, 0.0, heights)


class _Layer(NamedTuple):
    """The elements at a section."""

    freedoms: NDArray[np.int64]
    """(m,) numbers of the nodal freedoms of the nodes of these elements"""
    blocks: tuple[QuadraticStrain, ...]
    """strains of these elements; their dofs are positions in `freedoms`"""
    shares: tuple[FloatArray, ...]
    """(E,) for each block: 1/2 for elements on the near side, -1/2 on the far side"""
    cut: NDArray[np.int64]
    """(k, d) positions in `freedoms` of the freedoms of the section's k nodes"""
    places: FloatArray
    """(k, 3) undeformed positions of the section's nodes"""


class Sections(NamedTuple):
    """Section forces of a body: a function for force and moment, and the name of their axes."""

    axes: str
    """Name of the axes of the forces"""
    loads: Callable[[Motion, CuttingPlane], FloatArray]
    """From a motion and a plane to the force and moment (t, 6) exerted by the far side on the near side"""
    check: Callable[[CuttingPlane], object]
    """ModelError for a plane that is no section, before there is a motion"""


def sections_of_elements(body: BodyForm, model: FiniteElementModel) -> Sections:
    """Section forces of a body from its elements, by `section_loads`."""
    return Sections(f"axes of {body.name}", partial(section_loads, body, model), partial(_layer, body, model))


def section_loads(
    body: BodyForm, model: FiniteElementModel, motion: Motion, plane: CuttingPlane
) -> FloatArray:
    """Force and moment (t, 6) of the far side of a plane on the near side, in the body's axes.

        F = sum_n f_n,   M = sum_n (x_n + u_n - p) x f_n + m_n

    over the nodes n that elements on both sides share. f_n, m_n are the mean of the internal forces of the
    near elements, and of those of the far elements with opposite sign; the two differ by the loads on these
    nodes. Both parts are thus in equilibrium for any mesh, and distributed loads cause an error of second
    order. An element is on the side of the mean position of its nodes. p is the point of the plane, moved by
    the mean displacement of the nodes n.

    model : from which the body, reduced or full, was made
    Raises ModelError for a model with other nodes; a plane without elements on both sides that share nodes; a
    plane at a rigid interface of several nodes, or at a tie; a motion without floating frame.
    """
    layer = _layer(body, model, plane)
    coordinates = motion.of_type(FloatingMotion).coordinates
    elements = sum(block.B[..., 0].size + block.G[..., 0].size for block in layer.blocks)
    rows = max(1, ROOM // max(1, elements))
    found = np.empty((len(coordinates), 6))
    for first in range(0, len(coordinates), rows):
        part = slice(first, first + rows)
        found[part] = _resultants(layer, plane, *body.nodal_fields(coordinates[part], layer.freedoms))
    return found


def _layer(body: BodyForm, model: FiniteElementModel, plane: CuttingPlane) -> _Layer:
    d, nodes = model.dofs_per_node, model.mesh.nodes
    if len(nodes) != len(body.nodes) or not np.array_equal(nodes, body.nodes):
        raise ModelError(f"body '{body.name}' was not made of this model; give the model it was made of")
    cells = [cell_nodes(block.dofs, d) for block in model.strains]
    beyond = [plane.heights(nodes[each].mean(axis=1)) >= 0 for each in cells]
    inner, outer = np.zeros(len(nodes), dtype=bool), np.zeros(len(nodes), dtype=bool)
    for each, outside in zip(cells, beyond, strict=True):
        outer[each[outside]] = True
        inner[each[~outside]] = True
    shared = inner & outer
    if not shared.any():
        raise ModelError(
            f"body '{body.name}': the plane through {plane.point} across {plane.normal} has no elements that "
            "share nodes on both of its sides; move it into the body"
        )
    chosen = [np.flatnonzero(shared[each].any(axis=1)) for each in cells]
    around = np.unique(np.concatenate([each[some].ravel() for each, some in zip(cells, chosen, strict=True)]))
    _refuse_tied(body, model.attached.rigid, around)
    freedoms = (around[:, None] * d + np.arange(d)).ravel()
    cut = np.flatnonzero(shared[around])
    at_the_section = [
        (block.of(some), np.where(outside[some], -0.5, 0.5))
        for block, some, outside in zip(model.strains, chosen, beyond, strict=True)
        if some.size
    ]
    return _Layer(
        freedoms,
        tuple(_renumbered(block, freedoms, linear=body.is_linear) for block, _ in at_the_section),
        tuple(shares for _, shares in at_the_section),
        cut[:, None] * d + np.arange(d),
        nodes[around[cut]],
    )


def _refuse_tied(body: BodyForm, pieces: Sequence[RigidPiece], around: NDArray[np.integer]) -> None:
    for interface in body.interfaces:
        if len(interface.tied_nodes) > 1 and np.isin(interface.tied_nodes, around).any():
            raise ModelError(
                f"body '{body.name}': the section is at interface '{interface.name}', whose nodes move "
                "as one. Move it by an element, or use the force of the joint there"
            )
    for piece in pieces:
        if np.isin(piece.nodes, around).any():
            raise ModelError(
                f"body '{body.name}': the section is at the rigid tie '{piece.name}', whose nodes "
                "move as one. Move it by an element"
            )


def _renumbered(block: QuadraticStrain, freedoms: NDArray[np.int64], *, linear: bool) -> QuadraticStrain:
    form = np.zeros_like(block.N) if linear else block.N
    own = np.searchsorted(freedoms, block.dofs)
    return replace(block, dofs=own, N=form)


def _resultants(
    layer: _Layer, plane: CuttingPlane, moved: FloatArray, condensed: FloatArray | None
) -> FloatArray:
    """Force and moment (t, 6) for values (m, t) of the freedoms and of their condensed part."""
    condensed = np.zeros_like(moved) if condensed is None else condensed
    forces = np.zeros_like(moved)
    for block, shares in zip(layer.blocks, layer.shares, strict=True):
        own = internal_forces(block, moved[block.dofs], condensed[block.dofs])
        places, rows = block.dofs.ravel(), np.arange(block.dofs.size)
        gather = csr_array((np.repeat(shares, block.dofs.shape[1]), (places, rows)), (len(moved), len(rows)))
        forces += gather @ own.reshape(len(rows), -1)
    carried = forces[layer.cut].transpose(2, 0, 1)
    shifts = moved[layer.cut[:, :3]].transpose(2, 0, 1)
    arms = layer.places - plane.point + shifts - shifts.mean(axis=1, keepdims=True)
    moments = np.cross(arms, carried[..., :3])
    if carried.shape[-1] == 6:
        moments = moments + carried[..., 3:]
    return np.hstack([carried[..., :3].sum(axis=1), moments.sum(axis=1)])
