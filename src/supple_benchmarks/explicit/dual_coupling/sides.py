"""The two sides of a dual coupling: modes with long steps, elements with short steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jax import Array
from numpy.typing import NDArray

from supple.errors import ModelError

__all__ = ["Coupling", "ElementSide", "ModalSide"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ModalSide:
    """alpha'' + diag(omega^2) alpha = C^T Lambda: mass-normalised modes.

    frequencies : (k,) rad/s;   rows : (l, k)   C-hat = C Phi, interface velocity per modal rate
    """

    frequencies: FloatArray
    rows: FloatArray


@dataclass(frozen=True, eq=False)
class ElementSide:
    """m u'' = f(u, t) + C^T Lambda.

    mass : (n,) kg;   force : of u (n,) and time, -internal + external, N; may be nonlinear
    rows : (l, n)     C; one entry per row for matching meshes, more for a mortar
    stiffness : (n, n) at rest, for the response to a unit ramp (Prakash and Hjelmstad); sparse or dense
    """

    mass: FloatArray
    force: Callable[[Array, Array], Array]
    rows: FloatArray
    stiffness: FloatArray


@dataclass(frozen=True, eq=False)
class Coupling:
    """C_1 v_1 + C_2 v_2 = 0 between the two sides.

    Raises ModelError for different numbers of rows, or linearly dependent rows of the element side: then the
    multipliers are not unique.
    """

    modal: ModalSide
    elements: ElementSide

    def __post_init__(self) -> None:
        first, second = self.modal.rows, self.elements.rows
        if len(first) != len(second):
            raise ModelError(
                f"the interface nodes do not match: {len(first)} rows of the modal side, {len(second)} of "
                "the elements"
            )
        if np.linalg.matrix_rank(second) < len(second):
            raise ModelError("the rows of the element side are linearly dependent: tie each freedom once")
