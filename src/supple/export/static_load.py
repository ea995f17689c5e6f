"""Nodal loads on a body at one instant, for a static analysis in another program."""

from __future__ import annotations

from collections.abc import Iterable

import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from supple.body import FlexibleBody
from supple.equations.nodal_load import nodal_forces, prepared
from supple.errors import ModelError
from supple.machine import BaseAcceleration, NodalLoad
from supple.machine.laws.time_law import check_law_covers
from supple.machine.system import Load

__all__ = ["static_load"]


def static_load(
    body: FlexibleBody,
    loads: Iterable[Load] = (),
    *,
    time: float = 0.0,
    rotation: ArrayLike = (0.0, 0.0, 0.0),
    gravity: ArrayLike = (0.0, 0.0, 0.0),
) -> NDArray[np.float64]:
    """Forces and moments on the nodes of a body that is undeformed and at rest, in the axes of its mesh.

    Parameters
    ----------
    loads : NodalLoad           on this body; also base accelerations; laws are evaluated at `time`
    rotation : (3,)             rotation vector of the body, mesh axes to global, rad
    gravity : (3,)              global, m/s^2; its load is the nodal mass matrix of the body times gravity
    Returns
    -------
    float array (N, 3) or (N, 6)    forces, N, and for shells moments, N m

    Raises
    ------
    ModelError      a load on another body; a load at an interface, or a force element: the mesh has no node
                    there; a table that has no value at `time`
    """
    loads = tuple(loads)
    for load in loads:
        if isinstance(load, BaseAcceleration | NodalLoad):
            check_law_covers(load.label, load.law, time)
    bases = [np.asarray(load.law(time)) for load in loads if isinstance(load, BaseAcceleration)]
    turn = Rotation.from_rotvec(np.asarray(rotation, dtype=float)).as_matrix()
    fall = np.zeros((len(body.nodes), body.dofs_per_node))
    fall[:, :3] = (np.asarray(gravity, dtype=float) - sum(bases)) @ turn
    total = (body.nodal_mass @ fall.ravel()).reshape(fall.shape)
    for load in loads:
        if isinstance(load, BaseAcceleration):
            continue
        if not isinstance(load, NodalLoad) or not load.nodes.size:
            raise ModelError(
                f"body '{body.name}': {getattr(load, 'label', type(load).__name__)} acts at an interface, "
                "and a mesh has no node there; give the load a node set"
            )
        if load.body != body.name:
            raise ModelError(
                f"{load.label} acts on body '{load.body}', not on '{body.name}': give the loads of one body"
            )
        forces = nodal_forces(prepared(load), jnp.asarray(body.nodes[load.nodes]), jnp.asarray(turn), time)
        np.add.at(total[:, :3], load.nodes, np.asarray(forces))
    return total
