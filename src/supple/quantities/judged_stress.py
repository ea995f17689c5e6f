"""Stress as a quantity whose error is stated."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from supple.body import FullBody
from supple.errors import ModelError
from supple.fem import FiniteElementModel
from supple.integrate import Solution
from supple.machine import System
from supple.quantities.stress_history import von_mises_history
from supple.quantities.tensor_modes import TensorModes, stress_modes
from supple.reduction import ReducedBody

__all__ = ["JudgedStress"]


@dataclass(frozen=True, eq=False)
class JudgedStress:
    """Von Mises stress at nodes of a body, a `JudgedQuantity`; its error is an RMS over the nodes.

    model : its elements
    nodes : node numbers
    """

    body: str
    model: FiniteElementModel
    nodes: NDArray[np.int64] | tuple[int, ...]
    label: str = ""
    _modes: WeakKeyDictionary[Any, TensorModes] = field(default_factory=WeakKeyDictionary, repr=False)

    @property
    def name(self) -> str:
        """Says where the stress is."""
        return f"stress at {self.label or self.body}"

    @property
    def words(self) -> str:
        """The quantity and its norm."""
        return f"von Mises {self.name}: RMS over its nodes, largest over the run"

    def values(self, system: System, solution: Solution) -> NDArray[np.float64]:
        """Stress (t, k, 1)."""
        form = system.bodies[system.body_index(self.body, "stated error")].body
        if not isinstance(form, ReducedBody | FullBody):
            raise ModelError(f"stated error: the stress of body '{self.body}' is known of its elements alone")
        coordinates, nodes = solution.bodies[self.body].coordinates, np.asarray(self.nodes)
        if not (isinstance(form, ReducedBody) and form.has_stress_modes):
            return von_mises_history(form, self.model, coordinates, nodes)[..., None]
        if form not in self._modes:
            self._modes[form] = stress_modes(form, self.model, nodes)
        return self._modes[form].von_mises(coordinates)[..., None]

    def size(self, system: System, solution: Solution) -> float:
        """The largest stress there."""
        return float(self.values(system, solution).max())
