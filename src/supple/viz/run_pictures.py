"""Pictures of a run: meshes, modes, deformation, machine, tracked motion, joint forces."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

from supple.arguments import checked_arguments
from supple.fem import FiniteElementModel, has_stress
from supple.integrate import Solution
from supple.machine import At, System
from supple.methods.explicit import ENERGIES
from supple.methods.intrinsic import IntrinsicBody
from supple.quantities import TrackedMotion
from supple.reduction import BodyModes, ReducedBody
from supple.results.body_surface import Look
from supple.results.camera import AS_IT_IS, Camera, View
from supple.results.colouring import Colouring
from supple.storage import file_name
from supple.units import UNNAMED, UnitSystem, with_unit
from supple.viz.body_pictures import (
    DrawnBody,
    draw_deformed,
    draw_intrinsic_modes,
    draw_mesh,
    draw_modes,
    draw_stress,
)
from supple.viz.machine_camera import machine_camera
from supple.viz.machine_scene import drawn_bodies, machine_scene
from supple.viz.mesh_plot import NodalField, plot_mesh
from supple.viz.run_curves import draw_energies, draw_joint_forces, draw_tracked

__all__ = ["draw_machine", "draw_run"]

Elements = Mapping[str, FiniteElementModel]


@checked_arguments
def draw_run(
    folder: Path,
    system: System,
    solution: Solution,
    meshes: Mapping[str, Look | None],
    *,
    tracked: Mapping[str, TrackedMotion] = MappingProxyType({}),
    modes: Mapping[str, BodyModes] = MappingProxyType({}),
    elements: Elements | None = None,
    bases: Mapping[str, At] = MappingProxyType({}),
    view: View = AS_IT_IS,
    units: UnitSystem = UNNAMED,
) -> list[Path]:
    """Draw all pictures of a run, without the animation.

    For each body: mesh, modes, largest deflection, largest stress. For the machine: its start, energies of an
    explicit run, tracked places, joint forces.

    Parameters
    ----------
    meshes : by name of each elastic body to draw, its mesh, or its elements, which contain the beam sections;
        None draws the nodes of the body as points
    tracked : motions of places, by their names
    modes : modes of the unreduced bodies (`body_modes`), by name; by default modes of the bases of reduction,
        which may differ from them; the title of the picture then contains "of its basis"
    elements : elements of bodies, by name, to draw their von Mises stress; see `von_mises_history`
    bases : reference interfaces of deflections, by body; by default the first interface of the body
    view : camera in global axes, and enlargement of the deflection of bodies
    units : of the model; no unit is written for units without names

    Returns
    -------
    the paths of the pictures
    """
    for name in elements or ():
        system.placed(name, "elements")  # a misspelt name is an error
    camera = view.camera or machine_camera(system, solution, meshes)
    seen = View(camera, view.enlargement)
    pictures: list[Path] = []
    reduced, lines = system.bodies_of(ReducedBody), system.bodies_of(IntrinsicBody)
    bodies = drawn_bodies(system, meshes)
    for body, surface in bodies:
        if surface is None:
            continue
        # In the mesh axes of the body, from the same side as for the machine.
        own = View(Camera(camera.axes @ system.placed(body.name).rotation), seen.enlargement)
        drawn = DrawnBody(body, surface, own, units)

        def path(what: str, name: str = body.name) -> Path:
            return folder / f"{file_name(name)}-{what}.png"

        pictures.append(draw_mesh(path("mesh"), drawn))
        if body.name in reduced:
            pictures.append(draw_modes(path("modes"), drawn, reduced[body.name], modes.get(body.name)))
        if body.name in lines:
            pictures.append(draw_intrinsic_modes(path("modes"), drawn, lines[body.name]))
        if not body.has_frame:
            continue
        pictures.append(draw_deformed(path("deformed"), drawn, system, solution, bases))
        model = (elements or {}).get(body.name)
        if model is not None and has_stress(model):
            pictures.append(draw_stress(path("stress"), drawn, model, solution))
    rigid = any(not placed.body.n_coordinates and placed.body.has_frame for placed in system.bodies)
    if rigid or system.joints or any(surface is None for _, surface in bodies):
        machine = draw_machine(folder / "machine.png", system, solution, meshes, view=seen, units=units)
        pictures += [] if machine is None else [machine]
    if ENERGIES in solution.series:
        pictures.append(draw_energies(folder / "energies.png", solution, units))
    if tracked:
        pictures.append(draw_tracked(folder / "tracked-motion.png", tracked, solution.times, units))
    forces = draw_joint_forces(folder / "joint-forces.png", system, solution, units)
    return pictures if forces is None else [*pictures, forces]


@checked_arguments
def draw_machine(
    path: Path,
    system: System,
    solution: Solution,
    meshes: Mapping[str, Look | None],
    *,
    title: str | None = None,
    colouring: Colouring | None = None,
    bases: Mapping[str, At] = MappingProxyType({}),
    view: View = AS_IT_IS,
    rest: Solution | None = None,
    units: UnitSystem = UNNAMED,
) -> Path | None:
    """Draw the whole machine at its start; None if there is nothing to draw.

    title : by default the time
    colouring : colours of the bodies, drawn over outlines of the undeformed bodies; by default plain bodies
    rest : solution whose first time replaces the undeformed bodies in the outlines
    Other parameters as for `draw_run`.
    """
    camera = view.camera or machine_camera(system, solution, meshes)
    scene = machine_scene(
        system,
        solution,
        meshes,
        np.array([0]),
        camera,
        enlargement=view.enlargement or 1.0,
        colouring=colouring,
        rest=rest,
        bases=bases,
        units=units,
    )
    if scene.is_empty:
        return None
    instant = with_unit(f"t = {solution.times[0]:.4g}", units.time)
    return plot_mesh(
        path,
        scene.positions[0],
        scene.skin,
        glyphs=scene.glyphs,
        colour_by=None if scene.values is None else NodalField(scene.label, scene.values[0]),
        undeformed=None if colouring is None or scene.skin is None else scene.undeformed,
        camera=camera,
        title=instant if title is None else title,
        units=units,
    )
