"""Bodies that are alike all around an axis: how their deformation looks when they are turned about it."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

__all__ = ["turn_generator", "waves_around"]

Array = np.ndarray

SAME_PLACE = 1e-6
"""Of the size of a body: where turned nodes may lie from others."""
SAME_SHAPE = 1e-6
"""Of a shape: what the columns of a body may lack of it turned."""
MOST_SECTORS, MOST_WAVES = 360, 6
ON_AXIS = 8
"""Parts of a turn that stand for all of it where every node is on the axis."""


def turn_generator(body: Any, axis: Array, point: Array) -> Array | None:
    """J (r, r): coordinates `exp(psi J) q` show the shape of q turned by psi about the axis.

    A mesh of n equal sectors turns into itself by 2 pi / n; J is the logarithm of that, exact for shapes of
    fewer than n / 2 waves around. Zeros (0, 0) of a rigid body.

    body : ReducedBody, or any other with a `nodal_basis`; None where it is not alike all around, or its
        columns hold a shape without the same one turned
    axis, point : (3,) in the body's frame
    """
    if not body.n_coordinates:
        return np.zeros((0, 0))
    basis = getattr(body, "nodal_basis", None)
    if basis is None:
        return None
    turned = _turned_by_a_sector(body.nodes, axis, point)
    if turned is None:
        return None
    order, sectors = turned
    flat = _image(basis, order, sectors, axis)
    matrix = np.linalg.lstsq(basis, flat, rcond=None)[0]
    if np.abs(basis @ matrix - flat).max() > SAME_SHAPE * np.abs(basis).max():
        return None
    logarithm: Any = scipy.linalg.logm(matrix)
    if np.abs(logarithm.imag).max() > SAME_SHAPE:  # a shape of n / 2 waves has no turned one
        return None
    return logarithm.real * sectors / (2 * np.pi)


def waves_around(nodes: Array, fields: Array, axis: Array, point: Array) -> Array:
    """Parts (N p, j) of fields (N p, k) on nodes that are alike all around, by their number of waves.

        P_n x = (1 / S) sum_k exp(- 2 pi i n k / S) R^k x,     R a turn by one of S sectors

    Real and imaginary parts are a shape and the same turned by a quarter of a wave: the columns hold every
    shape with the same one turned. More than `MOST_WAVES`, and as many as half the sectors, which have no
    turned one, are left out. Nodes that are not alike all around leave the fields as they are.
    """
    turned = _turned_by_a_sector(nodes, axis, point)
    if turned is None:
        return fields
    order, sectors = turned
    waves = np.arange(min((sectors - 1) // 2, MOST_WAVES) + 1)
    sums, image = np.zeros((len(waves), *fields.shape), dtype=complex), fields
    for k in range(sectors):
        sums += np.exp(-2j * np.pi * waves * k / sectors)[:, None, None] * image / sectors
        image = _image(image, order, sectors, axis)
    sizes = np.linalg.norm(sums, axis=(1, 2))
    kept = sums[sizes > SAME_SHAPE * sizes.max(initial=0.0)]
    return np.hstack([*kept.real, *kept.imag])


def _image(fields: Array, order: Array, sectors: int, axis: Array) -> Array:
    """Fields (N p, k) turned by one sector."""
    rotation = Rotation.from_rotvec(2 * np.pi / sectors * axis).as_matrix()
    by_node = fields.reshape(len(order), -1, 3, fields.shape[1])
    image = np.empty_like(by_node)
    image[order] = np.einsum("ij,npjr->npir", rotation, by_node)
    return image.reshape(fields.shape)


def _turned_by_a_sector(nodes: Array, axis: Array, point: Array) -> tuple[Array, int] | None:
    """The node in whose place each comes by the least turn that maps the mesh onto itself, and its number."""
    places = nodes - point
    size = float(np.ptp(places, axis=0).max()) or 1.0
    radii = np.linalg.norm(places - np.outer(places @ axis, axis), axis=1)
    if radii.max() <= SAME_PLACE * size:
        return np.arange(len(places)), ON_AXIS
    tree, outer = KDTree(places), int(np.argmax(radii))
    # As many sectors as nodes lie on the circle of the outermost one, or a divisor.
    ring = int(
        np.sum(
            (abs(radii - radii[outer]) < SAME_PLACE * size)
            & (abs((places - places[outer]) @ axis) < SAME_PLACE * size)
        )
    )
    for sectors in (n for n in range(min(ring, MOST_SECTORS), 2, -1) if ring % n == 0):
        moved = Rotation.from_rotvec(2 * np.pi / sectors * axis).apply(places)
        apart, order = tree.query(moved)
        if apart.max() <= SAME_PLACE * size and len(np.unique(order)) == len(order):
            return order, sectors
    return None
