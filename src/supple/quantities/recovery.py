"""Positions of nodes in space, and their displacements as an observer on moving axes sees them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.body import BodyForm
from supple.integrate.motion import FloatingMotion

__all__ = ["displacement_from_axes", "node_positions"]

Array = NDArray[np.float64]


def node_positions(body: BodyForm, motion: FloatingMotion, nodes: ArrayLike | slice = slice(None)) -> Array:
    """Positions of some nodes, or all, in space, as the body's form has them.

    Parameters
    ----------
    nodes : node numbers (k,), all by default

    Returns
    -------
    array (t, k, 3)

    Raises
    ------
    ModelError  a node number outside the body
    Source: [Wu2019] (1)
    """
    return body.positions(motion, nodes)


def displacement_from_axes(positions: Array, origin: ArrayLike, rotation: Array, rest: ArrayLike) -> Array:
    """Displacement A^T (r - R) - q_0 of a point against moving axes, as an observer on them sees it.

    The tip displacement of [Wu2019] (51) is the tip's against the axes of the driven root, in whichever
    floating frame the body was computed.

    Parameters
    ----------
    positions : array (t, 3)      r, in space
    origin : array (3,) or (t, 3)  R
    rotation : array (t, 3, 3)    A, axes to space
    rest : array (3,)             q_0, where the undeformed point lies in the axes

    Returns
    -------
    array (t, 3)
    """
    return np.einsum("tji,tj->ti", rotation, positions - np.asarray(origin)) - np.asarray(rest)
