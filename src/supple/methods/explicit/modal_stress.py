"""Stress of a modal part: the stress of its modes, linear in their coordinates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.fem import (
    BeamSection,
    FiniteElementModel,
    HomogeneousSection,
    Isotropic,
    RodSection,
    stress_recovery,
    von_mises,
)
from supple.methods.explicit.modal_subdomain import ModalSubdomain

__all__ = ["isotropic_materials", "modal_von_mises", "stress_of_modes"]

FloatArray = NDArray[np.float64]


def isotropic_materials(model: FiniteElementModel) -> set[Isotropic]:
    """Isotropic materials of solids, beams, rods, and of shells with one material through the thickness."""
    given = [section.property for section in model.sections]
    of_material = HomogeneousSection | BeamSection | RodSection
    made_of = [own.material if isinstance(own, of_material) else own for own in given]
    return {material for material in made_of if isinstance(material, Isotropic)}


def stress_of_modes(subdomain: ModalSubdomain) -> FloatArray:
    """Stress (k, N, l, 6) at the nodes in l layers per modal coordinate, Pa.

    Raises
    ------
    ModelError   as for stress_recovery
    """
    body = subdomain.body
    assert body.model is not None  # a body of matrices has no stress
    recovery = stress_recovery(body.model).linearized()
    return np.array([recovery.at_nodes(column) for column in (body.expansion @ subdomain.vectors).T])


def modal_von_mises(of_modes: FloatArray, coordinates: FloatArray) -> FloatArray:
    """Von Mises stress (t, N), Pa, the largest over the layers, of modal coordinates (t, k).

    of_modes : (k, N, l, 6) of `stress_of_modes`
    """
    return np.array([von_mises(np.einsum("k,knlc->nlc", row, of_modes)).max(axis=1) for row in coordinates])
