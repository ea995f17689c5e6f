"""Base of all loads on nodes of a body: forces on facets, each of one or a few nodes.

A load defines one function, `facet_forces`, from which the solvers compute the forces on all facets and the
derivatives of these forces. If the force on a node does not depend on other nodes, a facet is a single node.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import jax
import numpy as np
from numpy.typing import ArrayLike

from supple.arguments import check_numbers
from supple.errors import ModelError
from supple.machine.laws.time_law import TimeLaw, as_time_law

__all__ = ["NodalLoad"]


@dataclass(frozen=True, kw_only=True)
class NodalLoad(ABC):
    """Forces on nodes of one body."""

    body: str

    law_field: ClassVar[str]
    """Field with the law of time: a number, an array, a function of time or a law."""
    follows_nodes: ClassVar[bool]
    """True if the forces, in body components, depend on the displacements of the nodes."""
    turns_against_frame: ClassVar[bool]
    """True if the forces, in body components, depend on the rotation of the frame."""

    @property
    @abstractmethod
    def label(self) -> str:
        """Name for messages."""

    @property
    def law(self) -> TimeLaw:
        """The law of time."""
        return as_time_law(getattr(self, self.law_field))

    @property
    @abstractmethod
    def nodes(self) -> np.ndarray:
        """Node indices (k,), each once; empty for a load at an interface."""

    @property
    @abstractmethod
    def facets(self) -> np.ndarray:
        """Nodes (e, m) of each facet, as positions in `nodes`."""

    @property
    @abstractmethod
    def value_shapes(self) -> tuple[tuple[int, ...], ...]:
        """Allowed shapes of the law's value: one value for all facets, and (e, ...), one value per facet."""

    @staticmethod
    @abstractmethod
    def facet_forces(places: jax.Array, rotation: jax.Array, value: jax.Array) -> jax.Array:
        """Forces (m, 3) on the nodes of a facet, body components.

        places : (m, 3)     positions of the nodes, from the frame's origin, body components
        rotation : (3, 3)   of the body's frame, from body to global components
        value : value of the law for this facet, at this time
        """


def node_numbers(label: str, nodes: ArrayLike) -> np.ndarray:
    """Node indices (k,) as integers; ModelError unless they are a list of one or more whole numbers."""
    check_numbers(f"{label}, nodes", nodes)
    numbers = np.asarray(nodes)
    if numbers.ndim != 1 or numbers.size == 0:
        raise ModelError(f"{label}: node indices must be a list of at least one node")
    if (numbers != np.round(numbers)).any():
        raise ModelError(
            f"{label}: node indices are whole numbers, got {numbers[numbers != np.round(numbers)][0]}"
        )
    return numbers.astype(int)
