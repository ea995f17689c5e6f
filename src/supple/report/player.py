"""Player of a run in a notebook."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from types import MappingProxyType

from supple.arguments import checked_arguments
from supple.fem import FiniteElementModel
from supple.integrate import Solution
from supple.machine import At, System
from supple.quantities import Reading, TrackedMotion
from supple.report.charts import charts_of
from supple.report.moving_machine import moving_machine
from supple.report.page import Page, page_text
from supple.results.body_surface import Look
from supple.units import UNNAMED, UnitSystem

__all__ = ["Player", "player"]

_HEIGHT = 760
"""Height in a notebook, pixels."""


@dataclass(frozen=True, eq=False)
class Player:
    """A page that a notebook displays if it is the value of the last expression of a cell."""

    page: Page = field(repr=False)

    def __repr__(self) -> str:
        machine = self.page.machine
        instants = 0 if machine is None else len(machine.times)
        return f"<Player of {instants} output times, for a notebook; write_report writes a file>"

    def _repr_html_(self) -> str:
        """The page in a frame that separates its styles and scripts from those of the notebook."""
        frame = f"width: 100%; height: {_HEIGHT}px; border: 0"
        return f'<iframe srcdoc="{escape(page_text(self.page))}" style="{frame}"></iframe>'


@checked_arguments
def player(
    system: System,
    solution: Solution,
    meshes: Mapping[str, Look] = MappingProxyType({}),
    *,
    tracked: Mapping[str, TrackedMotion] = MappingProxyType({}),
    readings: Sequence[Reading] = (),
    elements: Mapping[str, FiniteElementModel] | None = None,
    bases: Mapping[str, At] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> Player:
    """The motion and the curves of a report, without its tables, for a notebook.

    Parameters and errors as for `write_report`.
    """
    machine = moving_machine(system, solution, meshes, elements=elements, bases=bases, units=units)
    charts = list(charts_of(system, solution, tracked=tracked, readings=readings, units=units))
    return Player(Page("", [], machine, charts=charts, units=units))
