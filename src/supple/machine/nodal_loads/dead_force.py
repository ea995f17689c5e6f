"""Forces over time, with directions fixed in space, at an interface or at nodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import jax
import numpy as np

from supple.arguments import check_fields, check_numbers
from supple.errors import ModelError
from supple.machine.ends import GROUND, as_end
from supple.machine.laws.time_law import OverTime, check_law_kind
from supple.machine.nodal_loads.nodal_load import NodalLoad, node_numbers

__all__ = ["DeadForce"]


@dataclass(frozen=True, kw_only=True)
class DeadForce(NodalLoad):
    """Forces in global components, at an interface or at nodes of a body.

    Raises ModelError if `at` is a list of nodes without `body`, or the ground.
    """

    body: str = ""
    """Name of the body; omitted if `at` is "BODY.INTERFACE"."""
    at: str | Sequence[int] | np.ndarray
    """Name of an interface of `body`, or indices (k,) of its nodes; without `body`, "BODY.INTERFACE"."""
    force: OverTime
    """(3,), the force on the interface or on each node, or (k, 3), one force per node.

    It is a constant, a law or a function of time.
    """

    law_field: ClassVar[str] = "force"
    follows_nodes: ClassVar[bool] = False
    turns_against_frame: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_fields(self)
        if not isinstance(self.at, str):
            check_numbers("DeadForce, at", self.at)
        check_law_kind("DeadForce", self)
        if self.body:
            return
        if not isinstance(self.at, str):
            raise ModelError("DeadForce on nodes: give the body of these nodes")
        end = as_end(self.at)
        if end == GROUND:
            raise ModelError("DeadForce acts on the ground: give a body's interface")
        object.__setattr__(self, "body", end.body)
        object.__setattr__(self, "at", end.interface)

    @property
    def label(self) -> str:
        """Name for messages."""
        where = f"'{self.at}'" if isinstance(self.at, str) else f"{len(self.at)} nodes"
        return f"DeadForce on {where} of '{self.body}'"

    @property
    def nodes(self) -> np.ndarray:
        """The node indices (k,); empty at an interface."""
        return np.zeros(0, int) if isinstance(self.at, str) else node_numbers(self.label, self.at)

    @property
    def facets(self) -> np.ndarray:
        """(k, 1), one facet per node; (1, 1) at an interface."""
        return np.arange(1 if isinstance(self.at, str) else len(self.nodes))[:, None]

    @property
    def value_shapes(self) -> tuple[tuple[int, ...], ...]:
        """(3,): the force on the interface, or on each node alike; (k, 3): one force per node."""
        return ((3,),) if isinstance(self.at, str) else ((3,), (len(self.nodes), 3))

    @staticmethod
    def facet_forces(places: jax.Array, rotation: jax.Array, value: jax.Array) -> jax.Array:  # noqa: ARG004
        """`A^T F`, (1, 3), with the rotation A of the frame and the global force F."""
        return (value @ rotation)[None]
