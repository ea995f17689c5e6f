"""A prescribed angle with its first two derivatives, sampled in time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import jax
import numpy as np
from numpy.typing import NDArray

from supple.errors import ModelError


@dataclass(frozen=True)
class AngleHistory:
    """Angle (rad), rate (rad/s) and acceleration (rad/s^2) at the sampled times, each (t,)."""

    angle: NDArray[np.float64]
    rate: NDArray[np.float64]
    acceleration: NDArray[np.float64]


def angle_history(angle: Callable[[jax.Array], jax.Array], times: NDArray[np.float64]) -> AngleHistory:
    """Sample a traceable law theta(t) with its exact first and second derivatives.

    Parameters
    ----------
    angle : callable        scalar time (s) -> scalar angle (rad), written with jax.numpy
    times : array (t,)      s

    Raises
    ------
    ModelError  the law or a derivative is not finite at one of the times
    """
    rate = jax.grad(angle)
    acceleration = jax.grad(rate)
    sample = jax.jit(jax.vmap(lambda time: (angle(time), rate(time), acceleration(time))))
    with jax.enable_x64(True):
        samples = [np.asarray(values) for values in sample(times)]
    finite = np.all([np.isfinite(values) for values in samples], axis=0)
    if not finite.all():
        raise ModelError(
            f"the prescribed angle or one of its derivatives is not finite at t = {times[~finite][0]:g} s: "
            "give a law that is smooth over the whole run"
        )
    return AngleHistory(*samples)
