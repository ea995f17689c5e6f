"""Protocol of a constitutive law for explicit elements: stress from the deformation gradient."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol, TypeAlias

from jax import Array

from supple.fem import Isotropic
from supple.methods.explicit.tensor3 import (
    Tensor,
    double_dot,
    product,
    scaled,
    symmetric_part,
    tensor,
    transposed,
)

__all__ = ["Law", "LawState", "MaterialResponse"]

LawState: TypeAlias = Any
"""Internal variables of a law at some points, a pytree of arrays."""


class MaterialResponse(NamedTuple):
    """Response of a law at some points.

    stress : Tensor             first Piola-Kirchhoff P, force per undeformed area, Pa
    state : LawState            internal variables
    dissipated : array          plastic work of the step per undeformed volume, J/m^3
    volume_ratio : array        J = det F; not positive where the element is inverted
    """

    stress: Tensor
    state: LawState
    dissipated: Array
    volume_ratio: Array


class Law(Protocol):
    """Material at finite strain; frozen and hashable, because it is a static argument of compiled code."""

    @property
    def elastic(self) -> Isotropic:
        """Its elastic constants and density, which bound the step."""
        ...

    def initial(self, shape: tuple[int, ...]) -> LawState:
        """Internal variables of points at rest."""
        ...

    def respond(self, F: Tensor, dF: Tensor, state: LawState) -> MaterialResponse:
        """Stress at the deformation gradient F, reached by the increment dF from that of the last step."""
        ...

    def plastic_strain(self, state: LawState) -> Array | None:
        """Equivalent plastic strain at the points; None for laws without plasticity."""
        ...


def lame(material: Isotropic) -> tuple[float, float]:
    """Lame's constants lambda and mu, Pa."""
    mu, nu = material.shear_modulus, material.poissons_ratio
    return 2 * mu * nu / (1 - 2 * nu), mu


def linear_stress(material: Isotropic, strain: Tensor) -> Tensor:
    """Stress lambda tr(e) I + 2 mu e of a symmetric strain tensor e."""
    first, mu = lame(material)
    pressure = first * (strain[0][0] + strain[1][1] + strain[2][2])
    return tensor(lambda i, j: 2 * mu * strain[i][j] + (pressure if i == j else 0.0))


def viscous_stress(material: Isotropic, beta: Array, F: Tensor, dF: Tensor, h: Array) -> tuple[Tensor, Array]:
    """First Piola-Kirchhoff stress P = F S with S = beta C : E', and its work per volume in the step.

    Rotation does not cause this stress. About the undeformed state it is Rayleigh damping with beta K.
    """
    rate = scaled(1 / h, symmetric_part(product(transposed(F), dF)))
    S = scaled(beta, linear_stress(material, rate))
    return product(F, S), h * double_dot(S, rate)
