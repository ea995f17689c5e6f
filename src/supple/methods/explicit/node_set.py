"""Node sets as interfaces of a part in an explicit run; a modal part also has the interfaces of its body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray
from supple.body.body_form import BodyForm
from supple.body.interface import UntiedInterface
from supple.body.point_motion import InterfaceMotion, NodeMotion
from supple.body.rigid_motion import averaged_motion


@dataclass(frozen=True, eq=False)
class NodeSet(UntiedInterface):
    """Node set as an interface: it moves as the mean of its nodes, which share its force equally.

    part : the body of these nodes
    nodes : (n,) numbers of the nodes;   position : (3,) their mean position, undeformed, in the mesh axes
    rows : (6, r)       displacement and rotation per coordinate of the part; None: the mean of the nodes
    """

    part: BodyForm
    name: str
    nodes: NDArray[np.int64]
    position: FloatArray
    rows: FloatArray | None = None

    @property
    def averaging(self) -> FloatArray:
        """(6, n, 3): mean displacement, and best-fit rotation, per displacement of each node."""
        return averaged_motion(self.part.nodes[self.nodes], np.ones(len(self.nodes)), self.position, 3)

    @property
    def motion(self) -> FloatArray:
        """Displacement and rotation per coordinate of the part, (6, r)."""
        if self.rows is not None:
            return self.rows
        unit = np.eye(self.part.n_coordinates)
        return np.einsum("ank,rnk->ar", self.averaging, self.part.expand(unit, self.nodes), optimize=True)

    def moving(self, nodes: NodeMotion) -> InterfaceMotion:
        """Motion of the set from that of its nodes: the mean, and the best-fit rotation and angular velocity.

        max tr(A^T H),   H = sum (x - x_m) (X - X_m)^T     (Kabsch 1976)
        J w = sum (x - x_m) x (v - v_m)

        with the means x_m, X_m, v_m over the nodes, and the inertia tensor J of the nodes with unit masses.
        """
        position, velocity, acceleration = (each.mean(axis=1) for each in nodes)
        arms, rates = nodes.position - position[:, None], nodes.velocity - velocity[:, None]
        left, _, right = np.linalg.svd(
            np.einsum("tni,nj->tij", arms, self.part.nodes[self.nodes] - self.position)
        )
        left[:, :, 2] *= np.linalg.det(left @ right)[:, None]
        spread = np.einsum("tni,tnj->tij", arms, arms)
        J = np.trace(spread, axis1=1, axis2=2)[:, None, None] * np.eye(3) - spread
        spin = np.einsum("tij,tj->ti", np.linalg.pinv(J, rcond=1e-9), np.cross(arms, rates).sum(axis=1))
        return InterfaceMotion(position, left @ right, velocity, acceleration, spin)


def node_sets(part: BodyForm, sets: Mapping[str, NDArray[np.int64]]) -> tuple[NodeSet, ...]:
    """Interfaces of a part on its node sets, without empty ones."""
    known = {name: np.asarray(nodes) for name, nodes in sets.items() if len(nodes)}
    return tuple(NodeSet(part, name, nodes, part.nodes[nodes].mean(axis=0)) for name, nodes in known.items())
