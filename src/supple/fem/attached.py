"""Springs, masses and dashpots at the nodes of a model, and its ties."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csc_array, csr_array

from supple.arrays import FloatArray, IntArray
from supple.fem.quadratic_strain import QuadraticStrain

__all__ = ["Attached", "Constraints", "RigidPiece", "linear_strains"]


@dataclass(frozen=True, eq=False)
class RigidPiece:
    """Nodes tied rigidly, to second order in their rotation.

    nodes : (k,) including the reference node, which all follow;  position : (3,) of the reference node, m
    """

    name: str
    nodes: IntArray
    position: FloatArray


@dataclass(frozen=True, eq=False)
class Constraints:
    """Linear constraints C u = 0 of the nodal freedoms u.

    matrix : C, csr (m, n)
    dependent : (m,) the freedom that each row should eliminate, or -1
    labels : name of each row in messages
    """

    matrix: csr_array
    dependent: IntArray
    labels: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Attached:
    """Springs, masses, dashpots and ties beside the cells of a model, in nodal freedoms u.

    springs : as strains without a quadratic part: they have linear stiffness only
    mass : csc (n, n), kg, kg m and kg m^2; None if there are no masses
    damping : csc (n, n), N s/m, N s and N m s; None if there are no dashpots
    rigid : pieces; a node in several pieces joins them into one
    constraints : further constraints of u, besides the rigid pieces
    """

    springs: tuple[QuadraticStrain, ...] = field(default=(), repr=False)
    mass: csc_array | None = field(default=None, repr=False)
    damping: csc_array | None = field(default=None, repr=False)
    rigid: tuple[RigidPiece, ...] = ()
    constraints: Constraints | None = field(default=None, repr=False)

    @property
    def what(self) -> str:
        """The kinds of attachments present, for messages; empty if there are none."""
        there = {
            "springs": bool(self.springs),
            "concentrated masses": self.mass is not None,
            "dashpots": self.damping is not None,
            "rigid ties": bool(self.rigid),
            "constraints": self.constraints is not None,
        }
        return ", ".join(name for name, is_there in there.items() if is_there)


def linear_strains(
    terms: Sequence[tuple[IntArray, FloatArray, FloatArray]], dofs_per_node: int
) -> tuple[QuadraticStrain, ...]:
    """Springs as strains; the energy of each spring is 1/2 sum_i k_i (B_i u)^2.

    terms : (freedoms (n,), B (s, n), k (s,)) each; k may be negative, as in a condensed matrix
    Returns one QuadraticStrain per group of springs with equal numbers of nodes and of rows of B; in all
    freedoms of their nodes.
    """
    alike: dict[tuple[int, int], list[tuple[IntArray, FloatArray, FloatArray]]] = {}
    for freedoms, B, k in terms:
        nodes, place = np.unique(freedoms // dofs_per_node, return_inverse=True)
        wide = np.zeros((len(k), len(nodes) * dofs_per_node))
        np.add.at(wide.T, place * dofs_per_node + freedoms % dofs_per_node, B.T)
        alike.setdefault((len(nodes), len(k)), []).append((nodes, wide, k))
    made = []
    for own in alike.values():
        nodes = np.array([each[0] for each in own])
        dofs = (nodes[:, :, None] * dofs_per_node + np.arange(dofs_per_node)).reshape(len(own), -1)
        B = np.array([each[1] for each in own])[:, None]
        D = np.array([np.diag(each[2]) for each in own])
        made.append(
            QuadraticStrain(
                dofs=dofs,
                B=B,
                G=np.zeros((len(own), 1, 1, dofs.shape[1])),
                N=np.zeros((B.shape[2], 1, 1)),
                D=D,
                w=np.ones((len(own), 1)),
            )
        )
    return tuple(made)
