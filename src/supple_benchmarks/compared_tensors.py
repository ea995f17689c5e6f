"""Reductions for comparison, with the default stiffness tensors or with those of published work."""

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
"""Condensed: the default of `reduce`; plain: a body that moves only in its basis, as in [Wu2019]."""


def reduce_to_compare(
    body: FlexibleBody,
    frame: Frame,
    recipe: LinearBasisRecipe,
    *,
    derivatives: DerivativeChoice,
    tensors: str,
    damping: RayleighDamping | None = None,
) -> ReducedBody:
    """Reduce without a LockingWarning, because locking is one of the compared properties.

    tensors : key of `TENSORS`
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LockingWarning)
        quartic = TENSORS[tensors]
        return reduce(
            body, frame, recipe, derivatives=derivatives, damping=damping, quartic=quartic, loads=NoLoads
        )
