"""Interfaces: where a body meets joints and loads, each with the six freedoms of a virtual node."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse


@dataclass(frozen=True, eq=False)
class RigidInterface:
    """Nodes that move as one rigid body with a virtual node (RBE2): u_a = u_v + theta_v x (x_a - x_v).

    On shells the nodes also turn with it, theta_a = theta_v. Their own freedoms are eliminated.

    nodes    : name of a node set, or node numbers
    position : (3,) of the virtual node; the centroid of the nodes when omitted
    """

    name: str
    nodes: str | ArrayLike
    position: ArrayLike | None = None


@dataclass(frozen=True, eq=False)
class AveragingInterface:
    """A virtual node that follows the mean rigid motion of its nodes (RBE3), adding no stiffness.

    The mean is a weighted least-squares fit; see `averaged_motion`.

    nodes    : name of a node set, or node numbers
    position : (3,) of the virtual node; the weighted centroid of the nodes when omitted
    weights  : (k,) positive, one per node; equal when omitted. Where the mesh is uneven, give nodal areas.
    """

    name: str
    nodes: str | ArrayLike
    position: ArrayLike | None = None
    weights: ArrayLike | None = None


@dataclass(frozen=True, eq=False)
class BodyInterface:
    """A virtual node of a body: its place, and its motion as a linear map of the body's coordinates.

    position : (3,) in the mesh axes
    motion   : csr (6, n), q_v = (u_v, theta_v) = motion @ q
    node_ids : (k,) nodes it is made of
    """

    name: str
    position: NDArray[np.float64]
    motion: sparse.csr_array
    node_ids: NDArray[np.int64]
