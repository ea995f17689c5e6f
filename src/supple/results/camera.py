"""The viewing direction of a body, and the enlargement of its deflections, in pictures and animations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.units import plain_number

__all__ = ["Camera"]


@dataclass(frozen=True, eq=False)
class Camera:
    """Parallel projection, so that equal lengths along an axis look equal.

    Parameters
    ----------
    axes : array (3, 3)     orthonormal rows, directions in space: right, up, and towards the viewer

    Raises
    ------
    ModelError  rows that are not orthonormal and right-handed
    """

    axes: FloatArray

    def __post_init__(self) -> None:
        axes = np.array(self.axes, dtype=float)
        if (
            axes.shape != (3, 3)
            or not np.allclose(axes @ axes.T, np.eye(3), atol=1e-9)
            or np.linalg.det(axes) < 0
        ):
            raise ModelError(
                "camera: right, up and towards must be orthonormal and right-handed; see Camera.looking"
            )
        axes.setflags(write=False)
        object.__setattr__(self, "axes", axes)

    @classmethod
    def looking(cls, *, along: ArrayLike, up: ArrayLike) -> Camera:
        """Camera that looks along a direction, with the direction `up` upright in the picture.

        Raises
        ------
        ModelError  the two directions are parallel, or one is zero
        """
        towards, upright = -np.asarray(along, dtype=float), np.asarray(up, dtype=float)
        right = np.cross(upright, towards)
        if np.linalg.norm(right) <= 1e-9 * np.linalg.norm(towards) * np.linalg.norm(upright):
            raise ModelError(
                f"camera: looking along {along} with {up} up; give two directions that are not parallel"
            )
        axes = np.stack([right, np.cross(towards, right), towards])
        return cls(axes / np.linalg.norm(axes, axis=1, keepdims=True))

    @classmethod
    def three_quarter(cls, nodes: FloatArray) -> Camera:
        """Camera towards a corner of a body: its longest extent to the right, its shortest upright."""
        thin, _, long = np.argsort(np.ptp(nodes, axis=0), kind="stable")
        right, up = np.eye(3)[long], np.eye(3)[thin]
        towards = np.cross(right, up)
        turn, lift = np.radians(25.0), np.radians(32.0)
        sight = np.cos(lift) * (np.cos(turn) * towards + np.sin(turn) * right) + np.sin(lift) * up
        return cls.looking(along=-sight, up=up)

    def project(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Picture coordinates (..., 2) of points (..., 3), and their coordinates (...) towards the viewer."""
        seen = points @ self.axes.T
        return seen[..., :2], seen[..., 2]


@dataclass(frozen=True, eq=False)
class View:
    """Camera, and enlargement of the deformation.

    camera : by default gravity points down and the widest extent is horizontal
    enlargement : factor on deflections relative to the first interface of a body; by default 1 in animations;
        in pictures of single bodies, a factor that makes small deflections visible

    Raises ModelError for an enlargement that is not positive.
    """

    camera: Camera | None = None
    enlargement: float | None = None

    def __post_init__(self) -> None:
        if self.enlargement is not None and not (np.isfinite(self.enlargement) and self.enlargement > 0):
            raise ModelError(f"an enlargement of {self.enlargement} is not positive: give a positive one")


AS_IT_IS = View()
"""The default camera and the default enlargement."""


def enlarged_words(factor: float) -> str:
    """The enlargement as text, such as "deflection enlarged 75.1 times"."""
    return (
        "deflection true to scale" if factor == 1.0 else f"deflection enlarged {plain_number(factor)} times"
    )
