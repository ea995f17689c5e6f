"""Bodies that are alike all around an axis: how their deformation looks when they are turned about it."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

__all__ = ["turn_generator"]

Array = np.ndarray

SAME_PLACE = 1e-6
"""Of the size of a body: where turned nodes may lie from others."""
SAME_SHAPE = 1e-6
"""Of a shape: what the columns of a body may lack of it turned."""
MOST_SECTORS = 360
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
    turned = _turned_by_a_sector(body, axis, point)
    if turned is None:
        return None
    order, sectors = turned
    rotation = Rotation.from_rotvec(2 * np.pi / sectors * axis).as_matrix()
    fields = basis.reshape(len(body.nodes), -1, 3, basis.shape[1])
    image = np.empty_like(fields)
    image[order] = np.einsum("ij,npjr->npir", rotation, fields)
    flat = image.reshape(basis.shape)
    matrix = np.linalg.lstsq(basis, flat, rcond=None)[0]
    if np.abs(basis @ matrix - flat).max() > SAME_SHAPE * np.abs(basis).max():
        return None
    logarithm: Any = scipy.linalg.logm(matrix)
    if np.abs(logarithm.imag).max() > SAME_SHAPE:  # a shape of n / 2 waves has no turned one
        return None
    return logarithm.real * sectors / (2 * np.pi)


def _turned_by_a_sector(body: Any, axis: Array, point: Array) -> tuple[Array, int] | None:
    """The node in whose place each comes by the least turn that maps the mesh onto itself, and its number."""
    places = body.nodes - point
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
