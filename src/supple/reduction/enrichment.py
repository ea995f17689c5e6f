"""Enrichment of a basis with displacement fields outside it."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from supple.algebra import mass_orthonormalize
from supple.body import FlexibleBody, frame_projector
from supple.errors import ModelError
from supple.reduction.derivatives.compression import leading_directions
from supple.reduction.reduction_basis import ReductionBasis, check_frame_motion

__all__ = ["Enrichment", "enrich"]


class Enrichment(NamedTuple):
    """A basis with added columns, and the singular values of the fields that were added."""

    basis: ReductionBasis
    singular_values: np.ndarray
    """Singular values of the fields outside the old basis, in the M-norm (length x root mass); descending."""


def enrich(body: FlexibleBody, basis: ReductionBasis, fields: np.ndarray, n: int) -> Enrichment:
    """Append the n leading directions of fields outside a basis, or all if the fields span fewer.

    body : FlexibleBody
    fields : (body.n, m)    displacement fields in the body's coordinates, for example a basis error
    Returns Enrichment: the new basis, and the singular values of the fields.
    Raises ModelError: n below one, or fields of the wrong size; AccuracyError: the new columns violate
        D V = 0 or V^T M V = I.
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
    # Projected again: scaling a direction of small singular value to unit length amplifies its round-off.
    added = in_frame(directions.vectors[:, :n])
    V = mass_orthonormalize(np.hstack([basis.vectors, added]), body.mass).vectors
    check_frame_motion(body, basis.frame, V)
    before = basis.report.corrections
    labels = tuple(f"correction {len(before) + i + 1}" for i in range(V.shape[1] - basis.r))
    report = replace(basis.report, corrections=before + labels)
    return Enrichment(ReductionBasis(basis.frame, V, report), directions.lengths)
