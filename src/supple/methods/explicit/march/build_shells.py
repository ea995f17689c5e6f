"""Triangle blocks of explicit shells in the model, and the triads at their nodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.errors import ModelError
from supple.machine import Placed, Support, System
from supple.methods.explicit.elements import LayerArrays, shell_block
from supple.methods.explicit.explicit_shell import ExplicitShell, ShellElements
from supple.methods.explicit.march.element_block import TriangleArrays, Triangles
from supple.methods.explicit.march.turning_nodes import Spins, TriadState

__all__ = ["Shells", "explicit_shells"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Shells:
    """Blocks of shells; parts that share a node share its triad.

    place : (N,)    number of the triad of each node of the model; -1 for a node without triad
    mass : (N,) of the nodes, kg;   damped : (N,) mass times the damping alpha of its part
    inertia : (r,) of the triads, kg m^2;   turned : (r,) inertia times alpha
    rates : (3, r) of the triads at the start;   spans : the blocks of each part, by its name
    rules : law and deletion of each block
    """

    place: IntArray
    mass: FloatArray
    damped: FloatArray
    inertia: FloatArray
    turned: FloatArray
    rates: FloatArray
    blocks: list[TriangleArrays] = field(default_factory=list)
    spans: dict[str, slice] = field(default_factory=dict)
    rules: list[Triangles] = field(default_factory=list)

    @property
    def step_limit(self) -> float:
        """Step limit of all triangles at rest, s; infinite if there are no triangles."""
        return min((float(own.limit.min()) for own in self.blocks), default=np.inf)

    def start(self) -> TriadState:
        """The triads at the start: the identity, whatever the rotations of the parts that share them."""
        rates = jnp.asarray(self.rates)
        triads = jnp.broadcast_to(jnp.eye(3)[:, :, None], (3, *rates.shape))
        return TriadState(triads, rates, jnp.zeros_like(rates))

    def spins(self, supports: Sequence[Support], numbers: Mapping[str, IntArray], system: System) -> Spins:
        """Constants of the triads; angular velocities about fixed axes are set to zero."""
        free = np.ones((3, len(self.inertia)))
        for support in supports:
            held = self.place[numbers[support.nodes.body][system.node_numbers(support.nodes)]]
            for axis in (axis - 3 for axis in support.axes if axis >= 3):
                free[axis, held] = 0.0
        self.rates[:] *= free
        return Spins(jnp.asarray(self.inertia), jnp.asarray(self.turned / self.inertia), jnp.asarray(free))


def explicit_shells(parts: Sequence[Placed], numbers: Mapping[str, IntArray], n_nodes: int) -> Shells:
    """Blocks of the shells among explicit parts; `numbers` maps their nodes to the n_nodes of the model."""
    chosen = [(part, part.body) for part in parts if isinstance(part.body, ExplicitShell)]
    place = np.full(n_nodes, -1)
    turning = np.unique(
        np.concatenate([numbers[body.name] for _, body in chosen] or [np.empty(0, dtype=int)])
    )
    place[turning] = np.arange(len(turning))
    r = len(turning)
    made = Shells(
        place,
        np.zeros(n_nodes),
        np.zeros(n_nodes),
        np.zeros(r),
        np.zeros(r),
        np.zeros((3, r)),
    )
    known = np.zeros(r, dtype=bool)
    for part, body in chosen:
        own = numbers[body.name]
        alpha = 0.0 if body.damping is None else body.damping.alpha
        np.add.at(made.mass, own, body.masses)
        np.add.at(made.damped, own, alpha * body.masses)
        np.add.at(made.inertia, place[own], body.inertias)
        np.add.at(made.turned, place[own], alpha * body.inertias)
        _check_spin(part, made.rates[:, place[own][known[place[own]]]])
        made.rates[:, place[own]] = (part.rotation @ part.twist[3:])[:, None]
        known[place[own]] = True
        made.spans[body.name] = slice(len(made.blocks), len(made.blocks) + len(body.elements))
        for each in body.elements:
            nodes = own[each.nodes]
            turn = np.kron(np.eye(6), part.rotation)
            block = shell_block(
                nodes,
                place[nodes],
                each.corners @ part.rotation.T,
                turn @ each.stiffness @ turn.T,
                each.to_stress @ turn.T,
                n_nodes,
                r,
                None if body.law is None else _layers(each, body.layers, turn),
            )
            made.blocks.append(TriangleArrays(block, jnp.asarray(each.step_limits)))
            made.rules.append(Triangles(body.law, body.deletion))
    return made


def _check_spin(part: Placed, rates: FloatArray) -> None:
    """Raise ModelError for a shell whose angular velocity is not that of its shared triads, rates (3, n)."""
    spin = (part.rotation @ part.twist[3:])[:, None]
    apart = float(np.linalg.norm(rates - spin, axis=0).max(initial=0.0))
    if apart > 1e-6 * max(float(np.abs(rates).max(initial=0.0)), float(np.abs(spin).max())):
        raise ModelError(
            f"shell '{part.body.name}' is tied to another shell, so that both rotate equally, but their "
            f"initial angular velocities differ by {apart:.3g} rad/s; give both the same, in global axes"
        )


def _layers(of: ShellElements, count: int, turn: FloatArray) -> LayerArrays:
    """Gauss points through the thickness, exact for stress linear through it, such as elastic stress.

    turn : (18, 18) displacements and rotations in the axes of space from those in the axes of the mesh
    """
    places, weights = np.polynomial.legendre.leggauss(count)
    return LayerArrays(
        jnp.asarray((of.membrane @ turn.T).transpose(1, 2, 0)),
        jnp.asarray((of.bending @ turn.T).transpose(1, 2, 3, 0)),
        jnp.asarray((turn @ of.drilling @ turn.T).transpose(1, 2, 0)),
        jnp.asarray(of.area),
        jnp.asarray(0.5 * of.thickness * places),
        jnp.asarray(0.5 * of.thickness * weights),
    )
