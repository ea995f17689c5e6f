"""The two sides of a dual coupling: modes with long time steps, elements with short time steps."""

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
    """Side of mass-normalised modes: alpha'' + diag(omega^2) alpha = C^T Lambda.

    frequencies : (k,) omega, rad/s
    rows : (l, k) interface velocities per unit modal velocity: C Phi, with the mode shapes Phi
    """

    frequencies: FloatArray
    rows: FloatArray


@dataclass(frozen=True, eq=False)
class ElementSide:
    """Side of elements: m u'' = f(u, t) + C^T Lambda.

    mass : (n,) lumped, kg
    force : f(u, t) (n,), external minus internal force, N, at displacements u (n,) and time t; may be
        nonlinear
    rows : (l, n) C; one nonzero entry per row for matching meshes, more for mortar rows
    stiffness : (n, n) -df/du at rest, N/m; dense for `dual_march`, otherwise dense or sparse
    """

    mass: FloatArray
    force: Callable[[Array, Array], Array]
    rows: FloatArray
    stiffness: FloatArray


@dataclass(frozen=True, eq=False)
class Coupling:
    """Continuity of velocities between the two sides: C_1 v_1 + C_2 v_2 = 0.

    Raises ModelError if the sides have different numbers of rows, or if the rows of the element side are
    linearly dependent: the multipliers would not be unique.
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
