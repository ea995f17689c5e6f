"""Force and moment across a section of an elastic body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.arguments import check_fields
from supple.body import FullBody
from supple.errors import ModelError
from supple.fem import FiniteElementModel
from supple.integrate import Solution
from supple.machine import System
from supple.methods.intrinsic import IntrinsicBody
from supple.quantities.force_sensors import six_channels
from supple.quantities.place import Place, as_place
from supple.quantities.reading import Channel
from supple.quantities.section_loads import CuttingPlane, line_section_loads, section_loads
from supple.reduction import ReducedBody

__all__ = ["SectionForceSensor"]


@dataclass(frozen=True, eq=False)
class SectionForceSensor:
    """Force and moment that what lies beyond a section exerts on what lies before it, (t, 6).

    The section is the plane through a place, undeformed, across a normal in the axes of the mesh. It cuts the
    whole body. Moments are about the place. Components are along the body's axes; of an intrinsic body
    along those that turn with the section.

    place : Place       an interface, or the mean of some nodes
    normal : (3,)       towards what lies beyond
    model : FiniteElementModel | None    the body's elements; an intrinsic body needs none
    """

    name: str
    place: Place
    normal: tuple[float, float, float]
    model: FiniteElementModel | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "place", as_place(f"SectionForceSensor '{self.name}', place", self.place))
        check_fields(self)

    def channels(self, system: System) -> Sequence[Channel]:
        """Fx, Fy, Fz, Mx, My, Mz."""
        body = self._body(system)
        owner = "the section of " if isinstance(body, IntrinsicBody) else ""
        return six_channels(f"axes of {owner}{self.place.body}")

    def values(self, system: System, solution: Solution) -> NDArray[np.float64]:
        """(t, 6)."""
        body = self._body(system)
        x, y, z = self.place.rest(body).tolist()
        plane = CuttingPlane((x, y, z), self.normal)
        if isinstance(body, IntrinsicBody):
            return line_section_loads(body, solution.bodies[body.name], plane)
        assert self.model is not None  # `_body` has looked
        return section_loads(body, self.model, solution.bodies[body.name], plane)

    def _body(self, system: System) -> IntrinsicBody | ReducedBody | FullBody:
        """The body, whose sections have forces that are known."""
        body = self.place.body_of(system, self.name)
        if not isinstance(body, IntrinsicBody | ReducedBody | FullBody):
            raise ModelError(
                f"sensor '{self.name}': body '{body.name}' is {body.kind}, which has no section forces; read "
                "the force of a joint, or split the body there"
            )
        if self.model is None and not isinstance(body, IntrinsicBody):
            raise ModelError(
                f"sensor '{self.name}': the elements of body '{body.name}' are not known, and section forces "
                "are theirs; give its model, or read the force of a joint or a spring"
            )
        return body
