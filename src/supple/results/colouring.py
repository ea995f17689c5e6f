"""Colours of an animation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from supple.arrays import FloatArray
from supple.body import BodyForm
from supple.fem import FiniteElementModel, has_stress, isotropic_materials
from supple.integrate import FramedMotion, Motion
from supple.methods.explicit.motions import NodalMotion
from supple.quantities import von_mises_by_end
from supple.results import without_noise
from supple.results.explicit_fields import element_means, has_explicit_elements
from supple.units import UnitSystem, labelled


@dataclass(frozen=True)
class Colouring:
    """Scalar field that colours the bodies of an animation.

    values : function of a body, its motion and its deflections (t, N), which are None for a body without a
        frame; returns nodal values (t, N), or (t, N, g) by the groups of a `BodySurface`, or None for a body
        without values
    label : function of a unit system; returns the label of the colour bar and the factor on the values
    """

    values: Callable[[BodyForm, Motion, FloatArray | None], FloatArray | None]
    label: Callable[[UnitSystem], tuple[str, float]]


def _stress_label(units: UnitSystem) -> tuple[str, float]:
    unit, factor = units.stress_shown
    return labelled("von Mises stress", unit), factor


def _plastic_strain(body: BodyForm, motion: Motion, _deflection: FloatArray | None) -> FloatArray | None:
    if not has_explicit_elements(body) or body.law is None:
        return None
    own = motion.of_type(NodalMotion)
    return element_means(body, own.plastic_strain, own.alive)


def stress_colouring(elements: Mapping[str, FiniteElementModel]) -> Colouring:
    """Colouring by von Mises stress; stress below 1e-9 of Young's modulus is round-off and shown as zero.

    elements : finite element models of the bodies, by name; other bodies have no values
    """

    def values(body: BodyForm, motion: Motion, _deflection: FloatArray | None) -> FloatArray | None:
        model = elements.get(body.name)
        if model is None or not has_stress(model):
            return None
        if has_explicit_elements(body):
            own = motion.of_type(NodalMotion)
            stress = element_means(body, own.von_mises, own.alive)
        else:
            stress = von_mises_by_end(body, model, motion.of_type(FramedMotion).coordinates)
        return without_noise(stress, like=[each.youngs_modulus for each in isotropic_materials(model)])

    return Colouring(values, _stress_label)


DEFLECTION = Colouring(
    lambda _body, _motion, deflection: deflection, lambda units: (labelled("deflection", units.length), 1.0)
)
"""Colouring by deflection."""
PLASTIC_STRAIN = Colouring(_plastic_strain, lambda _: ("plastic strain", 1.0))
"""Colouring by equivalent plastic strain, for explicit elements with plasticity."""
