"""Forces and moments across a section: of an elastic body, or of one beam or rod at one of its ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from supple.arguments import check_fields
from supple.arrays import FloatArray
from supple.body import BodyForm
from supple.body.sections import CuttingPlane, Sections
from supple.errors import ModelError
from supple.fem import FiniteElementModel, beam_force_recovery
from supple.integrate import FramedMotion, Solution
from supple.machine import System
from supple.mesh import CellType
from supple.quantities.place import Place, as_place, body_named
from supple.quantities.reading import LOAD, Channel, QuantityKind, vector_channels
from supple.quantities.stress_history import tensor_blocks
from supple.quantities.tensor_modes import NodalTensor

__all__ = ["BeamForceSensor", "SectionForceSensor"]


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


@dataclass(frozen=True)
class BeamForceSensor:
    """N, Vy, Vz, T, My, Mz at one end of a beam or rod, (t, 6), in axes that rotate with the section.

    They are the forces and moments that the part towards the beam's second end exerts on the part before the
    section. N is positive in tension, and moments refer to the axis of the beam (`beam_forces`).

    body : name of the body;   model : finite elements of the body
    beam : id of the element in the mesh or deck
    end : 1 or 2, the first or second end of the element
    """

    name: str
    body: str
    model: FiniteElementModel
    beam: int
    end: int = 1

    def __post_init__(self) -> None:
        check_fields(self)
        if self.end not in (1, 2):
            raise ModelError(f"sensor '{self.name}': a beam has ends 1 and 2, not {self.end}")

    def channels(self, system: System) -> Sequence[Channel]:
        """Three forces and three moments."""
        self._beam(system)
        axes = f"section of beam {self.beam} of {self.body}"
        kinds = (QuantityKind.FORCE, QuantityKind.MOMENT)
        names = (("N", "Vy", "Vz"), ("T", "My", "Mz"))
        place = f"end {self.end}"
        return [
            Channel(name, kind, axes, place) for kind, own in zip(kinds, names, strict=True) for name in own
        ]

    def values(self, system: System, solution: Solution) -> FloatArray:
        """(t, 6)."""
        form, cell = self._beam(system)
        node = self.model.mesh.cells[CellType.LINE2][cell, self.end - 1]
        forces = NodalTensor(partial(beam_force_recovery, cell=cell), partial(np.linalg.norm, axis=-1))
        coordinates = solution.motion(self.body, FramedMotion).coordinates
        found = np.zeros((len(coordinates), 6))
        for times, _, field in tensor_blocks(forces, form, self.model, coordinates, [node]):
            found[times] = field[:, 0, 0]
        return found

    def _beam(self, system: System) -> tuple[BodyForm, int]:
        """The body, and the number of the cell at the sensor's end; an element may have several cells."""
        form = body_named(system, self.body, self.name)
        if not (form.n_coordinates and form.has_frame):
            raise ModelError(
                f"sensor '{self.name}': body '{self.body}' is {form.kind}: its beams have no force"
            )
        ids = self.model.mesh.cell_ids.get(CellType.LINE2, np.empty(0, dtype=np.int64))
        own = np.flatnonzero(ids == self.beam)
        if not own.size:
            known = f"ids {ids.min()} to {ids.max()}" if ids.size else "none"
            raise ModelError(f"sensor '{self.name}': there is no beam {self.beam}; the body has {known}")
        return form, int(own[0] if self.end == 1 else own[-1])
