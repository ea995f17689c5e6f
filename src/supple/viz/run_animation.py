"""Animation of a machine in motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

from supple.arguments import checked_arguments
from supple.fem import FiniteElementModel
from supple.integrate import Solution
from supple.machine import At, System
from supple.quantities import JointMotionSensor, node_positions
from supple.results.body_surface import Look
from supple.results.camera import AS_IT_IS, View, enlarged_words
from supple.results.colouring import DEFLECTION, Colouring, stress_colouring
from supple.results.film import WHOLE_RUN, Film, film_rows, off_angle
from supple.units import UNNAMED, UnitSystem
from supple.viz.animation import Traces, animate
from supple.viz.film_file import check_film, played_rate
from supple.viz.machine_camera import machine_camera
from supple.viz.machine_scene import machine_scene

__all__ = ["animate_run"]


@checked_arguments
def animate_run(
    path: Path,
    system: System,
    solution: Solution,
    meshes: Mapping[str, Look | None],
    *,
    elements: Mapping[str, FiniteElementModel] | None = None,
    colouring: Colouring | None = None,
    bases: Mapping[str, At] = MappingProxyType({}),
    film: Film = WHOLE_RUN,
    view: View = AS_IT_IS,
    rest: Solution | None = None,
    caption: str = "",
    units: UnitSystem = UNNAMED,
    progress: Callable[[float], None] | None = None,
) -> Path | None:
    """Animate a machine: meshes in colour, obstacles, rigid bodies and joints as glyphs.

    Returns None if there is nothing to draw. Other parameters as for `draw_run`.

    path : ends in .gif or .mp4
    colouring : by default the stress with `elements`, and otherwise the deflection
    film : output times and speed
    view : camera and enlargement; an enlargement is written in the animation
    rest : solution whose first time is drawn as an outline
    caption : text written in the animation
    progress : called with the finished share

    Raises ModelError for a window without output times, a rotor that does not pass its angle, an
    enlargement of explicit elements, meshes or elements of an unknown body.
    """
    for name in elements or ():
        system.placed(name, "elements")  # a misspelt name is an error
    check_film(path, film.frames_per_second)
    rate = played_rate(path, film.frames_per_second)
    at = None if film.at is None else JointMotionSensor("film", film.at.joint)
    angles = None if at is None else at.values(system, solution)[:, 0]
    frames = film_rows(film, solution.times, rate, angles)
    rows, shown = np.unique(frames, return_inverse=True)
    camera = view.camera or machine_camera(system, solution, meshes)
    enlargement = view.enlargement or 1.0
    scene = machine_scene(
        system,
        solution,
        meshes,
        rows,
        camera,
        enlargement=enlargement,
        colouring=colouring or (DEFLECTION if elements is None else stress_colouring(elements)),
        rest=rest,
        bases=bases,
        units=units,
    )
    if scene.is_empty:
        return None
    # Paths are drawn only for a motion true to scale and without gaps in time.
    is_followed = enlargement == 1.0 and film.at is None
    captions = [caption] if caption else []
    captions += [enlarged_words(enlargement)] if enlargement != 1.0 else []
    if film.at is not None and angles is not None:
        off = np.degrees(off_angle(angles[rows], film.at))
        captions.append(f"{film.at.joint} at {np.degrees(film.at.angle) % 360:.4g}° (within {off:.1g}°)")
    return animate(
        path,
        solution.times[rows],
        scene.positions,
        scene.skin,
        glyphs=None if scene.glyphs.is_empty else scene.glyphs,
        camera=camera,
        values=scene.values,
        values_label=scene.label,
        traces=_traces(system, solution, scene.farthest, rows) if is_followed else None,
        undeformed=None if rest is None else scene.undeformed,
        caption="\n".join(captions),
        shown=shown,
        frames_per_second=film.frames_per_second,
        units=units,
        progress=progress,
    )


def _traces(
    system: System, solution: Solution, farthest: Mapping[str, int], rows: np.ndarray
) -> Traces | None:
    """Path of the node with the largest deflection of each body, during the animation."""
    if not farthest:
        return None
    between = np.arange(rows[0], rows[-1] + 1)
    places = [
        node_positions(system.placed(name).body, solution.bodies[name].at(between), [node])
        for name, node in farthest.items()
    ]
    return Traces(solution.times[between], np.concatenate(places, axis=1))
