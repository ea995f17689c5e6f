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

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray

from supple.methods.explicit.elements.incidence import gathered, incidence
from supple.methods.explicit.materials.j2_plasticity import J2Plasticity
from supple.methods.explicit.materials.plane_stress import LayerState, elastic_state, mises_of, plane_stress

__all__ = [
    "LayerArrays",
    "ShellBlock",
    "layered_force",
    "layered_von_mises",
    "rest_layers",
    "shell_block",
    "shell_force",
    "shell_von_mises",
    "triangle_stretch",
]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


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


class ShellBlock(NamedTuple):
    """Constant arrays of E triangles, elements last.

    nodes, spins : (3, E)       numbers of nodes and of triads
    rest : (3, 3, E)            corners about their centre (component, corner);   axes : (3, 3, E) A_0 in rows
    stiffness : (18, 18, E)     ux uy uz rx ry rz of each node, axes of space at rest
    to_stress : (l, 6, 18, E)   stress in l layers from d, Pa
    node_table, spin_table      element corners at each node and triad, see `incidence`
    layers : LayerArrays        None for a block that does not yield
    """

    nodes: Array
    spins: Array
    rest: Array
    axes: Array
    stiffness: Array
    to_stress: Array
    node_table: Array
    spin_table: Array
    layers: LayerArrays | None = None


class ShellForce(NamedTuple):
    """Force (3, N) on the nodes and moment (3, r) on the triads: the negative internal force and moment."""

    force: Array
    moment: Array


class LayeredForce(NamedTuple):
    """Force and moment as in `ShellForce`, state of the layers, and plastic work of the step, J."""

    force: Array
    moment: Array
    state: LayerState
    plastic: Array


def shell_block(
    nodes: IntArray,
    spins: IntArray,
    corners: FloatArray,
    stiffness: FloatArray,
    to_stress: FloatArray,
    n_nodes: int,
    n_spins: int,
    layers: LayerArrays | None = None,
) -> ShellBlock:
    """Block from arrays with elements first: nodes, spins (E, 3) and corners at rest (E, 3, 3)."""
    about = corners - corners.mean(axis=1, keepdims=True)
    axes = np.asarray(_axes(jnp.asarray(corners.transpose(2, 1, 0))))
    return ShellBlock(
        jnp.asarray(nodes.T),
        jnp.asarray(spins.T),
        jnp.asarray(about.transpose(2, 1, 0)),
        jnp.asarray(axes),
        jnp.asarray(stiffness.transpose(1, 2, 0)),
        jnp.asarray(to_stress.transpose(1, 2, 3, 0)),
        jnp.asarray(incidence(nodes.T, n_nodes)),
        jnp.asarray(incidence(spins.T, n_spins)),
        layers,
    )


def shell_force(block: ShellBlock, x: Array, triads: Array) -> ShellForce:
    """Forces at positions x (3, N) and triads (3, 3, r)."""
    corners, turned = x[:, block.nodes], triads[:, :, block.spins]

    def energy(corners: Array, turn: Array) -> Array:
        d = _deformation(block, corners, turned + _crossed(turn, turned))
        return 0.5 * jnp.sum(d * jnp.einsum("abe,be->ae", block.stiffness, d))

    on_nodes, on_triads = jax.grad(energy, argnums=(0, 1))(corners, jnp.zeros_like(corners))
    return ShellForce(gathered(-on_nodes, block.node_table), gathered(-on_triads, block.spin_table))


def rest_layers(block: ShellBlock) -> LayerState:
    """State without plastic strain at any point of any layer, (p, l, E)."""
    assert block.layers is not None
    return elastic_state((len(block.layers.bending), len(block.layers.heights), block.nodes.shape[1]))


def layered_force(
    law: J2Plasticity, block: ShellBlock, x: Array, triads: Array, state: LayerState, alive: Array
) -> LayeredForce:
    """Forces at positions x (3, N) and triads (3, 3, r); alive (E,) 1, or 0 for deleted elements."""
    own = block.layers
    assert own is not None
    corners, turned = x[:, block.nodes], triads[:, :, block.spins]
    d, pulled_back = jax.vjp(
        lambda at, turn: _deformation(block, at, turned + _crossed(turn, turned)),
        corners,
        jnp.zeros_like(corners),
    )
    stress, state, work = plane_stress(law, _layer_strain(own, d), state)
    volumes = (alive * own.area / len(own.bending)) * own.weights[:, None]  # (l, E) of each point
    forces = (volumes * stress).sum(axis=2)  # (3, p, E)
    moments = (volumes * own.heights[:, None] * stress).sum(axis=2)
    on_d = (own.membrane * forces.sum(axis=1)[:, None]).sum(axis=0)
    on_d = on_d + (own.bending * moments.swapaxes(0, 1)[:, :, None]).sum(axis=(0, 1))
    on_d = on_d + alive * (own.drilling * d).sum(axis=1)
    on_nodes, on_triads = pulled_back(on_d)
    return LayeredForce(
        gathered(-on_nodes, block.node_table),
        gathered(-on_triads, block.spin_table),
        state,
        jnp.sum(volumes * work),
    )


def layered_von_mises(
    law: J2Plasticity, block: ShellBlock, x: Array, triads: Array, state: LayerState
) -> Array:
    """Von Mises stress (E,), Pa, the largest of all points and layers."""
    assert block.layers is not None
    d = _deformation(block, x[:, block.nodes], triads[:, :, block.spins])
    stress, _, _ = plane_stress(law, _layer_strain(block.layers, d), state)
    return mises_of(stress).max(axis=(0, 1))


def _layer_strain(own: LayerArrays, d: Array) -> Array:
    """Strain xx yy xy (3, p, l, E) from d (18, E)."""
    stretch = (own.membrane * d).sum(axis=1)
    curved = (own.bending * d).sum(axis=2).swapaxes(0, 1)
    return stretch[:, None, None] + own.heights[:, None] * curved[:, :, None]


def shell_von_mises(block: ShellBlock, x: Array, triads: Array) -> Array:
    """Von Mises stress (E,), the largest of the layers, Pa."""
    d = _deformation(block, x[:, block.nodes], triads[:, :, block.spins])
    xx, yy, zz, yz, xz, xy = jnp.moveaxis(jnp.einsum("lcae,ae->lce", block.to_stress, d), 1, 0)
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return jnp.sqrt(0.5 * normal + 3 * (yz**2 + xz**2 + xy**2)).max(axis=0)


def triangle_stretch(block: ShellBlock, x: Array) -> Array:
    """Smallest stretch (E,) in the plane of each triangle, at positions x (3, N)."""
    (aa, ab, bb), now = _metric(block.rest), _metric(x[:, block.nodes])
    # Cauchy-Green tensor in axes along the first side at rest and across it.
    share, across = ab / aa, bb - ab**2 / aa
    along = now[0] / aa
    mixed = (now[1] - share * now[0]) / jnp.sqrt(aa * across)
    other = (now[2] - 2 * share * now[1] + share**2 * now[0]) / across
    smallest = 0.5 * (along + other) - jnp.sqrt(0.25 * (along - other) ** 2 + mixed**2)
    return jnp.sqrt(jnp.maximum(smallest, 0.0))


def _metric(corners: Array) -> tuple[Array, Array, Array]:
    """Scalar products a.a, a.b, b.b of two sides of triangles (3, 3, E)."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return (a * a).sum(axis=0), (a * b).sum(axis=0), (b * b).sum(axis=0)


def _axes(corners: Array) -> Array:
    """Axes (3, 3, E), in rows, of triangles (3, 3, E): first side, across, normal."""
    side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    first = side / jnp.sqrt((side * side).sum(axis=0))
    normal = jnp.cross(side, other, axis=0)
    normal = normal / jnp.sqrt((normal * normal).sum(axis=0))
    return jnp.stack([first, jnp.cross(normal, first, axis=0), normal])


def _deformation(block: ShellBlock, corners: Array, turned: Array) -> Array:
    """Displacements and rotations (18, E) relative to the element's frame, in the axes of space at rest."""
    back = jnp.einsum("rie,rje->ije", block.axes, _axes(corners))
    moved = jnp.einsum("ije,jke->ike", back, corners - corners.mean(axis=1, keepdims=True)) - block.rest
    turn = jnp.einsum("ije,jmke->imke", back, turned)
    sine = 0.5 * jnp.stack([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    square = (sine * sine).sum(axis=0)
    angle = sine * (1 + square / 6 + 3 * square**2 / 40)
    return jnp.concatenate([moved, angle]).swapaxes(0, 1).reshape(18, -1)


def _crossed(turn: Array, triads: Array) -> Array:
    """Vector product of the rotation `turn` (3, k, E) and each column of the triads (3, 3, k, E)."""
    return jnp.cross(turn[:, None], triads, axis=0)
