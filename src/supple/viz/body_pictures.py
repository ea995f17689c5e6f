"""Pictures of one elastic body of a run: its mesh, its modes, its largest deflection, its largest stress."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from supple.body import BodyForm
from supple.fem import FiniteElementModel
from supple.integrate import FramedMotion, Solution
from supple.machine import At, System
from supple.methods.intrinsic import IntrinsicBody
from supple.quantities import deflections, largest_stress, observer, observer_of, von_mises_by_end
from supple.reduction import BodyModes, ReducedBody, clamped_modes
from supple.results.body_surface import BodySurface
from supple.results.camera import View, enlarged_words
from supple.results.run_summary import N_DRAWN_MODES
from supple.units import UnitSystem, with_unit
from supple.viz.contour import plot_contour, stress_field
from supple.viz.glyphs import GROUND_STYLE, Glyphs, Mark, surface_glyphs
from supple.viz.mesh_plot import displacement_magnitude, plot_mesh
from supple.viz.mode_shapes import mode_titles, plot_mode_shapes
from supple.viz.style import as_written

# Largest number of output times searched for the largest deflection.
N_INSTANTS = 200
# Deflections smaller than this share of the body's diagonal are enlarged to this share.
VISIBLE = 0.08


@dataclass(frozen=True, eq=False)
class DrawnBody:
    """A body, its surface, and its camera in its mesh axes."""

    body: BodyForm
    surface: BodySurface
    view: View
    units: UnitSystem

    @property
    def title(self) -> str:
        """Name of the body."""
        return as_written(self.body.name)


def draw_mesh(path: Path, drawn: DrawnBody) -> Path:
    """Picture of the undeformed body."""
    surface = drawn.surface
    return plot_mesh(
        path,
        surface.rest,
        surface.skin,
        glyphs=surface_glyphs(surface, surface.mesh.nodes[None]),
        camera=drawn.view.camera,
        title=drawn.title,
        units=drawn.units,
    )


def draw_modes(path: Path, drawn: DrawnBody, body: ReducedBody, modes: BodyModes | None) -> Path:
    """Picture of modes of a reduced body: of its finite-element model if `modes` is given, else of its basis.

    The body is clamped at its first interface, or fixed in its frame if it has no interface.
    """
    clamped_at = body.interfaces[0] if body.interfaces else None
    held = "fixed in its floating frame" if clamped_at is None else f"clamped at {clamped_at.name}"
    place = None if clamped_at is None else clamped_at.position
    if modes is None and clamped_at is not None:
        held += ", of its basis"
        modes = clamped_modes(body, clamped_at.name, n_modes=N_DRAWN_MODES)
    if modes is not None:
        return _plot_modes(path, drawn, modes, held, place)
    values, vectors = np.linalg.eigh(body.stiffness)
    shapes, rotations = _linear_shapes(body, vectors[:, :N_DRAWN_MODES].T)
    modes = BodyModes(np.sqrt(values[:N_DRAWN_MODES]), shapes, rotations=rotations)
    return _plot_modes(path, drawn, modes, f"{held}, of its basis", None)


def draw_intrinsic_modes(path: Path, drawn: DrawnBody, body: IntrinsicBody) -> Path:
    """Picture of the lowest elastic modes of an intrinsic body with the support of its root."""
    number, n_free = min(N_DRAWN_MODES, body.n_coordinates), body.support.free.shape[1]
    shapes, rotations = _linear_shapes(body, np.eye(body.n_coordinates)[:number])
    omega = body.modes.omega[body.modes.n_rigid :][:number]
    held = {0: "clamped at its root", 6: "free"}.get(n_free, f"its root free in {n_free} of 6 directions")
    place = None if n_free == 6 else body.interfaces[0].position
    return _plot_modes(path, drawn, BodyModes(omega, shapes, rotations=rotations), held, place)


def _linear_shapes(body: BodyForm, amplitudes: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """Displacements (m, N, 3), and rotations (m, N, 3) or None if nodes have none, for coordinates (m, r)."""
    shapes = body.expand_rates(np.zeros_like(amplitudes), amplitudes)
    if body.dofs_per_node < 6:
        return shapes, None
    return shapes, body.nodal_fields(amplitudes)[0].T.reshape(len(amplitudes), -1, 6)[..., 3:]


def _plot_modes(path: Path, drawn: DrawnBody, modes: BodyModes, held: str, place: np.ndarray | None) -> Path:
    """Picture of mode shapes, with the position of the support, if there is one."""
    surface = drawn.surface

    def glyphs(places: np.ndarray) -> Glyphs | None:
        own = surface_glyphs(surface, places[:, : surface.mesh.n_nodes])
        if place is None:
            return own
        ground = Mark(GROUND_STYLE, np.tile(place, (len(places), 1)))
        return Glyphs(np.empty((len(places), 0, 2, 3)), (ground,)).beside([] if own is None else [own])

    return plot_mode_shapes(
        path,
        surface.rest,
        surface.skin,
        _of_one_sign(surface.shaped(modes.shapes, modes.rotations)),
        mode_titles(modes.frequencies / (2 * np.pi), drawn.units),
        title=f"{drawn.title}, {as_written(held)}",
        glyphs=glyphs,
        camera=drawn.view.camera,
    )


def _of_one_sign(shapes: np.ndarray) -> np.ndarray:
    """Modes (m, N, 3), whose sign is arbitrary, with their largest component positive.

    Among equal components the first one counts, so that rounding does not change the sign.
    """
    components = shapes.reshape(len(shapes), -1)
    size = np.abs(components)
    first = np.argmax(size >= 0.999 * size.max(axis=1, keepdims=True), axis=1)
    signs = np.where(components[np.arange(len(shapes)), first] < 0.0, -1.0, 1.0)
    return shapes * signs[:, None, None]


def draw_deformed(
    path: Path, drawn: DrawnBody, system: System, solution: Solution, bases: Mapping[str, At]
) -> Path:
    """Picture of the body at its largest deflection, enlarged if it is too small to see."""
    body, surface = drawn.body, drawn.surface
    instants = drawn_instants(solution.times, N_INSTANTS)
    motion = solution.bodies[body.name].at(instants)
    displaced = deflections(body, motion, observer_of(system, solution, body.name, bases, instants))
    worst = int(np.argmax(np.linalg.norm(displaced, axis=2).max(axis=1)))
    then = instants[[worst]]
    moved = solution.bodies[body.name].at(then)
    seen_from = observer_of(system, solution, body.name, bases, then) or observer(body, moved)
    scale = drawn.view.enlargement or visible_enlargement(body, displaced[worst])
    points = surface.deflections(body, moved, seen_from)[0]
    return plot_mesh(
        path,
        surface.rest + scale * points,
        surface.skin,
        colour_by=displacement_magnitude(points, drawn.units),
        undeformed=surface.rest,
        glyphs=surface_glyphs(surface, (body.nodes + scale * displaced[worst])[None]),
        camera=drawn.view.camera,
        title=_title(drawn, float(solution.times[then[0]]), scale),
        units=drawn.units,
    )


def visible_enlargement(body: BodyForm, displaced: np.ndarray) -> float:
    """The factor, at least one, that makes displacements (N, 3) large enough to see."""
    size = float(np.linalg.norm(displaced, axis=1).max())
    diagonal = float(np.linalg.norm(np.ptp(body.nodes, axis=0)))
    return max(1.0, VISIBLE * diagonal / size) if size > 0 else 1.0


def _title(drawn: DrawnBody, time: float, scale: float) -> str:
    return f"{drawn.title} at {with_unit(f't = {time:.4g}', drawn.units.time)}, {enlarged_words(scale)}"


def draw_stress(path: Path, drawn: DrawnBody, model: FiniteElementModel, solution: Solution) -> Path:
    """Contours of the von Mises stress at the time of its maximum, on the body deformed at that time."""
    body, surface = drawn.body, drawn.surface
    motion = solution.motion(body.name, FramedMotion)
    worst = largest_stress(body, model, motion.coordinates).instant
    then = motion.at(np.array([worst]))
    stress = von_mises_by_end(body, model, then.coordinates)[0]
    displaced = deflections(body, then)[0]
    scale = drawn.view.enlargement or visible_enlargement(body, displaced)
    points = surface.deflections(body, then, observer(body, then))[0]
    return plot_contour(
        path,
        surface.rest + scale * points,
        surface.skin,
        stress_field(surface.at_points(stress[None])[0], drawn.units),
        node_ids=surface.mesh.node_ids[surface.nodes],
        undeformed=surface.rest,
        glyphs=surface_glyphs(surface, (body.nodes + scale * displaced)[None]),
        camera=drawn.view.camera,
        title=_title(drawn, float(solution.times[worst]), scale),
        units=drawn.units,
    )


def drawn_instants(times: np.ndarray, number: int) -> np.ndarray:
    """Indices of at most `number` times, evenly spaced."""
    return np.unique(np.linspace(0, len(times) - 1, number).astype(int))
