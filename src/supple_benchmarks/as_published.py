"""Reduction as in published work: the body moves in its columns alone."""

from __future__ import annotations

import warnings

from supple.body import FlexibleBody, Frame, RayleighDamping
from supple.errors import LockingWarning
from supple.reduction import DerivativeChoice, LinearBasisRecipe, PlainQuartic, ReducedBody, reduce


def reduce_as_published(
    body: FlexibleBody,
    frame: Frame,
    recipe: LinearBasisRecipe,
    *,
    derivatives: DerivativeChoice,
    damping: RayleighDamping | None = None,
) -> ReducedBody:
    """Reduce with plain tensors; how far they lock is what the comparisons show, so that nothing warns."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LockingWarning)
        return reduce(body, frame, recipe, derivatives=derivatives, damping=damping, quartic=PlainQuartic())
