"""The constitutive law of an explicit part."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from supple.fem import Isotropic
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, NonNegative, Positive, Raw, table
from supple.methods.explicit import (
    J2Plasticity,
    LinearHardening,
    NeoHookean,
    PowerHardening,
    StVenantKirchhoff,
)
from supple.methods.explicit.materials import Law


class StVenantKirchhoffLaw(CheckedTable):
    """Elastic, linear in the Green-Lagrange strain: for small strains."""

    kind: Literal["st-venant-kirchhoff"]

    def build(self, elastic: Isotropic) -> Law:
        """The law with the elastic constants of a material."""
        return StVenantKirchhoff(elastic)


class NeoHookeanLaw(CheckedTable):
    """Elastic, for large strains; resists the inversion of elements."""

    kind: Literal["neo-hookean"]

    def build(self, elastic: Isotropic) -> Law:
        """The law with the elastic constants of a material."""
        return NeoHookean(elastic)


class J2Law(CheckedTable):
    """A metal with plasticity: sigma_y = yield_stress + modulus eps_p, or + factor eps_p^exponent."""

    kind: Literal["j2"]
    yield_stress: Positive = Field(description="initial yield stress, force per area")
    modulus: NonNegative | None = Field(
        None, description="modulus of linear hardening, force per area; default 0"
    )
    factor: NonNegative | None = Field(None, description="factor of power hardening, force per area")
    exponent: float | None = Field(None, gt=0.0, le=1.0, description="exponent of power hardening")

    def build(self, elastic: Isotropic) -> Law:
        """The law with the elastic constants of a material."""
        if self.factor is not None and self.exponent is not None:
            return J2Plasticity(elastic, PowerHardening(self.yield_stress, self.factor, self.exponent))
        return J2Plasticity(elastic, LinearHardening(self.yield_stress, self.modulus or 0.0))


MaterialLaw = Annotated[StVenantKirchhoffLaw | NeoHookeanLaw | J2Law, Field(discriminator="kind")]


def _hardens_one_way(path: KeyPath, part: Raw) -> Mistakes:
    law = table(table(part, "explicit"), "law")
    given = [key for key in ("factor", "exponent") if key in law]
    place = (*path, "explicit", "law")
    if len(given) == 1:
        yield place, f"power hardening needs factor and exponent; this law has {given[0]} alone"
    if given and "modulus" in law:
        yield (*place, "modulus"), "a law hardens by modulus, or by factor and exponent; remove one of them"


RULES_OF_PART = (_hardens_one_way,)
