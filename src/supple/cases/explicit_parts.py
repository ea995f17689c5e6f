"""Bodies in explicit integration: modal on a four-point frame, or nonlinear finite elements."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from supple.body import FlexibleBody, LinearRayleighDamping
from supple.cases.body_kinds import is_explicit_table, kind_of
from supple.errors import ModelError
from supple.fem import FiniteElementModel, Isotropic, isotropic_materials
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, NonNegative, Positive, Raw, table
from supple.methods.explicit import (
    BulkViscosity,
    CentrifugalStiffness,
    ExplicitShell,
    ExplicitSubdomain,
    J2Plasticity,
    LinearHardening,
    ModalSubdomain,
    NeoHookean,
    PowerHardening,
    StVenantKirchhoff,
    explicit_shell,
    explicit_subdomain,
    modal_subdomain,
)
from supple.methods.explicit.materials import Law
from supple.reduction import NormalModes, Rubin


class ModalPart(CheckedTable):
    """Vibration modes on a four-point frame with large translation and rotation."""

    modes: int = Field(
        ge=1,
        description="number of lowest modes of the free body; static responses to forces and "
        "moments at its interfaces are added",
    )
    highest_hz: Positive | None = Field(
        None,
        description="frequency, periods per time, above which modes are omitted, as they shorten the step",
    )
    spin_stiffness: bool = Field(False, description="true adds the geometric stiffness of free rotation")
    yield_stress: Positive | None = Field(
        None,
        description="stress limit for a warning, force per area; default: lowest yield stress of explicit "
        "parts of the same material",
    )

    def build(self, body: FlexibleBody, damping: LinearRayleighDamping | None) -> ModalSubdomain:
        """The part."""
        return modal_subdomain(
            body,
            Rubin(self.modes) if body.interfaces else NormalModes(self.modes),
            highest=np.inf if self.highest_hz is None else 2 * np.pi * self.highest_hz,
            damping=damping,
            stiffening=CentrifugalStiffness() if self.spin_stiffness else None,
            yield_stress=self.yield_stress,
        )


class ElasticLaw(CheckedTable):
    """An elastic material."""

    kind: Literal["st-venant-kirchhoff", "neo-hookean"] = Field(
        description="linear in the Green-Lagrange strain, for small strains; or for large strains, which "
        "resists the inversion of elements"
    )

    def build(self, elastic: Isotropic) -> Law:
        """The law with the elastic constants of a material."""
        return StVenantKirchhoff(elastic) if self.kind == "st-venant-kirchhoff" else NeoHookean(elastic)


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


MaterialLaw = Annotated[ElasticLaw | J2Law, Field(discriminator="kind")]


class Viscosity(CheckedTable):
    """Bulk viscosity of solids, which spreads shock fronts over a few elements."""

    linear: NonNegative = Field(0.06, description="damping ratio of waves with a length of two elements")
    quadratic: NonNegative = Field(1.2, description="number of elements over which a shock is spread")

    def build(self) -> BulkViscosity:
        """The viscosity."""
        return BulkViscosity(self.linear, self.quadratic)


class ExplicitPart(CheckedTable):
    """Nonlinear finite elements."""

    law: MaterialLaw = Field(default=ElasticLaw(kind="st-venant-kirchhoff"), description="constitutive law")
    hourglass: float = Field(
        0.01, ge=0.0, le=1.0, description="hourglass stiffness of hexahedra relative to stretching"
    )
    layers: int = Field(5, ge=2, description="Gauss points through the thickness of shells with plasticity")
    deletion: Positive | None = Field(None, description="plastic strain at which an element is deleted")
    bulk_viscosity: Viscosity = Field(
        Viscosity(linear=0.06, quadratic=1.2),
        description="viscous pressure from the volumetric strain rate; zeros: none",
    )

    def build(
        self, name: str, model: FiniteElementModel, damping: LinearRayleighDamping | None
    ) -> ExplicitSubdomain | ExplicitShell:
        """The part; ModelError for models without an isotropic material, or with several materials."""
        material = next(iter(isotropic_materials(model)), None)
        if material is None:
            raise ModelError(
                f"explicit part '{name}': its law needs an isotropic material, in shells one through the "
                "thickness, and no element has one; use such a material, or a modal part"
            )
        law = self.law.build(material)
        deletion = np.inf if self.deletion is None else self.deletion
        if model.dofs_per_node == 6:
            yields = law if isinstance(law, J2Plasticity) else None
            return explicit_shell(
                model, name=name, law=yields, layers=self.layers, deletion=deletion, damping=damping
            )
        return explicit_subdomain(
            model,
            law,
            name=name,
            hourglass=self.hourglass,
            deletion=deletion,
            damping=damping,
            bulk_viscosity=self.bulk_viscosity.build(),
        )


_OF_FRAMES = ("frame", "reduction", "split", "condense", "linear", "centre_velocity")


def _marches_one_way(path: KeyPath, body: Raw) -> Mistakes:
    """The rule that a body is either modal or explicit, and then has no keys of a floating frame."""
    if not is_explicit_table(body):
        return
    kind, march = kind_of(body), "modal" if "modal" in body else "explicit"
    if "modal" in body and "explicit" in body:
        yield (*path, "modal"), "a part is either modal or explicit; remove one of the two"
    if kind is not None and not kind.is_elastic:
        yield (*path, march), f"only elastic bodies can be {march}; remove the key"
    for key in (key for key in _OF_FRAMES if key in body):
        yield (*path, key), f"a {march} body has no floating frame and takes no {key}; remove the key"
    if table(body, "damping").get("kind", "linear-rayleigh") != "linear-rayleigh":
        yield (
            (*path, "damping", "kind"),
            'a modal or explicit body takes damping of kind "linear-rayleigh" only',
        )
    if "explicit" in body and "interface" in body:
        message = "the node sets of the mesh are the interfaces of explicit elements; remove the key"
        yield (*path, "interface"), message
    if "explicit" in body and kind is not None and kind.is_elastic and not kind.has_elements:
        yield (*path, "explicit"), "matrices have no elements; give shell or solid, or modal = {..}"


def _keys_have_an_effect(path: KeyPath, body: Raw) -> Mistakes:
    """The rule that keys without effect are errors, such as layers of a solid or of an elastic shell."""
    given = table(body, "explicit")
    kind = table(given, "law").get("kind")
    if "shell" in body:
        needless = {
            "hourglass": "only hexahedra have hourglass modes, a shell has none; remove the key",
            "bulk_viscosity": "bulk viscosity is for solids; remove the key",
        }
        if "law" not in given:
            elastic = 'an elastic shell has no {}; give it a law of kind "j2"'
            needless |= {key: elastic.format(key) for key in ("layers", "deletion")}
        elif kind != "j2":
            needless["law"] = f'a shell takes a law of kind "j2", or no law if it is elastic; got {kind!r}'
    else:
        needless = {"layers": "layers are for shells with plasticity; a solid has none: remove the key"}
        if kind != "j2":
            needless["deletion"] = 'an elastic part has no deletion; give it a law of kind "j2"'
    for key, message in needless.items():
        if key in given:
            yield (*path, "explicit", key), message


def _hardens_one_way(path: KeyPath, body: Raw) -> Mistakes:
    law = table(table(body, "explicit"), "law")
    given = [key for key in ("factor", "exponent") if key in law]
    place = (*path, "explicit", "law")
    if len(given) == 1:
        yield place, f"power hardening needs factor and exponent; this law has {given[0]} alone"
    if given and "modulus" in law:
        yield (*place, "modulus"), "a law hardens by modulus, or by factor and exponent; remove one of them"


RULES_OF_BODY = (_marches_one_way, _keys_have_an_effect, _hardens_one_way)
