"""What a correction of Newton's iteration will leave of the residual, predicted from one that was measured.

Near a solution Newton's iteration squares its residual. With the sizes `s_0` before and `s_1` behind a
correction of an earlier step of the same run, in parts of the tolerance,

    s_1' <= s_1 max(1, s_0' / s_0)^2

is expected of the next one, where a single correction did a step, the next step is no longer and its
residual not much larger. Where that is far below the tolerance, the corrected iterate is accepted without
one evaluation more. Every so many steps it is measured again, and a step that takes several corrections is
always evaluated.

It holds for what is smooth: inertia, elastic forces, joints and nodal loads are. Laws of force elements and
controllers may have kinks within a step, so machines with such elements are always evaluated.
Source: [HairerWanner1996], section IV.8, stops by the contraction of an earlier step, too.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.equations.model import Model

__all__ = ["Contraction", "is_predictable", "measured", "no_estimate", "predicted_to_converge"]

MARGIN = 100.0
"""By which what is predicted must be below the tolerance."""
LIKE = 2.0
"""By which a residual may exceed that measured; beyond, at a jump of a load, something else is at work."""
MEASURED_EVERY = 8
"""Steps."""


class Contraction(NamedTuple):
    """The last correction that was measured: numbers, which a recorded run keeps."""

    before: Any
    """Residual in parts of the tolerance; 0 where nothing was measured yet"""
    after: Any
    step: Any
    """Size of the step, s"""
    phase: Any
    """Accepted steps since one was due to be measured"""


def no_estimate() -> Contraction:
    """Nothing is known at the start of a run."""
    return Contraction(*np.zeros(4))


def is_predictable(model: Model) -> bool:
    """Whether all terms of the equations are smooth within a step."""
    return not model.forces and not model.controllers


def predicted_to_converge(known: Contraction, size: jax.Array, step: jax.Array) -> jax.Array:
    """Whether a correction from a residual of this size surely ends below the tolerance."""
    ratio = jnp.maximum(1.0, size / jnp.where(known.before > 0, known.before, 1.0))
    # A step no longer than that measured: its tangent varies no more.
    comparable = (known.phase > 0) & (step <= known.step * (1 + 1e-6)) & (size <= LIKE * known.before)
    return comparable & (MARGIN * known.after * ratio**2 <= 1.0)


def measured(
    known: Contraction, sizes: jax.Array, step: jax.Array, corrections: jax.Array, evaluated: jax.Array
) -> Contraction:
    """What is known behind an accepted step.

    sizes : (2,)    before and behind its last correction
    corrections : of the step: after several nothing is known; evaluated : whether its end was
    """
    anew = Contraction(sizes[0], sizes[1], step, known.phase)
    kept = jax.tree.map(
        lambda own, old: jnp.where(evaluated & (corrections == 1), own, old), anew, Contraction(*known)
    )
    return kept._replace(
        before=jnp.where(corrections > 1, 0.0, kept.before), phase=(known.phase + 1) % MEASURED_EVERY
    )
