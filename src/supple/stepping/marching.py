"""Protocol between a step program and the time integration of a method."""

from __future__ import annotations

from typing import Protocol

from supple.arrays import AnyArray, Tree
from supple.equations.configuration import SystemMotion
from supple.equations.machine_model import Model


class MarchingState(Protocol):
    """The state of a method between two steps, a pytree."""

    @property
    def time(self) -> AnyArray:
        """Time, shape ()."""
        ...

    @property
    def failed(self) -> AnyArray:
        """Whether the smallest step did not converge, shape (); the state is then that before the step."""
        ...


class Marching(Protocol):
    """The time integration of a method, as functions that JAX can trace."""

    @property
    def size(self) -> float:
        """Time step, in the unit of time."""
        ...

    @property
    def n_velocities(self) -> int:
        """Number of velocities of the machine in the time integration."""
        ...

    def reached(self, arrays: Tree, state: Tree, end: AnyArray, /) -> Tree:
        """The state at the time `end`, by equal steps of `size` at most."""
        ...

    def motion(self, arrays: Tree, state: Tree, /) -> SystemMotion:
        """The motion of a state, for the sensors."""
        ...

    def model(self, arrays: Tree, /) -> Model:
        """The model of bodies, joints and forces, for the sensors."""
        ...
