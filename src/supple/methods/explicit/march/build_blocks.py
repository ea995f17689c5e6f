"""Element blocks of explicit parts in the model, the lumped mass of the nodes, and the triads of shells."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import jax.numpy as jnp
import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.errors import ModelError
from supple.machine import Placed, System
from supple.methods.explicit.elements import LayerArrays, ShellBlock, SolidBlock, incidence, triangle_axes
from supple.methods.explicit.elements.solid_points import hourglass_stiffness
from supple.methods.explicit.explicit_shell import ExplicitShell, ShellElements
from supple.methods.explicit.explicit_subdomain import ExplicitSubdomain
from supple.methods.explicit.march.turning_nodes import Spins, TriadState


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks of elements; shells that share a node share its triad.

    spans : the blocks of each part, by its name
    mass : (N,) of the nodes, kg;   damped : (N,) mass times the damping alpha of its part
    place : (N,)    number of the triad of each node of the model; -1 for a node without triad
    inertia : (r,) of the triads, kg m^2;   turned : (r,) inertia times alpha
    rates : (3, r) of the triads at the start
    """

    mass: FloatArray
    damped: FloatArray
    place: IntArray
    inertia: FloatArray
    turned: FloatArray
    rates: FloatArray
    blocks: list[SolidBlock | ShellBlock] = field(default_factory=list)
    spans: dict[str, slice] = field(default_factory=dict)

    @property
    def step_limit(self) -> float:
        """Step limit of all elements at rest, s; infinite without any."""
        return min((float(own.limit.min()) for own in self.blocks), default=np.inf)

    def triads(self) -> TriadState:
        """The triads at the start: the identity, whatever the rotations of the parts that share them."""
        rates = jnp.asarray(self.rates)
        triads = jnp.broadcast_to(jnp.eye(3)[:, :, None], (3, *rates.shape))
        return TriadState(triads, rates, jnp.zeros_like(rates))

    def spins(self, numbers: Mapping[str, IntArray], system: System) -> Spins:
        """Constants of the triads; angular velocities about fixed axes are set to zero."""
        free = np.ones((3, len(self.inertia)))
        for support in system.supports:
            held = self.place[numbers[support.nodes.body][system.node_numbers(support.nodes)]]
            for axis in (axis - 3 for axis in support.axes if axis >= 3):
                free[axis, held] = 0.0
        self.rates[:] *= free
        return Spins(jnp.asarray(self.inertia), jnp.asarray(self.turned / self.inertia), jnp.asarray(free))


def explicit_blocks(parts: Sequence[Placed], numbers: Mapping[str, IntArray], n_nodes: int) -> Blocks:
    """Blocks of explicit parts; `numbers` maps the nodes of each part to the n_nodes of the model."""
    shells = [part.body.name for part in parts if isinstance(part.body, ExplicitShell)]
    turning = np.unique(np.concatenate([numbers[name] for name in shells] or [np.empty(0, dtype=int)]))
    place, r = np.full(n_nodes, -1), len(turning)
    place[turning] = np.arange(r)
    made = Blocks(np.zeros(n_nodes), np.zeros(n_nodes), place, np.zeros(r), np.zeros(r), np.zeros((3, r)))
    known = np.zeros(r, dtype=bool)
    for part in sorted(parts, key=lambda part: part.body.name in shells):
        body, own, before = part.body, numbers[part.body.name], len(made.blocks)
        assert isinstance(body, ExplicitSubdomain | ExplicitShell)
        alpha = 0.0 if body.damping is None else body.damping.alpha
        np.add.at(made.mass, own, body.masses)
        np.add.at(made.damped, own, alpha * body.masses)
        if isinstance(body, ExplicitSubdomain):
            made.blocks.extend(_solids(part, body, own, n_nodes))
        else:
            triads = place[own]
            np.add.at(made.inertia, triads, body.inertias)
            np.add.at(made.turned, triads, alpha * body.inertias)
            _check_spin(part, made.rates[:, triads[known[triads]]])
            made.rates[:, triads] = (part.rotation @ part.twist[3:])[:, None]
            known[triads] = True
            made.blocks.extend(_triangles(part, body, own, place, r))
        made.spans[body.name] = slice(before, len(made.blocks))
    return made


def _solids(part: Placed, body: ExplicitSubdomain, own: IntArray, n_nodes: int) -> Iterator[SolidBlock]:
    beta = 0.0 if body.damping is None else body.damping.beta
    for points, limit, bulk in zip(body.points, body.element_limits, body.bulk_arrays, strict=True):
        nodes = own[points.nodes.T]
        gradients = (points.gradients.swapaxes(2, 3) @ part.rotation.T).transpose(2, 3, 1, 0)
        yield SolidBlock(
            nodes=jnp.asarray(nodes),
            gradients=jnp.asarray(np.ascontiguousarray(gradients)),
            volumes=jnp.asarray(points.volumes.T),
            gamma=jnp.asarray(np.ascontiguousarray(points.gamma.transpose(1, 2, 0))),
            hourglass=jnp.asarray(hourglass_stiffness(points, body.law.elastic, body.hourglass)),
            table=jnp.asarray(incidence(nodes, n_nodes)),
            bulk=bulk,
            limit=jnp.asarray(limit),
            beta=jnp.asarray(beta) if beta else None,
            law=body.law,
            deletion=body.deletion,
        )


def _triangles(
    part: Placed, body: ExplicitShell, own: IntArray, place: IntArray, n_triads: int
) -> Iterator[ShellBlock]:
    turn = np.kron(np.eye(6), part.rotation)
    for each in body.elements:
        nodes, corners = own[each.nodes].T, (each.corners @ part.rotation.T).transpose(2, 1, 0)
        yield ShellBlock(
            nodes=jnp.asarray(nodes),
            spins=jnp.asarray(place[nodes]),
            rest=jnp.asarray(corners - corners.mean(axis=1, keepdims=True)),
            axes=triangle_axes(jnp.asarray(corners)),
            stiffness=jnp.asarray((turn @ each.stiffness @ turn.T).transpose(1, 2, 0)),
            to_stress=jnp.asarray((each.to_stress @ turn.T).transpose(1, 2, 3, 0)),
            node_table=jnp.asarray(incidence(nodes, len(place))),
            spin_table=jnp.asarray(incidence(place[nodes], n_triads)),
            limit=jnp.asarray(each.step_limits),
            layers=None if body.law is None else _layers(each, body.layers, turn),
            law=body.law,
            deletion=body.deletion,
        )


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
