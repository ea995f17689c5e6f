"""What is told and drawn of a run besides its result file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field

from supple.cases.body_kinds import kinds_that
from supple.cases.raw_tables import Mistakes, Raw, table, tables
from supple.cases.table import Table
from supple.integrate import Solution
from supple.machine import System
from supple.machine.system import interface_names
from supple.mesh import Mesh
from supple.results import TrackedMotion, tracked_motion


class Output(Table):
    """What is drawn besides the result file."""

    track: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        (), description="BODY.INTERFACE or BODY.NODE_SET whose motion is printed and drawn"
    )
    pictures: bool = Field(True, description="draw mesh, modes, motion and deformed bodies (PNG)")
    animation: bool = Field(True, description="draw the motion (GIF)")
    colour: Literal["deflection", "von-mises"] = Field(
        "deflection",
        description="what colours the film; von-mises also draws contours where the stress is largest",
    )

    def tracked(
        self, system: System, meshes: Mapping[str, Mesh], solution: Solution
    ) -> dict[str, TrackedMotion]:
        """Motion of the places to track, by place."""
        motions = {}
        for place in self.track:
            name, _, where = place.partition(".")
            body = system.bodies[system.body_index(name)].body
            at = where if where in interface_names(body) else meshes[name].nodes_of(where)
            motions[place] = tracked_motion(body, solution.bodies[name], at)
        return motions


def _stress_has_elements(raw: Raw) -> Mistakes:
    able = kinds_that("has_elements")
    shown = table(raw, "output").get("colour") == "von-mises"
    if shown and not any(kind in body for _, body in tables(raw, "body") for kind in able):
        yield (
            ("output", "colour"),
            f"no body has elements whose stress could be shown ({', '.join(able)}); remove the key",
        )


RULES = (_stress_has_elements,)
