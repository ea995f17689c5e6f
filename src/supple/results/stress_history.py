"""Stress and strain over time of any elastic body, reduced, full or intrinsic."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.body import FullBody
from supple.body.floating_kinematics import node_numbers
from supple.fem import (
    FiniteElementModel,
    StressRecovery,
    strain_recovery,
    stress_recovery,
    von_mises,
    von_mises_strain,
)
from supple.intrinsic import IntrinsicBody
from supple.reduction import ReducedBody
from supple.results.stress_modes import strain_modes, stress_modes
from supple.results.tied_recovery import tied_recovery, with_virtual_freedoms

Array = NDArray[np.float64]


def von_mises_history(
    body: ReducedBody | FullBody | IntrinsicBody,
    model: FiniteElementModel,
    coordinates: Array,
    nodes: ArrayLike | None = None,
) -> Array:
    """Von Mises stress (t, N), Pa, the largest over the layers, of coordinates (t, r).

    A reduced body goes through its stress modes; the reference, a full body, is recovered one vector at a
    time, as is a body of more columns than tensors are made for (`ReducedBody.elastic_elsewhere`).
    Elements beside rigid interfaces have the strain that their ties leave them. A linear body has the
    stress of its linear strain; an intrinsic one that of the static shapes that carry its section loads.

    Parameters
    ----------
    model : FiniteElementModel      the one the body was made of
    nodes : int array (N,)          numbers of the nodes of interest; all of them when omitted

    Raises
    ------
    ModelError   as for stress_modes
    """
    if isinstance(body, ReducedBody) and not body.elastic_elsewhere:
        return stress_modes(body, model, nodes).von_mises(coordinates)
    return _measured(body, stress_recovery(model), von_mises, coordinates, nodes)


def von_mises_strain_history(
    body: ReducedBody | FullBody | IntrinsicBody,
    model: FiniteElementModel,
    coordinates: Array,
    nodes: ArrayLike | None = None,
) -> Array:
    """Von Mises equivalent strain (t, N): as von_mises_history, with the same parameters and errors."""
    if isinstance(body, ReducedBody):
        return strain_modes(body, model, nodes).von_mises(coordinates)
    return _measured(body, strain_recovery(model), von_mises_strain, coordinates, nodes)


def stress_history(
    body: ReducedBody | FullBody | IntrinsicBody,
    model: FiniteElementModel,
    coordinates: Array,
    nodes: ArrayLike,
) -> Array:
    """Stress (t, N, l, 6), xx yy zz yz xz xy in the body's axes, of l layers: as von_mises_history.

    l = 1 of solids, 3 of shells: bottom, middle, top.
    """
    if isinstance(body, ReducedBody):
        return stress_modes(body, model, nodes).at(coordinates)
    return np.array(list(_fields(body, stress_recovery(model), coordinates, nodes)))


def strain_history(
    body: ReducedBody | FullBody | IntrinsicBody,
    model: FiniteElementModel,
    coordinates: Array,
    nodes: ArrayLike,
) -> Array:
    """Strain (t, N, l, 6) with engineering shears: as stress_history."""
    if isinstance(body, ReducedBody):
        return strain_modes(body, model, nodes).at(coordinates)
    return np.array(list(_fields(body, strain_recovery(model), coordinates, nodes)))


def _measured(
    body: ReducedBody | FullBody | IntrinsicBody,
    recovery: StressRecovery,
    measure: Callable[[Array], Array],
    coordinates: Array,
    nodes: ArrayLike | None,
) -> Array:
    return np.array([measure(field).max(axis=1) for field in _fields(body, recovery, coordinates, nodes)])


def _fields(
    body: ReducedBody | FullBody | IntrinsicBody,
    recovery: StressRecovery,
    coordinates: Array,
    nodes: ArrayLike | None,
) -> Iterator[Array]:
    """(N, l, 6) at one instant after the other, for all of them would not fit in memory.

    Of an intrinsic body: of the linear displacements of its modes, into which only strains, and so section
    loads, enter.
    """
    chosen = slice(None) if nodes is None else node_numbers(nodes, len(body.nodes))
    if isinstance(body, IntrinsicBody):
        linear = recovery.linearized()
        yield from (linear.at_nodes(body.nodal_basis @ q)[chosen] for q in np.asarray(coordinates))
        return
    if body.is_linear:
        recovery = recovery.linearized()
    d = body.dofs_per_node if isinstance(body, ReducedBody) else body.body.dofs_per_node
    expansion = body.nodal_basis if isinstance(body, ReducedBody) else body.body.expansion
    interfaces = body.interfaces
    recovery = tied_recovery(recovery, body.nodes, d, interfaces)
    for q in np.asarray(coordinates):
        nodal = with_virtual_freedoms(expansion @ q, [i.motion @ q for i in interfaces], interfaces, d)
        yield recovery.at_nodes(nodal)[chosen]
