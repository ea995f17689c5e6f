"""A block of flat shell triangles: the library's linear element in a frame that turns with its corners.

    U = 1/2 d^T K d,    d = [T (x - x_c) - (X - X_c);  log(T R)],    T = A_0^T A

with the rest axes A_0 and the current ones A of the triangle (along its first side, across, normal), nodal
triads R that turn from unity, and the stiffness K of the undeformed element. Strains are small, rotations of
any size. Force and moment are the exact gradient of U, which no rigid motion changes: momentum is kept.

log takes the sine's series, exact to 1e-6 for 0.3 rad between a node and its element.

Source of the corotational form: T. Belytschko, B. J. Hsieh, Int. J. Numer. Methods Eng. 7 (1973) 255-271.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import NDArray

from supple.explicit.elements.incidence import gathered, incidence

__all__ = ["ShellBlock", "ShellForce", "shell_block", "shell_force", "shell_von_mises"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class ShellBlock(NamedTuple):
    """Constant arrays of E triangles, elements last.

    nodes, spins : (3, E)       numbers of nodes and of triads
    rest : (3, 3, E)            corners about their centre (component, corner);   axes : (3, 3, E) A_0 by rows
    stiffness : (18, 18, E)     ux uy uz rx ry rz a node, axes of the mesh
    to_stress : (l, 6, 18, E)   stress in l layers from d, Pa
    node_table, spin_table      the corners at each node and triad
    """

    nodes: Array
    spins: Array
    rest: Array
    axes: Array
    stiffness: Array
    to_stress: Array
    node_table: Array
    spin_table: Array


class ShellForce(NamedTuple):
    """Force (3, N) on the nodes and moment (3, r) on the triads, minus the internal ones."""

    force: Array
    moment: Array


def shell_block(
    nodes: IntArray,
    spins: IntArray,
    corners: FloatArray,
    stiffness: FloatArray,
    to_stress: FloatArray,
    n_nodes: int,
    n_spins: int,
) -> ShellBlock:
    """The arrays of a block; nodes, spins (E, 3), corners (E, 3, 3) at rest, the rest with elements first."""
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
    )


def shell_force(block: ShellBlock, x: Array, triads: Array) -> ShellForce:
    """At positions x (3, N) and triads (3, 3, r)."""
    corners, turned = x[:, block.nodes], triads[:, :, block.spins]

    def energy(corners: Array, turn: Array) -> Array:
        d = _deformation(block, corners, turned + _crossed(turn, turned))
        return 0.5 * jnp.sum(d * jnp.einsum("abe,be->ae", block.stiffness, d))

    on_nodes, on_triads = jax.grad(energy, argnums=(0, 1))(corners, jnp.zeros_like(corners))
    return ShellForce(gathered(-on_nodes, block.node_table), gathered(-on_triads, block.spin_table))


def shell_von_mises(block: ShellBlock, x: Array, triads: Array) -> Array:
    """Von Mises stress (E,), the largest of the layers, Pa."""
    d = _deformation(block, x[:, block.nodes], triads[:, :, block.spins])
    xx, yy, zz, yz, xz, xy = jnp.moveaxis(jnp.einsum("lcae,ae->lce", block.to_stress, d), 1, 0)
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return jnp.sqrt(0.5 * normal + 3 * (yz**2 + xz**2 + xy**2)).max(axis=0)


def _axes(corners: Array) -> Array:
    """Axes (3, 3, E) by rows of triangles (3, 3, E): first side, across, normal."""
    side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    first = side / jnp.sqrt((side * side).sum(axis=0))
    normal = jnp.cross(side, other, axis=0)
    normal = normal / jnp.sqrt((normal * normal).sum(axis=0))
    return jnp.stack([first, jnp.cross(normal, first, axis=0), normal])


def _deformation(block: ShellBlock, corners: Array, turned: Array) -> Array:
    """Displacements and rotations (18, E) against the element's frame, in the axes of the mesh."""
    back = jnp.einsum("rie,rje->ije", block.axes, _axes(corners))
    moved = jnp.einsum("ije,jke->ike", back, corners - corners.mean(axis=1, keepdims=True)) - block.rest
    turn = jnp.einsum("ije,jmke->imke", back, turned)
    sine = 0.5 * jnp.stack([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    square = (sine * sine).sum(axis=0)
    angle = sine * (1 + square / 6 + 3 * square**2 / 40)
    return jnp.concatenate([moved, angle]).swapaxes(0, 1).reshape(18, -1)


def _crossed(turn: Array, triads: Array) -> Array:
    """Turn x column of each triad: turn (3, k, E), triads (3, 3, k, E)."""
    return jnp.cross(turn[:, None], triads, axis=0)
