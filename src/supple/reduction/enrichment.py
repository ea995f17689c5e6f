"""Enrichment of a basis with displacement fields outside it."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from supple.algebra import mass_orthonormalize
from supple.body import FlexibleBody, frame_projector
from supple.errors import ModelError
from supple.reduction.derivatives.leading_directions import leading_directions
from supple.reduction.reduction_basis import ReductionBasis, check_frame_motion

__all__ = ["Enrichment", "enrich"]


class Enrichment(NamedTuple):
    """A basis with added columns, and the singular values of the fields they come from."""

    basis: ReductionBasis
    singular_values: np.ndarray
    """Singular values of the fields outside the old basis, in the M-norm (length x root mass); descending."""


def enrich(body: FlexibleBody, basis: ReductionBasis, fields: np.ndarray, n: int) -> Enrichment:
    """Append the n leading directions of fields outside a basis; fewer if the fields span less.

    body : FlexibleBody
    fields : (body.n, m)    displacement fields in the body's coordinates, for example a basis error
    Raises ModelError: n below one; fields of the wrong size.
    """
    if n < 1:
        raise ModelError(f"a basis cannot be enriched with {n} directions; give one or more")
    if fields.ndim != 2 or fields.shape[0] != body.n:
        raise ModelError(
            f"fields to enrich the basis of body '{body.name}' have shape {fields.shape}: "
            f"its {body.n} coordinates need ({body.n}, m)"
        )
    in_frame = frame_projector(body, basis.frame)
    seen = in_frame(fields)
    norms = np.sqrt(np.sum(seen * (body.mass @ seen), axis=0))
    directions = leading_directions(seen, basis.vectors, body.mass, norms)
    # Projected again after scaling, as directions of small fields carry the round-off of large ones.
    added = in_frame(directions.vectors[:, :n])
    V = mass_orthonormalize(np.hstack([basis.vectors, added]), body.mass).vectors
    check_frame_motion(body, basis.frame, V)
    before = basis.report.corrections
    labels = tuple(f"correction {len(before) + i + 1}" for i in range(V.shape[1] - basis.r))
    report = replace(basis.report, corrections=before + labels)
    return Enrichment(ReductionBasis(basis.frame, V, report), directions.lengths)
