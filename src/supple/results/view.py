"""How a machine is looked at in pictures and animations alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.errors import ModelError
from supple.results.camera import Camera
from supple.units import plain_number

__all__ = ["View", "enlarged_words"]


@dataclass(frozen=True, eq=False)
class View:
    """From where, and with what enlargement of the deformation.

    camera : gravity points down and the widest extent lies across when None
    enlargement : of deflections, as they are seen from the first interface of a body; true to scale in
        animations and as large as it takes to be seen in pictures of single bodies when None

    Raises ModelError for an enlargement that is not positive.
    """

    camera: Camera | None = None
    enlargement: float | None = None

    def __post_init__(self) -> None:
        if self.enlargement is not None and not (np.isfinite(self.enlargement) and self.enlargement > 0):
            raise ModelError(f"an enlargement of {self.enlargement} is not positive: give a positive one")


AS_IT_IS = View()
"""The side that suits the machine, true to scale."""


def enlarged_words(factor: float) -> str:
    """Such as "deflection enlarged 75.1 times"."""
    return (
        "deflection true to scale" if factor == 1.0 else f"deflection enlarged {plain_number(factor)} times"
    )
