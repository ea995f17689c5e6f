"""Bulk viscosity: a pressure from the rate of volume change, which spreads a front over a few elements.

    q = rho c_d L (b_1 |tr D| + b_2^2 L / c_d tr(D)^2),    the quadratic part in compression alone

with the speed c_d of dilatational waves and the length L = c_d dt_e of the element's stable step dt_e at
rest. It is a pressure in compression; the linear part is a tension in expansion. It is zero in rigid motion.
Without it, central differences oscillate behind a front, up to 25 % beyond d'Alembert's solution.

q damps the fastest dilatation of an element by the fraction xi = b s of critical damping. Here b = b_1 +
b_2^2 dt_e |tr D| and s = omega_d^2 / omega_max^2, where omega_d is the frequency of the fastest dilatation
and omega_max that of the fastest mode. The rates are those of the half step before, which shortens the stable
step to dt_e (sqrt(1 + xi^2) - xi). Steps are chosen at output times. Where a front arrives between them, b is
limited to the value for which the step is stable.

Source: [vonNeumann1950] for the quadratic part, [Landshoff1955] for the linear one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from supple.arguments import check_fields
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.fem import Isotropic
from supple.methods.explicit.elements.solid_points import SolidPoints
from supple.methods.explicit.tensor3 import Tensor, cofactor, determinant

__all__ = ["BulkArrays", "BulkViscosity", "bulk_arrays"]


@dataclass(frozen=True)
class BulkViscosity:
    """Coefficients of the bulk viscosity; both zero: none.

    linear : b_1, fraction of critical damping of a plane wave with a length of two elements
    quadratic : b_2, which spreads a shock of any strength over about b_2 elements
    """

    linear: float = 0.06
    quadratic: float = 1.2

    def __post_init__(self) -> None:
        check_fields(self)
        for name in ("linear", "quadratic"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                raise ModelError(f"the {name} bulk viscosity must be zero or positive, got {value}")

    @property
    def acts(self) -> bool:
        """Whether any coefficient is positive."""
        return self.linear > 0 or self.quadratic > 0


class BulkArrays(NamedTuple):
    """Arrays for E elements.

    linear, squared : b_1 and b_2^2;   modulus : rho c_d^2, Pa
    times : (E,) dt_e, in seconds;   shares : (E,) the ratio s
    """

    linear: Array
    squared: Array
    modulus: Array
    times: Array
    shares: Array

    def coefficients(self, rate: Array) -> Array:
        """Coefficients b (.., E) at rates of volume change (.., E), 1/s."""
        return self.linear + self.squared * self.times * jnp.maximum(-rate, 0.0)


def bulk_arrays(
    points: SolidPoints, masses: FloatArray, elastic: Isotropic, limits: FloatArray, given: BulkViscosity
) -> BulkArrays | None:
    """Arrays of elements; None without viscosity.

    masses : (E, k) lumped, kg;   limits : (E,) stable steps at rest, s
    """
    if not given.acts:
        return None
    modulus = float(elastic.elasticity[0, 0])
    g = points.gradients * np.sqrt(points.volumes)[:, :, None, None] / np.sqrt(masses)[:, None, None, :]
    rows = g.reshape(*g.shape[:2], -1)  # rates of volume change of motions of unit kinetic energy
    largest = np.linalg.eigvalsh(rows @ rows.swapaxes(1, 2))[:, -1]
    numbers = given.linear, given.quadratic**2, modulus, limits, modulus * largest * limits**2 / 4
    return BulkArrays(*(jnp.asarray(each) for each in numbers))


def bulk_pressure(of: BulkArrays, J: Array, before: Array, h: Array) -> tuple[Array, Array]:
    """Pressure q (g, E), Pa, for det F from `before` to J in a step h, and its work, J per m^3 undeformed.

    The rate of volume change follows from det F at both ends of the step: rotations do not contribute.
    """
    swelling = 2 * (J - before) / (J + before)
    bears = jnp.maximum(0.5 * (of.times / h - h / of.times) / of.shares, 0.0)
    q = -of.modulus * of.times * jnp.minimum(of.coefficients(swelling / h), bears) * swelling / h
    return q, -J * q * swelling


def bulk_share(of: BulkArrays, F: Tensor, dF: Tensor) -> Array:
    """Damping fraction xi (E,), the largest of the points; F : deformation gradient, dF : its rate, 1/s."""
    cof = cofactor(F)
    rate = sum(dF[i][j] * cof[i][j] for i in range(3) for j in range(3)) / determinant(F, cof)
    return of.shares * of.coefficients(rate).max(axis=0)
