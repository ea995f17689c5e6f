"""How a method steps a machine: the seam between a step program and the marches."""

from __future__ import annotations

from typing import Any, Protocol

from supple.equations.configuration import SystemMotion
from supple.equations.machine_model import Model

__all__ = ["Marching", "MarchingState"]


class MarchingState(Protocol):
    """All that a method carries from step to step, a pytree."""

    @property
    def time(self) -> Any:
        """()"""
        ...

    @property
    def failed(self) -> Any:
        """() whether the smallest step did not converge: the state is that before the step."""
        ...


class Marching(Protocol):
    """A method as functions of its arrays, which JAX traces."""

    @property
    def size(self) -> float:
        """Of a step, in the unit of time."""
        ...

    @property
    def n_velocities(self) -> int:
        """Number of velocities of the machine, as the march has them."""
        ...

    def reached(self, arrays: Any, state: Any, end: Any, /) -> Any:
        """The state at a time, by equal steps of `size` at most."""
        ...

    def motion(self, arrays: Any, state: Any, /) -> SystemMotion:
        """The motion of a state as sensors see it."""
        ...

    def model(self, arrays: Any, /) -> Model:
        """The bodies, joints and forces that sensors see."""
        ...
