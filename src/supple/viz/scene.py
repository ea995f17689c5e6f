"""Several bodies in one picture: skins and positions joined as one body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.machine.obstacles import Obstacle
from supple.mesh.skin import Skin
from supple.results.obstacle_shape import obstacle_shape

__all__ = ["Actor", "Scene", "obstacle_actor", "scene_of"]


@dataclass(frozen=True, eq=False)
class Actor:
    """One body in a scene: its skin, nodal positions (t, N, 3), and values (t, N) to colour by, if any."""

    skin: Skin
    positions: FloatArray
    values: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Scene:
    """Input of `animate` for several bodies: one skin, positions (t, N, 3), values (t, N).

    The values of a body without values are NaN; the body is drawn in a plain colour.
    """

    skin: Skin
    positions: FloatArray
    values: FloatArray


def scene_of(actors: Sequence[Actor]) -> Scene:
    """Join bodies, in their order; ModelError without bodies, or with different numbers of times."""
    lengths = {len(actor.positions) for actor in actors}
    if len(lengths) != 1:
        raise ModelError(
            f"a scene needs bodies at the same times; the numbers of times are {sorted(lengths)}"
        )
    first_node = np.cumsum([0] + [actor.positions.shape[1] for actor in actors[:-1]])
    triangles = [
        start + actor.skin.triangles for start, actor in zip(first_node.tolist(), actors, strict=True)
    ]
    values = [
        np.full(actor.positions.shape[:2], np.nan) if actor.values is None else actor.values
        for actor in actors
    ]
    skin = Skin(np.concatenate(triangles), np.concatenate([actor.skin.mesh_lines for actor in actors]))
    positions = np.concatenate([actor.positions for actor in actors], axis=1)
    return Scene(skin, positions, np.concatenate(values, axis=1))


def obstacle_actor(obstacle: Obstacle, offsets: FloatArray, seen: FloatArray) -> Actor:
    """An obstacle moved by offsets (t, 3), drawn as large as the points (n, 3) of the bodies require."""
    points, triangles = obstacle_shape(obstacle, seen)
    return Actor(Skin(triangles, np.zeros(triangles.shape, dtype=bool)), points + offsets[:, None])
