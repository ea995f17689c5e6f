"""The deformation that bodies start with, on the bases that they are reduced to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from supple.body import FullBody
from supple.machine import Placed, System
from supple.reduction import ReducedBody, ReductionBasis, enrich

__all__ = ["with_reduced", "with_start"]


def with_start(placed: Placed, full: FullBody, basis: ReductionBasis) -> ReductionBasis:
    """The basis with the deformation and its rates that the body starts with, so that it holds them exactly.

    A full machine at rest then rests on the bases of its bodies too: its forces balance along all columns.
    """
    fields = np.column_stack([placed.coordinates, placed.coordinate_rates])
    fields = fields[:, fields.any(axis=0)]
    return enrich(full.body, basis, fields, fields.shape[1]).basis if fields.size else basis


def with_reduced(
    system: System, reduced: Mapping[str, ReducedBody], bases: Mapping[str, ReductionBasis]
) -> System:
    """The system with bodies on their bases, the deformation that they start with projected in the M-norm."""
    fulls = system.bodies_of(FullBody)

    def on_basis(placed: Placed) -> Placed:
        name = placed.body.name
        if name not in reduced:
            return placed
        return placed.in_form(reduced[name], bases[name].vectors.T @ fulls[name].body.mass)

    return replace(system, bodies=tuple(on_basis(placed) for placed in system.bodies))
