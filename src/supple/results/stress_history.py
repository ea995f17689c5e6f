"""Von Mises stress and strain over time of any elastic body, reduced or full."""

from __future__ import annotations

from collections.abc import Callable

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
from supple.reduction import ReducedBody
from supple.results.stress_modes import strain_modes, stress_modes
from supple.results.tied_recovery import tied_recovery, with_virtual_freedoms

Array = NDArray[np.float64]


def von_mises_history(
    body: ReducedBody | FullBody,
    model: FiniteElementModel,
    coordinates: Array,
    nodes: ArrayLike | None = None,
) -> Array:
    """Von Mises stress (t, N), Pa, the largest over the layers, of coordinates (t, r).

    A reduced body goes through its stress modes; the reference, a full body, is recovered one vector at a
    time. Elements beside rigid interfaces have the strain that their ties leave them. A linear body has the
    stress of its linear strain.

    Parameters
    ----------
    model : FiniteElementModel      the one the body was made of
    nodes : int array (N,)          numbers of the nodes of interest; all of them when omitted

    Raises
    ------
    ModelError   as for stress_modes
    """
    if body.kind == "reduced":
        return stress_modes(body, model, nodes).von_mises(coordinates)
    return _of_full_body(body, stress_recovery(model), von_mises, coordinates, nodes)


def von_mises_strain_history(
    body: ReducedBody | FullBody,
    model: FiniteElementModel,
    coordinates: Array,
    nodes: ArrayLike | None = None,
) -> Array:
    """Von Mises equivalent strain (t, N): as von_mises_history, with the same parameters and errors."""
    if body.kind == "reduced":
        return strain_modes(body, model, nodes).von_mises(coordinates)
    return _of_full_body(body, strain_recovery(model), von_mises_strain, coordinates, nodes)


def _of_full_body(
    body: FullBody,
    recovery: StressRecovery,
    measure: Callable[[Array], Array],
    coordinates: Array,
    nodes: ArrayLike | None,
) -> Array:
    chosen = slice(None) if nodes is None else node_numbers(nodes, len(body.nodes))
    if body.is_linear:
        recovery = recovery.linearized()
    flexible, interfaces = body.body, body.interfaces
    recovery = tied_recovery(recovery, flexible.nodes, flexible.dofs_per_node, interfaces)
    nodal = (
        with_virtual_freedoms(
            flexible.expansion @ q, [i.motion @ q for i in interfaces], interfaces, flexible.dofs_per_node
        )
        for q in np.asarray(coordinates)
    )
    return np.array([measure(recovery.at_nodes(u)[chosen]).max(axis=1) for u in nodal])
