"""Block of flat shell triangles: the library's linear element in a frame that rotates with its corners.

    U = 1/2 d^T K d,    d = [T (x - x_c) - (X - X_c);  log(T R)],    T = A_0^T A

with the axes of the triangle at rest, A_0, and at present, A (along its first side, across, normal), nodal
triads R (the identity at rest), and the stiffness K of the undeformed element. Strains are small, rotations
of any size. Force and moment are the exact gradient of U. U is invariant under rigid motion, so momentum is
conserved. log uses the arcsine series; its error is 1e-5 rad for 0.3 rad between a node and its element.

Where the material yields, the stress at layers through the thickness replaces K. With the membrane strain
B_m d, the curvature B_b d at the three mid-sides p, and the layers z_l of weight w_l,

    f_d = sum_pl A/3 w_l (B_m + z_l B_b)^T sigma_pl + K_h d,     sigma_pl in plane stress

with the elastic stiffness K_h of the drilling rotations. Force and moment follow as above, from the work
f_d . delta d. The total strain from the triangle at rest, including plastic strain, must stay small.

Source of the corotational form: T. Belytschko, B. J. Hsieh, Int. J. Numer. Methods Eng. 7 (1973) 255-271.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from supple.methods.explicit.elements.element_block import BlockState, ElementInstant, Forces, with_contact
from supple.methods.explicit.elements.incidence import gathered
from supple.methods.explicit.materials.j2_plasticity import J2Plasticity
from supple.methods.explicit.materials.plane_stress import elastic_state, mises_of, plane_stress

__all__ = ["LayerArrays", "ShellBlock", "triangle_axes"]

_COLLAPSED = 0.05
"""Smallest stretch that shortens the step: a collapsed triangle would need endless steps."""


class LayerArrays(NamedTuple):
    """Arrays of E triangles that yield, elements last, and their l layers.

    membrane : (3, 18, E), bending : (p, 3, 18, E)      strain xx yy xy and curvature from d, at p points
    drilling : (18, 18, E) K_h;   area : (E,)
    heights, weights : (l,) m; the weights sum to the thickness
    """

    membrane: Array
    bending: Array
    drilling: Array
    area: Array
    heights: Array
    weights: Array


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class ShellBlock:
    """Constant arrays of E triangles, elements last.

    nodes, spins : (3, E)       numbers of nodes and of triads
    rest : (3, 3, E)            corners about their centre (component, corner);   axes : (3, 3, E) A_0 in rows
    stiffness : (18, 18, E)     ux uy uz rx ry rz of each node, axes of space at rest
    to_stress : (l, 6, 18, E)   stress in l layers from d, Pa
    node_table, spin_table      element corners at each node and triad, see `incidence`
    limit : (E,)                step limits at rest, s
    layers : LayerArrays        None for a block that does not yield, as the law
    """

    nodes: Array
    spins: Array
    rest: Array
    axes: Array
    stiffness: Array
    to_stress: Array
    node_table: Array
    spin_table: Array
    limit: Array
    layers: LayerArrays | None
    law: J2Plasticity | None = field(metadata={"static": True})
    deletion: float = field(metadata={"static": True})

    beta: ClassVar[None] = None

    def start(self) -> BlockState:
        """Undeformed state."""
        n, own = self.nodes.shape[1], self.layers
        state = None if own is None else elastic_state((len(own.bending), len(own.heights), n))
        return BlockState(state, None, jnp.ones(n))

    def force(self, at: ElementInstant, state: BlockState) -> Forces:
        """Force and moment; elements that reach the deletion strain are then deleted."""
        corners, turned = at.x[:, self.nodes], at.triads[:, :, self.spins]
        d, pulled_back = jax.vjp(
            lambda here, turn: self._deformation(here, turned + jnp.cross(turn[:, None], turned, axis=0)),
            corners,
            jnp.zeros_like(corners),
        )
        if self.law is None or self.layers is None:
            on_d, plastic = jnp.einsum("abe,be->ae", self.stiffness, d), None
        else:
            on_d, plastic, state = self._layered_force(self.law, self.layers, d, state)
        on_nodes, on_triads = pulled_back(on_d)
        return Forces(
            gathered(-on_nodes, self.node_table),
            state,
            moment=gathered(-on_triads, self.spin_table),
            plastic=plastic,
        )

    def _layered_force(
        self, law: J2Plasticity, own: LayerArrays, d: Array, state: BlockState
    ) -> tuple[Array, Array, BlockState]:
        """Force f_d (18, E), plastic work of the step, J, and the new state."""
        stress, layers, work = plane_stress(law, _layer_strain(own, d), state.material)
        volumes = (state.alive * own.area / len(own.bending)) * own.weights[:, None]  # (l, E) of each point
        forces = (volumes * stress).sum(axis=2)  # (3, p, E)
        moments = (volumes * own.heights[:, None] * stress).sum(axis=2)
        on_d = (own.membrane * forces.sum(axis=1)[:, None]).sum(axis=0)
        on_d = on_d + (own.bending * moments.swapaxes(0, 1)[:, :, None]).sum(axis=(0, 1))
        on_d = on_d + state.alive * (own.drilling * d).sum(axis=1)
        alive = state.alive
        if self.deletion != float("inf"):
            alive = alive * (layers.strain.max(axis=(0, 1)) < self.deletion)
        return on_d, jnp.sum(volumes * work), BlockState(layers, None, alive)

    def longest_step(self, x: Array, _v: Array, alive: Array, contact_rate: Array) -> Array:
        """Step limit of the remaining triangles in their present state, s, with all contacts closed.

        Bending stiffness acts through the rotation of a triangle by the motion of its corners, which is
        inversely proportional to its height.
        """
        longest = with_contact(self.limit * jnp.clip(self.stretch(x), _COLLAPSED, 1.0), contact_rate)
        return jnp.min(jnp.where(alive > 0, longest, jnp.inf))

    def recorded(self, x: Array, triads: Array, state: BlockState) -> tuple[Array, Array]:
        """Plastic strain and von Mises stress, Pa, (E,) at the worst point and layer of each element."""
        d = self._deformation(x[:, self.nodes], triads[:, :, self.spins])
        if self.law is None or self.layers is None:
            xx, yy, zz, yz, xz, xy = jnp.moveaxis(jnp.einsum("lcae,ae->lce", self.to_stress, d), 1, 0)
            normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
            mises = jnp.sqrt(0.5 * normal + 3 * (yz**2 + xz**2 + xy**2)).max(axis=0)
            return jnp.zeros_like(state.alive), mises
        stress, _, _ = plane_stress(self.law, _layer_strain(self.layers, d), state.material)
        return state.material.strain.max(axis=(0, 1)), state.alive * mises_of(stress).max(axis=(0, 1))

    def stretch(self, x: Array) -> Array:
        """Smallest stretch (E,) in the plane of each triangle, at positions x (3, N)."""
        (aa, ab, bb), now = _metric(self.rest), _metric(x[:, self.nodes])
        # Cauchy-Green tensor in axes along the first side at rest and across it.
        share, across = ab / aa, bb - ab**2 / aa
        along = now[0] / aa
        mixed = (now[1] - share * now[0]) / jnp.sqrt(aa * across)
        other = (now[2] - 2 * share * now[1] + share**2 * now[0]) / across
        smallest = 0.5 * (along + other) - jnp.sqrt(0.25 * (along - other) ** 2 + mixed**2)
        return jnp.sqrt(jnp.maximum(smallest, 0.0))

    def _deformation(self, corners: Array, turned: Array) -> Array:
        """Displacements and rotations (18, E) relative to the element's frame, in axes of space at rest."""
        back = jnp.einsum("rie,rje->ije", self.axes, triangle_axes(corners))
        about = corners - corners.mean(axis=1, keepdims=True)
        moved = jnp.einsum("ije,jke->ike", back, about) - self.rest
        turn = jnp.einsum("ije,jmke->imke", back, turned)
        sine = 0.5 * jnp.stack([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        square = (sine * sine).sum(axis=0)
        angle = sine * (1 + square / 6 + 3 * square**2 / 40)
        return jnp.concatenate([moved, angle]).swapaxes(0, 1).reshape(18, -1)


def _layer_strain(own: LayerArrays, d: Array) -> Array:
    """Strain xx yy xy (3, p, l, E) from d (18, E)."""
    stretch = (own.membrane * d).sum(axis=1)
    curved = (own.bending * d).sum(axis=2).swapaxes(0, 1)
    return stretch[:, None, None] + own.heights[:, None] * curved[:, :, None]


def _metric(corners: Array) -> tuple[Array, Array, Array]:
    """Scalar products a.a, a.b, b.b of two sides of triangles (3, 3, E)."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return (a * a).sum(axis=0), (a * b).sum(axis=0), (b * b).sum(axis=0)


def triangle_axes(corners: Array) -> Array:
    """Axes (3, 3, E), in rows, of triangles (3, 3, E): first side, across, normal."""
    side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    first = side / jnp.sqrt((side * side).sum(axis=0))
    normal = jnp.cross(side, other, axis=0)
    normal = normal / jnp.sqrt((normal * normal).sum(axis=0))
    return jnp.stack([first, jnp.cross(normal, first, axis=0), normal])
