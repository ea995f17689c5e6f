"""Axisymmetric and cyclic bodies: their deformation in axes rotated about the symmetry axis."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import scipy.linalg
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

Array = np.ndarray

SAME_PLACE = 1e-6
"""Allowed distance of a rotated node from the nearest node, relative to the size of the body."""
SAME_SHAPE = 1e-6
"""Allowed part of a rotated shape outside the columns of the body, relative to the shape."""
MOST_SECTORS, MOST_WAVES = 360, 6
"""Largest number of sectors in the search for cyclic symmetry; largest number of waves of a shape."""
ON_AXIS = 8
"""Number of sectors assumed where every node is on the axis, or no rotation maps the mesh onto itself."""
NEARLY_ROUND = 0.35
"""Allowed distance of a rotated node from the nearest node, relative to the radius, as means of squares: a
quarter of the arc of one of `ON_AXIS` sectors is 0.2."""
LEAST_IMAGE, LARGEST_CONDITION = 0.8, 1e4
"""Least part of a rotated shape in the basis, and largest condition number of the shapes, for a generator."""


class RoundBody(Protocol):
    """A body as far as symmetry about the axis matters; deformable ones also have a `nodal_basis`."""

    @property
    def nodes(self) -> Array:
        """Positions (N, 3), in the frame of the body."""
        ...

    @property
    def n_coordinates(self) -> int:
        """Number of deformation coordinates."""
        ...


def turn_generator(body: RoundBody, axis: Array, point: Array) -> Array | None:
    """Generator J (r, r): coordinates `exp(psi J) q` represent the shape of q rotated by psi about the axis.

    A mesh of n equal sectors is mapped onto itself by a rotation of 2 pi / n; J follows from the logarithm of
    that map and is exact for shapes of fewer than n / 2 waves around the axis. For a body that is nearly
    round, or whose basis lacks the rotated copy of a shape, J turns the shapes approximately, but
    `exp(2 pi J)` is still the identity. Zeros (0, 0) for a rigid body; None for a body without
    `nodal_basis`, or one that is not round, as a blade.

    axis, point : (3,) in the body's frame
    """
    if not body.n_coordinates:
        return np.zeros((0, 0))
    basis = getattr(body, "nodal_basis", None)
    if basis is None:
        return None
    turned = _turned_by_a_sector(body.nodes, axis, point)
    if turned is None:
        sources = _nearest_sources(body.nodes, axis, point)
        return (
            None if sources is None else _whole_waves(basis, _image(basis, sources, ON_AXIS, axis), ON_AXIS)
        )
    order, sectors = turned
    flat = _image(basis, np.argsort(order), sectors, axis)
    matrix = np.linalg.lstsq(basis, flat, rcond=None)[0]
    if np.abs(basis @ matrix - flat).max() > SAME_SHAPE * np.abs(basis).max():
        return _whole_waves(basis, flat, sectors)
    logarithm: Any = scipy.linalg.logm(matrix)
    if np.abs(logarithm.imag).max() > SAME_SHAPE:  # a shape of n / 2 waves has no rotated copy
        return _whole_waves(basis, flat, sectors)
    return logarithm.real * sectors / (2 * np.pi)


def shapes_without_copy(body: RoundBody, axis: Array, point: Array) -> int:
    """Number of shapes of a body with cyclic symmetry of which its basis lacks the rotated copy.

    Zero for a body without cyclic symmetry, or without a `nodal_basis`. Parameters as for `turn_generator`.
    """
    basis = getattr(body, "nodal_basis", None)
    turned = None if basis is None or not body.n_coordinates else _turned_by_a_sector(body.nodes, axis, point)
    if basis is None or turned is None:
        return 0
    flat = _image(basis, np.argsort(turned[0]), turned[1], axis)
    values = np.linalg.eigvals(np.linalg.lstsq(basis, flat, rcond=None)[0])
    return int(np.count_nonzero(abs(values) < 1.0 - np.sqrt(SAME_SHAPE)))


def _whole_waves(basis: Array, flat: Array, sectors: int) -> Array | None:
    """Generator that turns the shapes of a basis as far as it contains their images `flat`.

    Its eigenvalues are whole numbers of waves, so that coordinates return after a revolution. Shapes without
    a rotated copy keep the axes of the body. None if the images do not determine it.
    """
    values, vectors = np.linalg.eig(np.linalg.lstsq(basis, flat, rcond=None)[0])
    if np.linalg.cond(vectors) > LARGEST_CONDITION:
        return None
    waves = np.round(np.angle(values) * sectors / (2 * np.pi))
    waves[(abs(values) < LEAST_IMAGE) | (abs(waves) >= sectors / 2)] = 0.0
    return (vectors * (1j * waves) @ np.linalg.inv(vectors)).real


def waves_around(nodes: Array, fields: Array, axis: Array, point: Array) -> Array:
    """Parts (N p, j) of fields (N p, k), p numbers per node, by their number of waves around the axis.

        P_n x = (1 / S) sum_k exp(- 2 pi i n k / S) R^k x,     R a rotation by one of S sectors

    P_n x is the part of a field x with n waves. Its real and imaginary parts are a shape and its copy rotated
    by a quarter of a wave. So the result contains every shape with its rotated copy. Shapes of more than
    `MOST_WAVES` waves are left out, and shapes of half as many waves as sectors, which have no rotated copy.
    Without cyclic symmetry the fields are returned unchanged.
    """
    turned = _turned_by_a_sector(nodes, axis, point)
    if turned is None:
        return fields
    sources, sectors = np.argsort(turned[0]), turned[1]
    waves = np.arange(min((sectors - 1) // 2, MOST_WAVES) + 1)
    sums, image = np.zeros((len(waves), *fields.shape), dtype=complex), fields
    for k in range(sectors):
        sums += np.exp(-2j * np.pi * waves * k / sectors)[:, None, None] * image / sectors
        image = _image(image, sources, sectors, axis)
    sizes = np.linalg.norm(sums, axis=(1, 2))
    kept = sums[sizes > SAME_SHAPE * sizes.max(initial=0.0)]
    return np.hstack([*kept.real, *kept.imag])


def _image(fields: Array, sources: Array, sectors: int, axis: Array) -> Array:
    """Fields (N p, k) rotated by one sector; `sources` (N,) are the nodes whose images have these places."""
    rotation = Rotation.from_rotvec(2 * np.pi / sectors * axis).as_matrix()
    by_node = fields.reshape(len(sources), -1, 3, fields.shape[1])[sources]
    return np.einsum("ij,npjr->npir", rotation, by_node).reshape(fields.shape)


def _nearest_sources(nodes: Array, axis: Array, point: Array) -> Array | None:
    """For each node, the node whose place, rotated by one of `ON_AXIS` sectors, is nearest.

    None for a body that is not round: the mean square of the distances exceeds that of the radii by
    `NEARLY_ROUND`.
    """
    places = nodes - point
    back = Rotation.from_rotvec(-2 * np.pi / ON_AXIS * axis).apply(places)
    apart, sources = KDTree(places).query(back)
    radii = np.linalg.norm(places - np.outer(places @ axis, axis), axis=1)
    return sources if np.sum(apart**2) <= NEARLY_ROUND**2 * np.sum(radii**2) else None


def _turned_by_a_sector(nodes: Array, axis: Array, point: Array) -> tuple[Array, int] | None:
    """Image of each node in the smallest rotation that maps the mesh onto itself, and number of sectors.

    None if no rotation by 2 pi / n, n >= 3, maps the mesh onto itself.
    """
    places = nodes - point
    size = float(np.ptp(places, axis=0).max()) or 1.0
    radii = np.linalg.norm(places - np.outer(places @ axis, axis), axis=1)
    if radii.max() <= SAME_PLACE * size:
        return np.arange(len(places)), ON_AXIS
    tree, outer = KDTree(places), int(np.argmax(radii))
    # The number of sectors is the number of nodes on the outermost node's circle, or a divisor of it.
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
