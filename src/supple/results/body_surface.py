"""The visible surface of a body: faces of its mesh, beam sections, springs, ties and masses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.body import BodyForm
from supple.fem import FiniteElementModel, beam_end_ranks, has_stress_on_faces
from supple.integrate import Motion
from supple.mesh import CellType, Mesh
from supple.mesh.skin import Skin, skin_of
from supple.quantities.tracked_motion import Observer, displacement_from_axes, node_positions
from supple.results.beam_skin import BeamSkin, beam_skin

__all__ = ["BodySurface", "Look", "SurfacePoints", "body_surface"]

Look = Mesh | FiniteElementModel
"""Input of the drawing of a body: its mesh, or its elements, which contain the beam sections."""


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Visible points of a body, attached to nodes: the nodes themselves, and the points of beam surfaces.

    nodes : (P,) node of each point;   arms : (P, 3) from the node to the point, undeformed, m
    groups : (P,) index of the stress in `von_mises_by_end`: 0 for faces, 1 + end for beams, -1 without stress
    """

    nodes: IntArray
    arms: FloatArray
    groups: IntArray

    @classmethod
    def of_nodes(cls, nodes: IntArray) -> SurfacePoints:
        """Nodes only."""
        return cls(nodes, np.zeros((len(nodes), 3)), np.zeros(len(nodes), dtype=np.int64))

    def some(self, points: IntArray) -> SurfacePoints:
        """Some of these points."""
        return SurfacePoints(self.nodes[points], self.arms[points], self.groups[points])

    @property
    def on_arms(self) -> IntArray:
        """Numbers of the points that are not nodes."""
        return np.flatnonzero(self.arms.any(axis=1))

    def placed(self, nodes: FloatArray, rotations: FloatArray | None = None) -> FloatArray:
        """Positions (..., P, 3) for nodes at (..., N, 3) with rotations (..., N, 3, 3)."""
        return self._out_on_arms(nodes[..., self.nodes, :], rotations)

    def positions(self, body: BodyForm, motion: Motion, nodes: FloatArray | None = None) -> FloatArray:
        """Positions (t, P, 3) in space.

        nodes : (t, N, 3) drawn positions of the nodes; by default their true positions
        """
        own = node_positions(body, motion, self.nodes) if nodes is None else nodes[:, self.nodes]
        return self._out_on_arms(own, body.node_rotations(motion) if len(self.on_arms) else None)

    def _out_on_arms(self, carriers: FloatArray, rotations: FloatArray | None) -> FloatArray:
        """The points from positions (..., P, 3) of their nodes."""
        own = self.on_arms
        if not len(own):
            return carriers
        arms = self.arms[own]
        if rotations is not None:
            arms = np.einsum("...pij,pj->...pi", rotations[..., self.nodes[own], :, :], arms)
        found = carriers.copy()
        found[..., own, :] += arms
        return found

    def at_points(self, values: FloatArray) -> FloatArray:
        """Values (t, P) at the points from nodal values (t, N) or (t, N, groups); NaN without stress."""
        if values.ndim == 2:
            return values[:, self.nodes]
        return np.where(self.groups >= 0, values[:, self.nodes, self.groups], np.nan)


@dataclass(frozen=True, eq=False)
class BodySurface(SurfacePoints):
    """The surface of a body over points attached to nodes: first the nodes themselves, then points of beams.

    skin : triangles over the P points
    links : (S, 2) nodes connected by springs, ties or masses;  masses : (M,) nodes with concentrated masses
    """

    mesh: Mesh
    skin: Skin
    links: IntArray
    masses: IntArray

    @property
    def rest(self) -> FloatArray:
        """Undeformed positions (P, 3)."""
        return self.placed(self.mesh.nodes)

    def shaped(self, shapes: FloatArray, rotations: FloatArray | None) -> FloatArray:
        """Displacements (..., P, 3) from those of nodes (..., N, 3) and their small rotations (..., N, 3)."""
        found = shapes[..., self.nodes, :]
        return found if rotations is None else found + np.cross(rotations[..., self.nodes, :], self.arms)

    def deflections(self, body: BodyForm, motion: Motion, seen_from: Observer) -> FloatArray:
        """Displacements (t, P, 3) relative to an observer."""
        origin = seen_from.origin[:, None]
        places = self.positions(body, motion)
        return displacement_from_axes(places, origin, seen_from.axes, self.rest - seen_from.rest)


def body_surface(look: Look) -> BodySurface:
    """The surface of a body; without elements its beams are not shown.

    Raises ModelError where nothing is visible.
    """
    model = look if isinstance(look, FiniteElementModel) else None
    mesh = look if isinstance(look, Mesh) else look.mesh
    n = mesh.n_nodes
    own = np.zeros(n, np.int64) if model is None else np.where(has_stress_on_faces(model), 0, -1)
    parts, masses = [], np.empty(0, dtype=np.int64)
    if model is not None:
        ranks = beam_end_ranks(model)
        parts = [
            beam_skin(model, each, ranks.get(number))
            for number, each in enumerate(model.sections)
            if each.cell_type is CellType.LINE2
        ]
        if model.attached.mass is not None:
            masses = np.flatnonzero(model.attached.mass.diagonal().reshape(n, -1)[:, :3].any(axis=1))
    triangles, lines = np.empty((0, 3), np.int64), np.empty((0, 3), np.bool_)
    if any(kind.dimension > 1 for kind in mesh.cells) or not parts:
        skin = skin_of(mesh)
        triangles, lines = skin.triangles, skin.mesh_lines
    parts.insert(0, BeamSkin(triangles, lines, np.arange(n), np.zeros((n, 3)), own))
    numbered, lines, nodes, arms, groups = map(np.concatenate, zip(*parts, strict=True))
    first = np.repeat(
        np.cumsum([0, *(len(part.nodes) for part in parts[:-1])]), [len(part.triangles) for part in parts]
    )
    links = mesh.links[mesh.links[:, 0] != mesh.links[:, 1]]
    return BodySurface(nodes, arms, groups, mesh, Skin(first[:, None] + numbered, lines), links, masses)
