"""A quantity given as a function of time of the user's own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import jax

from supple.machine.laws.unbounded_law import UnboundedLaw

__all__ = ["TimeFunction"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class TimeFunction(UnboundedLaw):
    """A function of time written with `jax.numpy`.

    It must be smooth enough for its use: twice differentiable where it prescribes a motion.

    The function is part of the compiled program, not of its data: another function object, even a lambda of
    the same text, compiles anew, and the cases of a batch must share one object. Numbers that differ between
    runs or cases belong into the other laws.
    """

    function: Callable[[Any], Any] = field(metadata={"static": True})

    def __call__(self, time: Any) -> Any:
        """The function's value."""
        return self.function(time)
