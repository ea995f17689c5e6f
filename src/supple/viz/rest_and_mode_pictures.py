"""Pictures and animations of a machine at rest, and of its modes about rest."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

from supple.arguments import checked_arguments
from supple.arrays import FloatArray
from supple.body import BodyForm
from supple.fem import FiniteElementModel
from supple.integrate import Motion, Solution
from supple.machine import At, System
from supple.quantities import deflections, node_positions, observer_of
from supple.results.body_surface import Look
from supple.results.camera import AS_IT_IS, View, enlarged_words
from supple.results.colouring import DEFLECTION, Colouring, stress_colouring
from supple.units import UNNAMED, UnitSystem, with_unit
from supple.viz.body_pictures import visible_enlargement
from supple.viz.run_animation import animate_run
from supple.viz.run_pictures import draw_machine

__all__ = ["animate_mode", "draw_mode", "draw_rest"]


@checked_arguments
def draw_rest(
    path: Path,
    system: System,
    solution: Solution,
    meshes: Mapping[str, Look | None],
    *,
    elements: Mapping[str, FiniteElementModel] | None = None,
    bases: Mapping[str, At] = MappingProxyType({}),
    view: View = AS_IT_IS,
    units: UnitSystem = UNNAMED,
) -> Path | None:
    """Draw an equilibrium over the outlines of the undeformed bodies; None if there is nothing to draw.

    Colours show the deflection, or with `elements` the stress. Unless `view` sets the enlargement, the
    deflection of a single body is enlarged until visible. Several bodies are drawn true to scale, because
    their joints would open otherwise. Other parameters as for `draw_run`.
    """
    enlargement = view.enlargement or _visible(system, solution, bases)
    return draw_machine(
        path,
        system,
        solution,
        meshes,
        title=f"equilibrium, {enlarged_words(enlargement)}",
        colouring=DEFLECTION if elements is None else stress_colouring(elements),
        bases=bases,
        view=View(view.camera, enlargement),
        units=units,
    )


def _visible(system: System, solution: Solution, bases: Mapping[str, At]) -> float:
    """The enlargement of the deflection of a machine with one body; 1 for other machines."""
    (first, *others) = (placed.body for placed in system.bodies)
    if others or not (first.n_coordinates and first.has_frame):
        return 1.0
    observer = observer_of(system, solution, first.name, bases)
    return visible_enlargement(first, deflections(first, solution.bodies[first.name], observer)[0])


@checked_arguments
def draw_mode(
    path: Path,
    system: System,
    motion: Solution,
    rest: Solution,
    meshes: Mapping[str, Look | None],
    *,
    title: str,
    view: View = AS_IT_IS,
    units: UnitSystem = UNNAMED,
) -> Path | None:
    """Draw a mode at its first phase, coloured by its displacement, over the outline of the machine at rest.

    motion, rest : from `mode_motion` and `LinearMachine.motion_near`
    title : such as one of `mode_titles`; the largest drawn displacement is added
    Returns None if there is nothing to draw. Other parameters as for `draw_run`.
    """
    return draw_machine(
        path,
        system,
        motion,
        meshes,
        title=f"{title}, {_drawn_as(system, motion, rest, units)}",
        colouring=_share_of_largest(system, motion, rest),
        view=view,
        rest=rest,
        units=units,
    )


@checked_arguments
def animate_mode(
    path: Path,
    system: System,
    motion: Solution,
    rest: Solution,
    meshes: Mapping[str, Look | None],
    *,
    title: str,
    view: View = AS_IT_IS,
    units: UnitSystem = UNNAMED,
) -> Path | None:
    """Animate a mode over the outline of the machine at rest; parameters and result as for `draw_mode`."""
    return animate_run(
        path,
        system,
        motion,
        meshes,
        colouring=_share_of_largest(system, motion, rest),
        view=view,
        rest=rest,
        caption=f"{title}\n{_drawn_as(system, motion, rest, units)}",
        units=units,
    )


def _drawn_as(system: System, motion: Solution, rest: Solution, units: UnitSystem) -> str:
    largest = with_unit(f"{_largest(system, motion, rest):.3g}", units.length)
    return f"largest displacement drawn as {largest}"


def _largest(system: System, motion: Solution, rest: Solution) -> float:
    """The largest displacement of any node, or interface of a rigid body, from rest."""
    bodies = (placed.body for placed in system.bodies)
    return max(float(_displacement(each, motion.bodies[each.name], rest).max(initial=0.0)) for each in bodies)


def _displacement(body: BodyForm, motion: Motion, rest: Solution) -> FloatArray:
    """Displacement magnitudes (t, N) of all nodes from rest."""
    still = rest.bodies[body.name].at(np.array([0]))
    return np.linalg.norm(node_positions(body, motion) - node_positions(body, still), axis=2)


def _share_of_largest(system: System, motion: Solution, rest: Solution) -> Colouring:
    """Colouring by displacement relative to the largest, because the scale of a mode is arbitrary."""
    largest = _largest(system, motion, rest) or 1.0
    return Colouring(
        lambda body, own, _: _displacement(body, own, rest) / largest,
        lambda _: ("displacement, share of the largest", 1.0),
    )
