"""The pictures of a run: meshes, modes, deformed bodies, tracked motion, joint forces, and an animation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

from supple.body import FullBody
from supple.fem import FiniteElementModel
from supple.integrate import FloatingMotion, Solution
from supple.machine import System
from supple.mesh import Mesh
from supple.reduction import ReducedBody, clamped_modes
from supple.results import (
    TrackedMotion,
    deflections,
    joint_loads,
    node_positions,
    von_mises_history,
)
from supple.storage import file_name
from supple.viz.animation import animate
from supple.viz.camera import Camera
from supple.viz.contour import plot_contour, stress_field
from supple.viz.mesh_plot import displacement_magnitude, plot_mesh
from supple.viz.mesh_skin import Skin, skin_of
from supple.viz.mode_shapes import mode_titles, plot_mode_shapes
from supple.viz.style import as_written
from supple.viz.time_history import Panel, Series, plot_time_history

ElasticBody = ReducedBody | FullBody
Elements = Mapping[str, FiniteElementModel]

N_MODES = 6
N_FRAMES = 100
FRAMES_PER_SECOND = 20.0
# A picture of the deformed body searches so many instants for the largest deflection.
N_INSTANTS = 200
# Deflections smaller than this share of the body's diagonal are drawn enlarged to it.
VISIBLE = 0.08


def draw_run(
    folder: Path,
    system: System,
    solution: Solution,
    meshes: Mapping[str, Mesh],
    *,
    tracked: Mapping[str, TrackedMotion] = MappingProxyType({}),
    elements: Elements | None = None,
) -> list[Path]:
    """Draw everything but the animation: mesh, modes and deformation of the bodies, what is tracked, joints.

    Parameters
    ----------
    folder : where the pictures go
    meshes : of the elastic bodies to draw, by name; each has faces
    tracked : motions of places, by their names
    elements : of these bodies, by name, to draw their von Mises stress too; see `von_mises_history`

    Returns
    -------
    the paths of the pictures
    """
    pictures: list[Path] = []
    reduced = system.bodies_of(ReducedBody)
    for body, mesh in _drawn(system, meshes):
        surface = skin_of(mesh)

        def path(what: str, name: str = body.name) -> Path:
            return folder / f"{file_name(name)}-{what}.png"

        pictures.append(plot_mesh(path("mesh"), mesh.nodes, surface, title=as_written(body.name)))
        if body.name in reduced:
            pictures.append(_draw_modes(path("modes"), reduced[body.name], surface))
        pictures.append(_draw_deformed(path("deformed"), body, solution, surface))
        if elements is not None:
            pictures.append(_draw_stress(path("stress"), body, elements[body.name], solution, surface))
    if tracked:
        pictures.append(_draw_tracked(folder / "tracked-motion.png", tracked, solution.times))
    panels = _joint_panels(system, solution)
    if panels:
        pictures.append(plot_time_history(folder / "joint-forces.png", panels))
    return pictures


def animate_run(
    path: Path,
    system: System,
    solution: Solution,
    meshes: Mapping[str, Mesh],
    *,
    elements: Elements | None = None,
    progress: Callable[[float], None] | None = None,
) -> Path | None:
    """Animate all bodies that have a mesh, coloured by deflection or stress; None when there is none.

    Parameters as for `draw_run`; `progress` hears of the share that is drawn.
    """
    chosen = _instants(solution.times, N_FRAMES)
    positions, values, surfaces, traced, n_nodes = [], [], [], [], 0
    for body, mesh in _drawn(system, meshes):
        motion = solution.bodies[body.name].at(chosen)
        deflection = np.linalg.norm(deflections(body, motion), axis=2)
        positions.append(node_positions(body, motion))
        if elements is None:
            values.append(deflection)
        else:
            values.append(1e-6 * von_mises_history(body, elements[body.name], motion.coordinates))
        surface = skin_of(mesh)
        surfaces.append(Skin(surface.triangles + n_nodes, surface.mesh_lines.copy()))
        # The path of the node that moves most against its body tells how the body swings.
        traced.append(n_nodes + int(np.argmax(deflection.max(axis=0))))
        n_nodes += len(mesh.nodes)
    if not positions:
        return None
    together = Skin(
        np.concatenate([surface.triangles for surface in surfaces]),
        np.concatenate([surface.mesh_lines for surface in surfaces]),
    )
    moving = np.concatenate(positions, axis=1)
    return animate(
        path,
        solution.times[chosen],
        moving,
        together,
        camera=_upright_camera(moving, system.gravity),
        values=np.concatenate(values, axis=1),
        values_label="deflection (m)" if elements is None else "von Mises stress (MPa)",
        traced_nodes=traced,
        frames_per_second=FRAMES_PER_SECOND,
        progress=progress,
    )


def _upright_camera(positions: np.ndarray, gravity: np.ndarray) -> Camera | None:
    """Camera with gravity pointing down that sees the widest motion, a little from the side and above."""
    if not gravity.any():
        return None
    up = -gravity / np.linalg.norm(gravity)
    extent = np.ptp(positions.reshape(-1, 3), axis=0)
    level = [axis for axis in np.argsort(extent, kind="stable") if abs(up[axis]) < 0.8]
    thin, wide = np.eye(3)[level[:2]]
    return Camera.looking(along=-thin - 0.35 * wide - 0.25 * up, up=up)


def _drawn(system: System, meshes: Mapping[str, Mesh]) -> list[tuple[ElasticBody, Mesh]]:
    """Elastic bodies that have something to show."""
    elastic: dict[str, ElasticBody] = {**system.bodies_of(ReducedBody), **system.bodies_of(FullBody)}
    return [(elastic[name], mesh) for name, mesh in meshes.items() if name in elastic]


def _draw_modes(path: Path, body: ReducedBody, surface: Skin) -> Path:
    """Modes of the body clamped at its first interface, or in its frame when it has none."""
    if body.interfaces:
        modes = clamped_modes(body, body.interfaces[0].name, n_modes=N_MODES)
        return plot_mode_shapes(
            path, body.nodes, surface, modes.shapes, mode_titles(modes.frequencies / (2 * np.pi))
        )
    values, vectors = np.linalg.eigh(body.stiffness)
    shapes = body.expand(vectors[:, :N_MODES].T)
    return plot_mode_shapes(
        path, body.nodes, surface, shapes, mode_titles(np.sqrt(values[:N_MODES]) / (2 * np.pi))
    )


def _draw_deformed(path: Path, body: ElasticBody, solution: Solution, surface: Skin) -> Path:
    """The body when it is bent most, enlarged if that were too little to see."""
    instants, motion = _sampled(body, solution)
    displaced = deflections(body, motion)
    size = np.linalg.norm(displaced, axis=2).max(axis=1)
    worst = int(np.argmax(size))
    scale, enlarged = _enlargement(body, displaced[worst])
    return plot_mesh(
        path,
        body.nodes + scale * displaced[worst],
        surface,
        colour_by=displacement_magnitude(displaced[worst]),
        undeformed=body.nodes,
        title=f"{as_written(body.name)} at t = {solution.times[instants[worst]]:.4g} s, "
        f"deflection {enlarged}",
    )


def _enlargement(body: ElasticBody, displaced: np.ndarray) -> tuple[float, str]:
    """Factor that makes displacements (N, 3) large enough to see, and what to say of it."""
    size = float(np.linalg.norm(displaced, axis=1).max())
    diagonal = float(np.linalg.norm(np.ptp(body.nodes, axis=0)))
    scale = max(1.0, VISIBLE * diagonal / size) if size > 0 else 1.0
    return scale, "true to scale" if scale == 1.0 else f"enlarged {scale:.3g} times"


def _draw_stress(
    path: Path, body: ElasticBody, model: FiniteElementModel, solution: Solution, surface: Skin
) -> Path:
    """Contours of the von Mises stress at the instant where it is largest, on the body as it is bent then."""
    instants, motion = _sampled(body, solution)
    stress = von_mises_history(body, model, motion.coordinates)
    worst = int(np.argmax(stress.max(axis=1)))
    displaced = deflections(body, motion.at(np.array([worst])))[0]
    scale, enlarged = _enlargement(body, displaced)
    return plot_contour(
        path,
        body.nodes + scale * displaced,
        surface,
        stress_field(stress[worst]),
        undeformed=body.nodes,
        title=f"{as_written(body.name)} at t = {solution.times[instants[worst]]:.4g} s, "
        f"deflection {enlarged}",
    )


def _draw_tracked(path: Path, tracked: Mapping[str, TrackedMotion], times: np.ndarray) -> Path:
    panels = [
        Panel(
            f"deflection {axis} (m)",
            [Series(as_written(name), times, place.deflection[:, i]) for name, place in tracked.items()],
        )
        for i, axis in enumerate("xyz")
    ]
    return plot_time_history(path, panels)


def _joint_panels(system: System, solution: Solution) -> list[Panel]:
    loads = joint_loads(system, solution)
    panels = []
    for what, unit in (("force", "N"), ("moment", "N m")):
        series = [
            Series(as_written(name), solution.times, np.linalg.norm(parts[what], axis=1))
            for name, parts in loads.items()
            if what in parts
        ]
        panels += [Panel(f"{what} ({unit})", series)] if series else []
    return panels


def _sampled(body: ElasticBody, solution: Solution) -> tuple[np.ndarray, FloatingMotion]:
    """Instants to search for the largest value, and the motion of a body then."""
    instants = _instants(solution.times, N_INSTANTS)
    return instants, solution.bodies[body.name].at(instants)


def _instants(times: np.ndarray, number: int) -> np.ndarray:
    """Places of at most so many times, spread evenly over all."""
    return np.unique(np.linspace(0, len(times) - 1, number).astype(int))
