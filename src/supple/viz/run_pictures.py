"""Pictures of a run: meshes, modes, deformation, machine, tracked motion, joint forces, animation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

from supple.arguments import checked_arguments
from supple.body import BodyForm
from supple.fem import FiniteElementModel, has_stress
from supple.integrate import Solution
from supple.machine import At, System
from supple.methods.explicit import ENERGIES, OBSTACLES, Energies
from supple.methods.intrinsic import IntrinsicBody
from supple.quantities import (
    TrackedMotion,
    deflections,
    joint_loads,
    node_positions,
    observer_of,
)
from supple.reduction import BodyModes, ReducedBody
from supple.results import without_noise
from supple.results.body_surface import BodySurface, Look, body_surface
from supple.results.colouring import DEFLECTION, Colouring, stress_colouring
from supple.storage import file_name
from supple.units import UNNAMED, UnitSystem, labelled, measured
from supple.viz.animation import Traces, animate
from supple.viz.body_pictures import (
    draw_deformed,
    draw_intrinsic_modes,
    draw_modes,
    draw_stress,
    instants_of,
)
from supple.viz.camera import Camera
from supple.viz.contact_clearance import clear_of_contact
from supple.viz.glyphs import POINT_STYLE, Glyphs, Mark, glyphs_of, surface_glyphs
from supple.viz.machine_picture import plot_machine
from supple.viz.mesh_plot import plot_mesh
from supple.viz.scene import Actor, obstacle_actor, scene_of
from supple.viz.style import as_written
from supple.viz.time_history import Panel, Series, plot_time_history

__all__ = ["animate_run", "draw_machine", "draw_run"]

Elements = Mapping[str, FiniteElementModel]

N_FRAMES = 60
FRAMES_PER_SECOND = 12.0


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
    units: UnitSystem = UNNAMED,
) -> list[Path]:
    """Draw everything but the animation: mesh, modes and deformation of the bodies, what is tracked, joints.

    Parameters
    ----------
    folder : where the pictures go
    meshes : of the elastic bodies to draw, by name; or their elements, which know the sections of beams; or
        None of a body without either, whose nodes are drawn as points
    tracked : motions of places, by their names
    modes : of reduced bodies with all their coordinates, by name (`body_modes`); the lowest motions of their
        bases, which may be no modes of the bodies and are titled so, are drawn without
    elements : of these bodies, by name, to draw their von Mises stress too; see `von_mises_history`
    bases : interfaces that deflections are seen from, by body, where it is not its own first one
    units : of the model; without names no unit is written

    Returns
    -------
    the paths of the pictures
    """
    pictures: list[Path] = []
    reduced, lines = system.bodies_of(ReducedBody), system.bodies_of(IntrinsicBody)
    for body, surface in _drawn(system, meshes):

        def path(what: str, name: str = body.name) -> Path:
            return folder / f"{file_name(name)}-{what}.png"

        pictures.append(
            plot_mesh(
                path("mesh"),
                surface.rest,
                surface.skin,
                glyphs=surface_glyphs(surface, surface.mesh.nodes[None]),
                title=as_written(body.name),
                units=units,
            )
        )
        if body.name in reduced:
            pictures.append(
                draw_modes(path("modes"), reduced[body.name], modes.get(body.name), surface, units)
            )
        if body.name in lines:
            pictures.append(draw_intrinsic_modes(path("modes"), lines[body.name], surface, units))
        if not body.has_frame:
            continue
        pictures.append(draw_deformed(path("deformed"), body, (system, solution), bases, surface, units))
        if elements is not None and has_stress(elements[body.name]):
            model = elements[body.name]
            pictures.append(draw_stress(path("stress"), body, model, surface, solution, units))
    machine = draw_machine(folder / "machine.png", system, solution, meshes, units=units)
    if machine is not None:
        pictures.append(machine)
    if ENERGIES in solution.series:
        pictures.append(_draw_energies(folder / "energies.png", solution, units))
    if tracked:
        pictures.append(_draw_tracked(folder / "tracked-motion.png", tracked, solution.times, units))
    panels = _joint_panels(system, solution, units)
    if panels:
        pictures.append(
            plot_time_history(
                folder / "joint-forces.png", panels, n_columns=len(panels) // len("xyz"), units=units
            )
        )
    return pictures


@checked_arguments
def animate_run(
    path: Path,
    system: System,
    solution: Solution,
    meshes: Mapping[str, Look | None],
    *,
    elements: Elements | None = None,
    colouring: Colouring | None = None,
    bases: Mapping[str, At] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
    progress: Callable[[float], None] | None = None,
) -> Path | None:
    """Animate a machine: meshes in colour, obstacles, rigid bodies and joints as glyphs.

    Parameters as for `draw_run`; `progress` receives the share that is drawn. None when there is neither.

    colouring : by default the stress where there are `elements`, and else the deflection
    """
    chosen = instants_of(solution.times, N_FRAMES)
    chosen_colouring = colouring or (DEFLECTION if elements is None else stress_colouring(elements))
    label, factor = chosen_colouring.label(units)
    drawn, traced, coloured = _drawn(system, meshes), [], {}
    for body, surface in drawn:
        motion, deflection = solution.bodies[body.name].at(chosen), None
        if body.has_frame:
            seen_from = observer_of(system, solution, body.name, bases, chosen)
            deflection = np.linalg.norm(deflections(body, motion, seen_from), axis=2)
            # The path of the node that moves most against its body tells how the body swings.
            farthest = int(np.argmax(deflection.max(axis=0)))
            traced.append(node_positions(body, solution.bodies[body.name], [farthest]))
        values = chosen_colouring.values(body, motion, deflection)
        coloured[body.name] = None if values is None else factor * surface.at_points(values)
    motions = {body.name: solution.bodies[body.name].at(chosen) for body, _ in drawn}
    positions = {body.name: node_positions(body, motions[body.name]) for body, _ in drawn}
    offsets = _obstacle_offsets(system, solution, chosen)
    if system.contacts:
        positions = clear_of_contact(system, positions, offsets)
    actors = [
        Actor(
            surface.skin,
            surface.positions(body, motions[body.name], positions[body.name]),
            coloured[body.name],
        )
        for body, surface in drawn
    ]
    if all(own is None for own in coloured.values()):
        label = ""
    moved = [actor.positions.reshape(-1, 3) for actor in actors]
    actors += [
        obstacle_actor(contact.obstacle, offsets[:, number], np.concatenate(moved))
        for number, contact in enumerate(system.rigid_contacts)
    ]
    glyphs = glyphs_of(system, solution, chosen).beside(
        [own for body, surface in drawn if (own := surface_glyphs(surface, positions[body.name])) is not None]
        + _points(system, solution, meshes, chosen)
    )
    if not actors and glyphs.is_empty:
        return None
    scene = scene_of(actors) if actors else None
    moving = scene.positions if scene is not None else np.empty((len(chosen), 0, 3))
    seen = np.concatenate([moving, glyphs.points], axis=1) if not glyphs.is_empty else moving
    return animate(
        path,
        solution.times[chosen],
        moving,
        None if scene is None else scene.skin,
        glyphs=None if glyphs.is_empty else glyphs,
        camera=_upright_camera(seen, system.gravity),
        values=None if scene is None or not label else scene.values,
        values_label="" if scene is None else label,
        traces=Traces(solution.times, np.concatenate(traced, axis=1)) if traced else None,
        frames_per_second=FRAMES_PER_SECOND,
        units=units,
        progress=progress,
    )


@checked_arguments
def draw_machine(
    path: Path,
    system: System,
    solution: Solution,
    meshes: Mapping[str, Look | None],
    *,
    title: str | None = None,
    units: UnitSystem = UNNAMED,
) -> Path | None:
    """Draw the whole machine where it starts; None where it has neither rigid bodies nor joints.

    title : the instant unless given. Other parameters as for `draw_run`.
    """
    start = np.array([0])
    glyphs, beside = glyphs_of(system, solution, start), _points(system, solution, meshes, start)
    if glyphs.is_empty and not beside:
        return None
    actors = []
    for body, surface in _drawn(system, meshes):
        motion = solution.bodies[body.name].at(start)
        actors.append(Actor(surface.skin, surface.positions(body, motion)))
        if (own := surface_glyphs(surface, node_positions(body, motion))) is not None:
            beside.append(own)
    glyphs = glyphs.beside(beside)
    scene = scene_of(actors) if actors else None
    nodes = np.empty((0, 3)) if scene is None else scene.positions[0]
    camera = _upright_camera(np.concatenate([nodes[None], glyphs.points], axis=1), system.gravity)
    instant = measured(f"t = {solution.times[0]:.4g}", units.time)
    skin = None if scene is None else scene.skin
    return plot_machine(path, nodes, skin, glyphs, camera=camera, title=title or instant, units=units)


def _upright_camera(positions: np.ndarray, gravity: np.ndarray) -> Camera | None:
    """Camera with gravity pointing down that sees the widest motion, a little from the side and above."""
    if not gravity.any():
        return None
    up = -gravity / np.linalg.norm(gravity)
    extent = np.ptp(positions.reshape(-1, 3), axis=0)
    level = [axis for axis in np.argsort(extent, kind="stable") if abs(up[axis]) < 0.8]
    thin, wide = np.eye(3)[level[:2]]
    return Camera.looking(along=-thin - 0.35 * wide - 0.25 * up, up=up)


def _drawn(system: System, meshes: Mapping[str, Look | None]) -> list[tuple[BodyForm, BodySurface]]:
    """Elastic bodies that have something to show."""
    elastic = {placed.body.name: placed.body for placed in system.bodies if placed.body.n_coordinates}
    return [
        (elastic[name], body_surface(look))
        for name, look in meshes.items()
        if name in elastic and look is not None
    ]


def _points(
    system: System, solution: Solution, meshes: Mapping[str, Look | None], rows: np.ndarray
) -> list[Glyphs]:
    """The nodes of bodies that have neither mesh nor elements, at some output times."""
    bodies = [placed.body for placed in system.bodies]
    places = [
        node_positions(body, solution.bodies[body.name].at(rows))
        for body in bodies
        if body.n_coordinates and meshes.get(body.name, "") is None
    ]
    return [Glyphs(np.empty((len(rows), 0, 2, 3)), (Mark(POINT_STYLE, own),)) for own in places]


def _obstacle_offsets(system: System, solution: Solution, chosen: np.ndarray) -> np.ndarray:
    """How far each obstacle has moved, (t, o, 3)."""
    if not system.rigid_contacts:
        return np.zeros((len(chosen), 0, 3))
    return solution.series[OBSTACLES][chosen].reshape(len(chosen), -1, 6)[:, :, :3]


def _draw_energies(path: Path, solution: Solution, units: UnitSystem) -> Path:
    """Every term of the balance that is not round-off."""
    energies = without_noise(solution.series[ENERGIES]).T
    shown = [
        Series(name, solution.times, values)
        for name, values in zip(Energies._fields, energies, strict=True)
        if values.any() or name == "kinetic"
    ]
    return plot_time_history(path, [Panel(labelled("energy", units.energy), shown)], units=units)


def _draw_tracked(
    path: Path, tracked: Mapping[str, TrackedMotion], times: np.ndarray, units: UnitSystem
) -> Path:
    """Motion of every place in global axes; beside it the deflection of those of elastic bodies."""
    positions = {name: without_noise(place.position) for name, place in tracked.items()}
    elastic = {
        name: without_noise(place.deflection, like=place.position)
        for name, place in tracked.items()
        if place.is_elastic
    }
    panels = []
    for i, axis in enumerate("xyz"):
        places = [Series(as_written(name), times, position[:, i]) for name, position in positions.items()]
        panels.append(Panel(labelled(f"{axis}, global", units.length), places))
        if elastic:
            bent = [Series(as_written(name), times, deflection[:, i]) for name, deflection in elastic.items()]
            panels.append(Panel(labelled(f"deflection {axis}", units.length), bent))
    return plot_time_history(path, panels, n_columns=2 if elastic else 1, units=units)


def _joint_panels(system: System, solution: Solution, units: UnitSystem) -> list[Panel]:
    """Signed components on the second ends: rows x, y, z of the joint axes, columns force and moment."""
    loads = joint_loads(system, solution)
    columns = [
        (what, unit)
        for what, unit in (("force", units.force), ("moment", units.moment))
        if any(what in parts for parts in loads.values())
    ]
    all_of = {
        what: np.concatenate([parts[what] for parts in loads.values() if what in parts])
        for what, _ in columns
    }
    return [
        Panel(
            labelled(f"{what} {axis}", unit),
            [
                Series(
                    as_written(f"{name} on {joint.second}"),
                    solution.times,
                    without_noise(loads[name][what], like=all_of[what])[:, i],
                )
                for name, joint in ((joint.name, joint) for joint in system.joints)
                if what in loads[name]
            ],
        )
        for i, axis in enumerate("xyz")
        for what, unit in columns
    ]
