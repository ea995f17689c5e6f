"""Pressure on faces of a body, along their deformed normals and proportional to their deformed areas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.arguments import check_fields, check_numbers
from supple.errors import ModelError
from supple.machine.laws.time_law import OverTime, check_law_kind
from supple.machine.nodal_loads.nodal_load import NodalLoad

__all__ = ["FollowerPressure"]


@dataclass(frozen=True, kw_only=True)
class FollowerPressure(NodalLoad):
    """Pressure on triangles or quadrilaterals, against the normals of the faces.

    On each corner of a triangle with deformed corners a, b, c the force is `- p (b - a) x (c - a) / 6`; on
    each corner of a quadrilateral a, b, c, d it is `- p (c - a) x (d - b) / 8`. The corners are
    counter-clockwise, viewed from the side on which the pressure acts.

    Raises ModelError for `faces` of another shape, or a face with the same node twice.
    Source: [BonetWood1997] section 6.5, with one integration point, exact for triangles and parallelograms.
    """

    faces: Sequence[Sequence[int]] | np.ndarray
    """Node indices of the corners, (e, 3) or (e, 4)."""
    pressure: OverTime
    """Pa: a constant, a law or a function of time."""

    law_field: ClassVar[str] = "pressure"
    follows_nodes: ClassVar[bool] = True
    turns_against_frame: ClassVar[bool] = False

    def __post_init__(self) -> None:
        check_fields(self)
        check_numbers(f"FollowerPressure on '{self.body}', faces", self.faces)
        check_law_kind(f"FollowerPressure on '{self.body}'", self)
        faces = np.asarray(self.faces)
        if faces.ndim != 2 or faces.shape[1] not in (3, 4) or len(faces) == 0:
            raise ModelError(
                f"FollowerPressure on '{self.body}': faces must be node indices (e, 3) or (e, 4), "
                f"got shape {faces.shape}"
            )
        if not np.issubdtype(faces.dtype, np.integer):
            raise ModelError(f"FollowerPressure on '{self.body}': node indices of faces must be integers")
        if any(len(set(face)) < len(face) for face in faces.tolist()):
            raise ModelError(f"FollowerPressure on '{self.body}': a face has one node twice")

    @property
    def label(self) -> str:
        """Name for messages."""
        return f"FollowerPressure on {len(self.faces)} faces of '{self.body}'"

    @property
    def nodes(self) -> np.ndarray:
        """Node indices (k,) of the corners of the faces, each once, ascending."""
        return np.unique(self.faces)

    @property
    def facets(self) -> np.ndarray:
        """The corners of each face, (e, 3) or (e, 4), as positions in `nodes`."""
        return np.searchsorted(self.nodes, self.faces)

    @property
    def value_shapes(self) -> tuple[tuple[int, ...], ...]:
        """(): one pressure for all faces."""
        return ((),)

    @staticmethod
    def facet_forces(places: jax.Array, rotation: jax.Array, value: jax.Array) -> jax.Array:  # noqa: ARG004
        """`- p (b - a) x (c - a) / 6` on each corner, or `- p (c - a) x (d - b) / 8` for quadrilaterals."""
        if places.shape[0] == 3:
            area = jnp.cross(places[1] - places[0], places[2] - places[0]) / 2
        else:
            area = jnp.cross(places[2] - places[0], places[3] - places[1]) / 2
        return jnp.broadcast_to(-value * area / places.shape[0], places.shape)
