"""Force and moment across a section of an elastic body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from supple.arguments import check_fields
from supple.arrays import FloatArray
from supple.body.sections import CuttingPlane, Sections
from supple.errors import ModelError
from supple.fem import FiniteElementModel
from supple.integrate import Solution
from supple.machine import System
from supple.quantities.place import Place, as_place
from supple.quantities.reading import LOAD, Channel, vector_channels

__all__ = ["SectionForceSensor"]


@dataclass(frozen=True, eq=False)
class SectionForceSensor:
    """Force and moment that the far side of a section exerts on the near side, (t, 6).

    The section is the undeformed plane through a place, normal to a direction in the axes of the mesh. It
    cuts the whole body. Moments refer to the place. Components are along the body's axes; for an intrinsic
    body they are along axes that rotate with the section.

    place : Place       an interface, or the mean of some nodes
    normal : (3,)       direction from the near side to the far side
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
        sections = self._sections(system)
        try:
            sections.check(self._plane(system))
        except ModelError as error:
            raise ModelError(f"sensor '{self.name}': {error}") from error
        return vector_channels(sections.axes, LOAD)

    def values(self, system: System, solution: Solution) -> FloatArray:
        """(t, 6)."""
        return self._sections(system).loads(solution.bodies[self.place.body], self._plane(system))

    def _plane(self, system: System) -> CuttingPlane:
        x, y, z = self.place.rest(self.place.body_of(system, self.name)).tolist()
        return CuttingPlane((x, y, z), self.normal)

    def _sections(self, system: System) -> Sections:
        body = self.place.body_of(system, self.name)
        try:
            return body.sections(self.model)
        except ModelError as error:
            raise ModelError(f"sensor '{self.name}': {error}") from error
