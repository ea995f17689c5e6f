"""Contact of nodes with the faces of another part, by penalty: each node against the face below it.

    f = k depth n   on the node,   -w_i f   on the corners of the face,   depth = -(x - sum w_i x_i) . n > 0

with the area coordinates w of the node's projection and the face's normal n. The corner forces add up to f
and act at the projection of the node, so linear and angular momentum are conserved exactly. Each step
searches for the nearest node of the surface, then among the faces around it and around its neighbours.

A shell has two sides: each node touches the side on which it starts. In a mesh of shells, the normals of
neighbouring faces may be opposite. The faces are turned so that their normals are on one side.

Since (u_node - sum w u)^2 <= 2 u_node^2 + 2 sum w u^2, the increase of the largest squared frequency by
closed contacts has a bound: twice the largest of k / m of a node and sum_nodes k w_i / m_i of a corner
(Gershgorin).
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array
from scipy.spatial import KDTree

from supple.arrays import FloatArray, IntArray
from supple.equations.compiler_options import STARTING
from supple.mesh.facet_curvature import turned_over
from supple.programs.program_cache import CachedProgram

BEYOND = 0.05
"""Largest distance of a node beyond the edge of a face, in area coordinates, for contact with this face."""

ON_SHELL = 1e-6
"""Largest initial distance of a node from a shell, relative to the size of the surface, to count as on it."""


class TouchingSurface(NamedTuple):
    """Nodes, and the faces that they must not penetrate.

    nodes : (n,);   stiffness : (n,) N/m
    corners : (T, 3) corners of the faces, counter-clockwise about the outward normals
    masters : (M,) nodes of the faces;   about : (M, r) faces near each of them, padded by repetition
    reach : largest penetration that counts as contact, m
    side : (n,) 1, or -1 for nodes that touch the back of a shell
    """

    nodes: Array
    stiffness: Array
    corners: Array
    masters: Array
    about: Array
    reach: Array
    side: Array


class Projection(NamedTuple):
    """For n nodes: corners of the face below each, area coordinates, gap, and normals.

    corners : (n, 3);   weights : (3, n);   gap : (n,) negative inside, infinite beside the surface
    normals : (3, n)
    """

    corners: Array
    weights: Array
    gap: Array
    normals: Array


def touching_surface(
    nodes: IntArray,
    stiffness: FloatArray,
    corners: IntArray,
    x: FloatArray,
    centre: FloatArray | None = None,
) -> TouchingSurface:
    """Arrays of a contact; x (N, 3) at the start determines the reach, half an edge, and the side of a shell.

    centre : (3,) of the part of the nodes, where the faces are those of a shell; None: of solids
    """
    if centre is not None:
        over = turned_over(x, corners, crease=np.pi)
        corners = np.where(over[:, None], corners[:, ::-1], corners)
    masters, local = np.unique(corners, return_inverse=True)
    local = local.reshape(corners.shape)
    ring: list[set[int]] = [set() for _ in masters]
    for face, own in enumerate(local):
        for node in own:
            ring[node].add(face)
    near = [sorted(set().union(*(ring[node] for face in own for node in local[face]))) for own in ring]
    width = max(map(len, near))
    about = np.array([own + own[-1:] * (width - len(own)) for own in near])
    edges = np.linalg.norm(x[corners] - x[np.roll(corners, 1, axis=1)], axis=2)
    made = TouchingSurface(
        jnp.asarray(nodes),
        jnp.asarray(stiffness),
        jnp.asarray(corners),
        jnp.asarray(masters),
        jnp.asarray(about),
        jnp.asarray(0.5 * edges.mean()),
        jnp.ones(len(nodes)),
    )
    return made if centre is None else _on_their_sides(made, x, centre)


def _on_their_sides(surface: TouchingSurface, x: FloatArray, centre: FloatArray) -> TouchingSurface:
    """The surface of a shell, touched by each node from the side on which it starts.

    Nodes on the shell are on the side of the centre (3,) of their part.
    """
    points, masters, corners = (
        np.asarray(each) for each in (surface.nodes, surface.masters, surface.corners)
    )
    points = x[points]
    seen = located(surface, x.T)
    height = np.asarray(seen.gap)
    # For a node beside the surface, the normal at the nearest node determines the side.
    normals = np.zeros_like(x)
    A, B, C = (x[corners[:, i]] for i in range(3))
    np.add.at(normals, corners.ravel(), np.repeat(np.cross(B - A, C - A), 3, axis=0))
    nearest = masters[KDTree(x[masters]).query(points)[1]]
    beside = ((points - x[nearest]) * normals[nearest]).sum(axis=1)
    inward = ((centre - points) * np.asarray(seen.normals).T).sum(axis=1)
    size = float(np.linalg.norm(np.ptp(x[masters], axis=0)))
    place = np.where(np.isinf(height), beside, np.where(np.abs(height) < ON_SHELL * size, inward, height))
    return surface._replace(side=jnp.asarray(np.where(place < 0, -1.0, 1.0)))


def corner_stiffness(
    nodes: FloatArray, stiffness: FloatArray, corners: IntArray, x: FloatArray
) -> dict[int, float]:
    """Bound of sum k w_i, N/m, by surface node number, for touching nodes at their closest spacing.

    nodes : (n, 3) positions of the touching nodes;   x : (N, 3) of all
    """
    edges = x[corners[:, 1:]] - x[corners[:, :1]]
    areas = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    tributary = np.zeros(len(x))
    np.add.at(tributary, corners.ravel(), np.repeat(areas / 3, 3))
    if len(nodes) > 1:
        apart = KDTree(nodes).query(nodes, 2)[0][:, 1]
        density = float((stiffness / np.maximum(apart, 1e-300) ** 2).max())
    else:
        density = 0.0
    least, all_of = float(stiffness.max()), float(stiffness.sum())
    # Factor 1.5 for uneven spacing of the nodes.
    return {
        int(node): min(max(least, 1.5 * density * float(tributary[node])), all_of)
        for node in np.unique(corners)
    }


def projected(surface: TouchingSurface, x: Array) -> Projection:
    """Projection of the nodes on the surface, at positions x (3, N)."""
    points, masters = x[:, surface.nodes], x[:, surface.masters]
    middle = masters.mean(axis=1, keepdims=True)
    a, b = points - middle, masters - middle
    nearest = jnp.argmin((b * b).sum(axis=0) - 2 * a.T @ b, axis=1)
    faces = surface.about[nearest]  # (n, r)
    corners = surface.corners[faces]
    A, B, C = (x[:, corners[:, :, i]] for i in range(3))  # (3, n, r)
    u, v, d = B - A, C - A, points[:, :, None] - A
    normal = jnp.cross(u, v, axis=0)
    square = (normal * normal).sum(axis=0)
    w1 = (jnp.cross(d, v, axis=0) * normal).sum(axis=0) / square
    w2 = (jnp.cross(u, d, axis=0) * normal).sum(axis=0) / square
    weights = jnp.stack([1 - w1 - w2, w1, w2])
    height = (d * normal).sum(axis=0) / jnp.sqrt(square)
    beside = jnp.maximum(-weights.min(axis=0), 0.0)
    # The nearest of the faces that a node is above or below; none where it is beside all of them.
    distance = jnp.where(beside <= BEYOND, jnp.abs(height) + 1e-3 * beside * surface.reach, jnp.inf)
    best = jnp.argmin(distance, axis=1)

    def chosen(array: Array) -> Array:
        index = best[:, None] if array.ndim == 2 else jnp.broadcast_to(best[:, None], (*array.shape[:-1], 1))
        return jnp.take_along_axis(array, index, axis=-1)[..., 0]

    touched = jnp.isfinite(chosen(distance))
    return Projection(
        jnp.take_along_axis(corners, best[:, None, None], axis=1)[:, 0],
        chosen(weights),
        jnp.where(touched, surface.side * chosen(height), jnp.inf),
        surface.side * chosen(normal / jnp.sqrt(square)),
    )


located = CachedProgram(projected, STARTING)


def pushes(surface: TouchingSurface, at: Projection) -> Array:
    """Forces (3, n) on nodes with the given projections."""
    depth = jnp.where((at.gap < 0) & (at.gap > -surface.reach), -at.gap, 0.0)
    return surface.stiffness * depth * at.normals


def surface_penalty(surface: TouchingSurface, x: Array) -> Array:
    """Forces (3, N) on all nodes at positions x (3, N)."""
    at = projected(surface, x)
    push = pushes(surface, at)
    forces = jnp.zeros_like(x).at[:, surface.nodes].add(push)
    for i in range(3):
        forces = forces.at[:, at.corners[:, i]].add(-at.weights[i] * push)
    return forces
