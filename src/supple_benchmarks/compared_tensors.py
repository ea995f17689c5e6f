"""Reductions for comparison: with the default tensors, or with those of published work."""

from __future__ import annotations

import warnings

from supple.body import FlexibleBody, Frame, RayleighDamping
from supple.errors import LockingWarning
from supple.reduction import (
    CondensedQuartic,
    DerivativeChoice,
    LinearBasisRecipe,
    NoLoads,
    PlainQuartic,
    QuarticChoice,
    ReducedBody,
    reduce,
)

__all__ = ["TENSORS", "reduce_to_compare"]

TENSORS: dict[str, QuarticChoice] = {"condensed": CondensedQuartic(), "plain": PlainQuartic()}
"""Those of `reduce` by default; and of a body that moves in its columns alone, as in [Wu2019]."""


def reduce_to_compare(
    body: FlexibleBody,
    frame: Frame,
    recipe: LinearBasisRecipe,
    *,
    derivatives: DerivativeChoice,
    tensors: str,
    damping: RayleighDamping | None = None,
) -> ReducedBody:
    """Reduce with tensors named in TENSORS; their locking is compared, so that warnings are suppressed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LockingWarning)
        quartic = TENSORS[tensors]
        return reduce(
            body, frame, recipe, derivatives=derivatives, damping=damping, quartic=quartic, loads=NoLoads
        )
