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
"""Condensed: the default of `reduce`; plain: a body that moves in its columns only, as in [Wu2019]."""


def reduce_to_compare(
    body: FlexibleBody,
    frame: Frame,
    recipe: LinearBasisRecipe,
    *,
    derivatives: DerivativeChoice,
    tensors: str,
    damping: RayleighDamping | None = None,
) -> ReducedBody:
    """Reduce with tensors named in TENSORS; no warnings of locking, because locking is compared."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LockingWarning)
        quartic = TENSORS[tensors]
        return reduce(
            body, frame, recipe, derivatives=derivatives, damping=damping, quartic=quartic, loads=NoLoads
        )
