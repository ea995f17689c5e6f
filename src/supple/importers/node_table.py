"""The labelled nodes and connections of a mesh file without its elements, for matrices of the same model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from supple.arrays import FloatArray, IntArray

__all__ = ["Connection", "NodeTable"]


@dataclass(frozen=True, eq=False)
class Connection:
    """Nodes tied to a reference point: rigidly (RBE2), or on average with `weights` (RBE3).

    name     : rbe2_ID or rbe3_ID
    nodes    : (k,) numbers of the nodes
    position : (3,) of the reference point
    weights  : (k,) of an averaging connection; None for a rigid one
    """

    name: str
    nodes: IntArray
    position: FloatArray
    weights: FloatArray | None


@dataclass(frozen=True, eq=False)
class NodeTable:
    """Nodes with their ids, positions and sets.

    source      : the file, for messages
    ids         : (N,) labels
    positions   : (N, 3)
    axes        : (N, 3, 3) directions of the freedoms as columns; None if all are the global axes
    node_sets   : {name: (k,) node numbers from 0}
    connections : rigid and averaging elements
    retained    : (n, 2) node id and component (1 to 6, 0 of scalar points) of an analysis set (ASET, QSET),
                  sorted; None without one
    modal       : (k, 2) node id and component of the modal coordinates (QSET, SPOINT)
    """

    source: str
    ids: IntArray
    positions: FloatArray
    axes: FloatArray | None = None
    node_sets: Mapping[str, IntArray] = field(default_factory=dict)
    connections: tuple[Connection, ...] = ()
    retained: IntArray | None = None
    modal: IntArray = field(default_factory=lambda: np.empty((0, 2), dtype=np.int64))
