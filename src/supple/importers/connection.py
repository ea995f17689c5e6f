"""Connections: nodes that a mesh file ties to a reference point, at which joints and loads can act."""

from __future__ import annotations

from dataclasses import dataclass

from supple.arrays import FloatArray, IntArray

__all__ = ["Connection"]


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
