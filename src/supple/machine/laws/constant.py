"""A constant quantity."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import numpy as np
from jax.typing import ArrayLike

from supple.algebra import read_only
from supple.errors import ModelError
from supple.machine.laws.law_numbers import Numbers, SmoothLaw, are_numbers

__all__ = ["Constant"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Constant(SmoothLaw):
    """The same value at all times.

    value : number or array
    Raises ModelError for NaN or infinite entries.
    """

    value: Numbers

    def __post_init__(self) -> None:
        if not are_numbers(self.value):
            return
        value = read_only(self.value)
        if not np.isfinite(value).all():
            raise ModelError(f"a constant quantity has NaN or infinite entries: {value}; give finite numbers")
        object.__setattr__(self, "value", value)

    def __call__(self, time: ArrayLike) -> jax.Array:  # noqa: ARG002 - the signature of a law
        """The value."""
        return self.value
