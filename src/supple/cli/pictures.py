"""The pictures of a run: meshes, modes, deformed bodies, tracked motion, joint forces, and a film."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from supple.body import FullBody
from supple.cli.build_bodies import build_model
from supple.cli.build_system import BuiltCase, with_faces
from supple.cli.tracked_motion import TrackedMotion, deflections
from supple.integrate import FloatingMotion, Solution
from supple.mesh import Mesh
from supple.reduction import ReducedBody, clamped_modes
from supple.results import node_positions, von_mises_history
from supple.viz import (
    Camera,
    Panel,
    Series,
    Skin,
    animate,
    displacement_magnitude,
    mode_titles,
    plot_contour,
    plot_mesh,
    plot_mode_shapes,
    plot_time_history,
    skin_of,
    stress_field,
)

ElasticBody = ReducedBody | FullBody

N_MODES = 6
N_FRAMES = 100
FRAMES_PER_SECOND = 20.0
# A picture of the deformed body searches so many instants for the largest deflection.
N_INSTANTS = 200
# Deflections smaller than this share of the body's diagonal are drawn enlarged to it.
VISIBLE = 0.08


def draw_pictures(
    built: BuiltCase,
    solution: Solution,
    tracked: Sequence[TrackedMotion],
    joint_sizes: dict[str, dict[str, np.ndarray]],
    folder: Path,
) -> list[Path]:
    """Draw everything but the film.

    joint_sizes : magnitude (t,) of "force" and "moment" of each joint, by joint name
    Returns the paths of the pictures.
    """
    pictures: list[Path] = []
    for body, mesh in _elastic_bodies(built):
        surface = skin_of(mesh)
        stem = folder / body.name
        pictures.append(
            plot_mesh(stem.with_name(f"{body.name}-mesh.png"), mesh.nodes, surface, title=body.name)
        )
        if isinstance(body, ReducedBody):
            pictures.append(_draw_modes(stem.with_name(f"{body.name}-modes.png"), body, surface))
        motion = solution.bodies[body.name]
        path = stem.with_name(f"{body.name}-deformed.png")
        pictures.append(_draw_deformed(path, body, motion, solution.times, surface))
        if _shows_stress(built):
            path = stem.with_name(f"{body.name}-stress.png")
            pictures.append(_draw_stress(path, built, body, solution, surface))
    if tracked:
        pictures.append(_draw_tracked(folder / "tracked-motion.png", tracked, solution.times))
    panels = [
        Panel(f"{what} ({unit})", series)
        for what, unit in (("force", "N"), ("moment", "N m"))
        if (series := _joint_series(joint_sizes, what, solution.times))
    ]
    if panels:
        pictures.append(plot_time_history(folder / "joint-forces.png", panels))
    return pictures


def draw_animation(
    built: BuiltCase, solution: Solution, path: Path, progress: Callable[[float], None]
) -> Path | None:
    """Film all bodies that have a mesh, coloured by deflection or stress; None when there is none."""
    chosen = _instants(solution.times, N_FRAMES)
    positions, values, surfaces, traced, n_nodes = [], [], [], [], 0
    for body, mesh in _elastic_bodies(built):
        motion = solution.bodies[body.name].at(chosen)
        deflection = np.linalg.norm(deflections(body, motion), axis=2)
        positions.append(node_positions(body, motion))
        if _shows_stress(built):
            values.append(1e-6 * _stress(built, body, motion))
        else:
            values.append(deflection)
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
        camera=_upright_camera(moving, built.system.gravity),
        values=np.concatenate(values, axis=1),
        values_label="von Mises stress (MPa)" if _shows_stress(built) else "deflection (m)",
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


def _elastic_bodies(built: BuiltCase) -> list[tuple[ElasticBody, Mesh]]:
    """Elastic bodies that have something to show."""
    bodies = [placed.body for placed in built.system.bodies]
    shown = with_faces(built.meshes)
    return [
        (body, shown[body.name])
        for body in bodies
        if isinstance(body, ReducedBody | FullBody) and body.name in shown
    ]


def _stress(built: BuiltCase, body: ElasticBody, motion: FloatingMotion) -> np.ndarray:
    """Von Mises stress (t, N) of all nodes, Pa."""
    (table,) = (table for table in built.case_file.case.body if table.name == body.name)
    model = build_model(built.case_file, table, built.meshes[body.name])
    return von_mises_history(body, model, motion.coordinates)


def _shows_stress(built: BuiltCase) -> bool:
    return built.case_file.case.output.colour == "von-mises"


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


def _draw_deformed(
    path: Path, body: ElasticBody, motion: FloatingMotion, times: np.ndarray, surface: Skin
) -> Path:
    """The body when it is bent most, enlarged if that were too little to see."""
    instants = _instants(times, N_INSTANTS)
    displaced = deflections(body, motion.at(instants))
    size = np.linalg.norm(displaced, axis=2).max(axis=1)
    worst = int(np.argmax(size))
    scale, enlarged = _enlargement(body, displaced[worst])
    return plot_mesh(
        path,
        body.nodes + scale * displaced[worst],
        surface,
        colour_by=displacement_magnitude(displaced[worst]),
        undeformed=body.nodes,
        title=f"{body.name} at t = {times[instants[worst]]:.4g} s, deflection {enlarged}",
    )


def _enlargement(body: ElasticBody, displaced: np.ndarray) -> tuple[float, str]:
    """Factor that makes displacements (N, 3) large enough to see, and what to say of it."""
    size = float(np.linalg.norm(displaced, axis=1).max())
    diagonal = float(np.linalg.norm(np.ptp(body.nodes, axis=0)))
    scale = max(1.0, VISIBLE * diagonal / size) if size > 0 else 1.0
    return scale, "true to scale" if scale == 1.0 else f"enlarged {scale:.3g} times"


def _draw_stress(path: Path, built: BuiltCase, body: ElasticBody, solution: Solution, surface: Skin) -> Path:
    """Contours of the von Mises stress at the instant where it is largest, on the body as it is bent then."""
    instants = _instants(solution.times, N_INSTANTS)
    sampled = solution.bodies[body.name].at(instants)
    stress = _stress(built, body, sampled)
    worst = int(np.argmax(stress.max(axis=1)))
    displaced = deflections(body, sampled.at(np.array([worst])))[0]
    scale, enlarged = _enlargement(body, displaced)
    return plot_contour(
        path,
        body.nodes + scale * displaced,
        surface,
        stress_field(stress[worst]),
        undeformed=body.nodes,
        title=f"{body.name} at t = {solution.times[instants[worst]]:.4g} s, deflection {enlarged}",
    )


def _draw_tracked(path: Path, tracked: Sequence[TrackedMotion], times: np.ndarray) -> Path:
    panels = [
        Panel(
            f"deflection {axis} (m)",
            [Series(place.place, times, place.deflection[:, i]) for place in tracked],
        )
        for i, axis in enumerate("xyz")
    ]
    return plot_time_history(path, panels)


def _joint_series(
    joint_sizes: dict[str, dict[str, np.ndarray]], what: str, times: np.ndarray
) -> list[Series]:
    return [Series(name, times, sizes[what]) for name, sizes in joint_sizes.items() if what in sizes]


def _instants(times: np.ndarray, number: int) -> np.ndarray:
    """Places of at most so many times, spread evenly over all."""
    return np.unique(np.linspace(0, len(times) - 1, number).astype(int))
