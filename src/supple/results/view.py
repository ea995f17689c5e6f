"""Camera and enlargement of a machine in pictures and animations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.errors import ModelError
from supple.results.camera import Camera
from supple.units import plain_number


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
