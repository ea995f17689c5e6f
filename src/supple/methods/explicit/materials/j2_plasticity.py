"""J2 plasticity with isotropic hardening at finite strain: hypoelastic, after Hughes and Winget.

The rate form of Hooke's law acts on the Cauchy stress, in axes that rotate with the spin of the mid-step:

    L = dF F_mid^-1,   D = sym L,   W = skw L,   Q = (I - W/2)^-1 (I + W/2)
    sigma_trial = Q sigma Q^T + lambda tr(D) I + 2 mu D,     then radial return to Mises' yield surface

D is the exact mid-point strain increment: zero for a rigid rotation of any size. Elastic strains must stay
small (as for metals); plastic ones may be large.

Source: T. J. R. Hughes, J. Winget, "Finite rotation effects in numerical integration of rate constitutive
equations arising in large-deformation analysis", Int. J. Numer. Methods Eng. 15 (1980) 1862-1867; radial
return: M. L. Wilkins (1964).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from supple.fem import Isotropic
from supple.methods.explicit.fusion_barrier import fusion_barrier
from supple.methods.explicit.materials.hardening import Hardening
from supple.methods.explicit.materials.law import MaterialResponse, lame, linear_stress
from supple.methods.explicit.tensor3 import (
    Tensor,
    added,
    cofactor,
    determinant,
    deviator,
    double_dot,
    product,
    scaled,
    symmetric_part,
    tensor,
    transposed,
)

__all__ = ["J2Plasticity"]


class PlasticState(NamedTuple):
    """Cauchy stress (6, ...), xx yy zz yz xz xy, Pa, and equivalent plastic strain (...)."""

    stress: Array
    strain: Array


@dataclass(frozen=True)
class J2Plasticity:
    """Elastic-plastic metal.

    elastic : Isotropic
    hardening : LinearHardening(..) or PowerHardening(..)
    """

    elastic: Isotropic
    hardening: Hardening

    def initial(self, shape: tuple[int, ...]) -> PlasticState:
        """State without stress and plastic strain."""
        return PlasticState(jnp.zeros((6, *shape)), jnp.zeros(shape))

    def respond(self, F: Tensor, dF: Tensor, state: PlasticState) -> MaterialResponse:
        """First Piola-Kirchhoff stress at F, reached by the increment dF; `state` contains Cauchy stress."""
        # Separate stages: otherwise the compiler recomputes each tensor for every component that uses it.
        inverse = fusion_barrier(_middle_inverse, (F, dF))
        L = fusion_barrier(lambda of: product(*of), (dF, inverse))
        Q = fusion_barrier(_turn, L)
        half = fusion_barrier(lambda of: product(of[0], _symmetric(of[1])), (Q, state.stress))
        trial = fusion_barrier(
            lambda of: added(
                product(of[0], transposed(of[1])), linear_stress(self.elastic, symmetric_part(of[2]))
            ),
            (half, Q, L),
        )
        stress, strain, dissipated = fusion_barrier(lambda of: self._returned(*of), (trial, state.strain))
        cof, J = fusion_barrier(_cofactor_and_determinant, F)
        kept = jnp.stack([stress[0][0], stress[1][1], stress[2][2], stress[1][2], stress[0][2], stress[0][1]])
        return MaterialResponse(product(stress, cof), PlasticState(kept, strain), J * dissipated, J)

    def plastic_strain(self, state: PlasticState) -> Array | None:
        """Equivalent plastic strain."""
        return state.strain

    def _returned(self, trial: Tensor, strain: Array) -> tuple[Tensor, Array, Array]:
        """Stress on or within the yield surface, plastic strain, and dissipation per current volume."""
        _, mu = lame(self.elastic)
        mean, s = deviator(trial)
        mises = jnp.sqrt(1.5 * double_dot(s, s))
        increment = self.hardening.multiplier(mises, strain, 3 * mu)
        factor = 1 - 3 * mu * increment / jnp.where(mises > 0, mises, 1.0)
        stress = tensor(lambda i, j: factor * s[i][j] + (mean if i == j else 0.0))
        return stress, strain + increment, (mises - 3 * mu * increment) * increment


def _middle_inverse(of: tuple[Tensor, Tensor]) -> Tensor:
    """(F - dF/2)^-1."""
    F, dF = of
    cof, J = _cofactor_and_determinant(tensor(lambda i, j: F[i][j] - 0.5 * dF[i][j]))
    return scaled(1 / J, transposed(cof))


def _cofactor_and_determinant(F: Tensor) -> tuple[Tensor, Array]:
    cof = cofactor(F)
    return cof, determinant(F, cof)


def _turn(L: Tensor) -> Tensor:
    """Q = (I - W/2)^-1 (I + W/2) of the skew part W of L, in closed form."""
    w = [0.5 * (L[2][1] - L[1][2]), 0.5 * (L[0][2] - L[2][0]), 0.5 * (L[1][0] - L[0][1])]
    squared = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    factor = 1 / (1 + 0.25 * squared)
    signs = {
        (0, 1): (-1, 2),
        (1, 0): (1, 2),
        (0, 2): (1, 1),
        (2, 0): (-1, 1),
        (1, 2): (-1, 0),
        (2, 1): (1, 0),
    }

    def component(i: int, j: int) -> Array:
        square = 0.5 * (w[i] * w[j] - squared if i == j else w[i] * w[j])
        if i == j:
            return 1 + factor * square
        sign, axis = signs[i, j]
        return factor * (sign * w[axis] + square)

    return tensor(component)


def _symmetric(voigt: Array) -> Tensor:
    place = {(0, 0): 0, (1, 1): 1, (2, 2): 2, (1, 2): 3, (0, 2): 4, (0, 1): 5}
    return tensor(lambda i, j: voigt[place[min(i, j), max(i, j)]])
