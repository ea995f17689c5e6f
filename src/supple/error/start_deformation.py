"""Initial deformation of bodies on their reduction bases."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from supple.body import FullBody
from supple.machine import Placed, System
from supple.reduction import ReducedBody, ReductionBasis, enrich


def with_start(placed: Placed, full: FullBody, basis: ReductionBasis) -> ReductionBasis:
    """The basis extended by the body's initial deformation and its rates.

    An equilibrium of the full machine is then also one of the reduced machine.
    """
    fields = np.column_stack([placed.coordinates, placed.coordinate_rates])
    fields = fields[:, fields.any(axis=0)]
    return enrich(full.body, basis, fields, fields.shape[1]).basis if fields.size else basis


def with_reduced(
    system: System, reduced: Mapping[str, ReducedBody], bases: Mapping[str, ReductionBasis]
) -> System:
    """The system with reduced bodies; their initial deformation is projected on the bases in the M-norm."""
    fulls = system.bodies_of(FullBody)

    def on_basis(placed: Placed) -> Placed:
        name = placed.body.name
        if name not in reduced:
            return placed
        return placed.in_form(reduced[name], bases[name].vectors.T @ fulls[name].body.mass)

    return replace(system, bodies=tuple(on_basis(placed) for placed in system.bodies))
