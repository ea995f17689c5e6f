"""Pictures of one elastic body of a run: its modes, its largest deflection, its largest stress."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from supple.body import BodyForm
from supple.fem import FiniteElementModel
from supple.integrate import FloatingMotion, Solution
from supple.machine import At, System
from supple.methods.intrinsic import IntrinsicBody
from supple.quantities import deflections, largest_stress, observer, observer_of, von_mises_by_end
from supple.reduction import BodyModes, ReducedBody, clamped_modes
from supple.results.body_surface import BodySurface
from supple.results.run_summary import N_DRAWN_MODES
from supple.units import UnitSystem, measured
from supple.viz.contour import plot_contour, stress_field
from supple.viz.glyphs import surface_glyphs
from supple.viz.mesh_plot import displacement_magnitude, plot_mesh
from supple.viz.mode_shapes import mode_titles, plot_mode_shapes
from supple.viz.style import as_written

# A picture of the deformed body searches so many instants for the largest deflection.
N_INSTANTS = 200
# Deflections smaller than this share of the body's diagonal are drawn enlarged to it.
VISIBLE = 0.08


def draw_modes(
    path: Path, body: ReducedBody, modes: BodyModes | None, surface: BodySurface, units: UnitSystem
) -> Path:
    """Modes clamped at the first interface, or in the frame; of the basis where those are not known."""
    if modes is not None:
        titles = mode_titles(modes.frequencies / (2 * np.pi), units)
        return _plot_modes(path, surface, modes.shapes, modes.rotations, titles)
    if body.interfaces:
        modes = clamped_modes(body, body.interfaces[0].name, n_modes=N_DRAWN_MODES)
        titles = _of_basis(mode_titles(modes.frequencies / (2 * np.pi), units))
        return _plot_modes(path, surface, modes.shapes, modes.rotations, titles)
    values, vectors = np.linalg.eigh(body.stiffness)
    titles = _of_basis(mode_titles(np.sqrt(values[:N_DRAWN_MODES]) / (2 * np.pi), units))
    return _plot_modes(path, surface, *_linear_shapes(body, vectors[:, :N_DRAWN_MODES].T), titles)


def _linear_shapes(body: BodyForm, amplitudes: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """Displacements (m, N, 3) and rotations, where nodes have them, by coordinates (m, r)."""
    shapes = body.expand_rates(np.zeros_like(amplitudes), amplitudes)
    if body.dofs_per_node < 6:
        return shapes, None
    return shapes, body.nodal_fields(amplitudes)[0].T.reshape(len(amplitudes), -1, 6)[..., 3:]


def _plot_modes(
    path: Path, surface: BodySurface, shapes: np.ndarray, rotations: np.ndarray | None, titles: list[str]
) -> Path:
    return plot_mode_shapes(
        path,
        surface.rest,
        surface.skin,
        _of_one_sign(surface.shaped(shapes, rotations)),
        titles,
        glyphs=lambda places: surface_glyphs(surface, places[:, : surface.mesh.n_nodes]),
    )


def _of_basis(titles: list[str]) -> list[str]:
    return [f"basis, {title}" for title in titles]


def _of_one_sign(shapes: np.ndarray) -> np.ndarray:
    """Modes (m, N, 3), which have no sign, with their largest component positive.

    Of several that are as large the first one counts, so that rounding does not turn a picture over.
    """
    components = shapes.reshape(len(shapes), -1)
    size = np.abs(components)
    first = np.argmax(size >= 0.999 * size.max(axis=1, keepdims=True), axis=1)
    signs = np.where(components[np.arange(len(shapes)), first] < 0.0, -1.0, 1.0)
    return shapes * signs[:, None, None]


def draw_intrinsic_modes(path: Path, body: IntrinsicBody, surface: BodySurface, units: UnitSystem) -> Path:
    """Its lowest elastic modes on the support of its root."""
    number = min(N_DRAWN_MODES, body.n_coordinates)
    titles = mode_titles(body.modes.omega[body.modes.n_rigid :][:number] / (2 * np.pi), units)
    return _plot_modes(path, surface, *_linear_shapes(body, np.eye(body.n_coordinates)[:number]), titles)


def draw_deformed(
    path: Path,
    body: BodyForm,
    run: tuple[System, Solution],
    bases: Mapping[str, At],
    surface: BodySurface,
    units: UnitSystem,
) -> Path:
    """The body when it is bent most, enlarged if that were too little to see."""
    system, solution = run
    instants, motion = _sampled(body, solution)
    displaced = deflections(body, motion, observer_of(system, solution, body.name, bases, instants))
    worst = int(np.argmax(np.linalg.norm(displaced, axis=2).max(axis=1)))
    then = instants[[worst]]
    moved = solution.bodies[body.name].at(then)
    seen_from = observer_of(system, solution, body.name, bases, then) or observer(body, moved)
    scale, enlarged = _enlargement(body, displaced[worst])
    points = surface.deflections(body, moved, seen_from)[0]
    return plot_mesh(
        path,
        surface.rest + scale * points,
        surface.skin,
        colour_by=displacement_magnitude(points, units),
        undeformed=surface.rest,
        glyphs=surface_glyphs(surface, (body.nodes + scale * displaced[worst])[None]),
        title=_title(body, float(solution.times[then[0]]), enlarged, units),
        units=units,
    )


def _enlargement(body: BodyForm, displaced: np.ndarray) -> tuple[float, str]:
    """Factor that makes displacements (N, 3) large enough to see, and what to say of it."""
    size = float(np.linalg.norm(displaced, axis=1).max())
    diagonal = float(np.linalg.norm(np.ptp(body.nodes, axis=0)))
    scale = max(1.0, VISIBLE * diagonal / size) if size > 0 else 1.0
    return scale, "true to scale" if scale == 1.0 else f"enlarged {scale:.3g} times"


def _title(body: BodyForm, time: float, enlarged: str, units: UnitSystem) -> str:
    return f"{as_written(body.name)} at {measured(f't = {time:.4g}', units.time)}, deflection {enlarged}"


def draw_stress(
    path: Path,
    body: BodyForm,
    model: FiniteElementModel,
    surface: BodySurface,
    solution: Solution,
    units: UnitSystem,
) -> Path:
    """Contours of the von Mises stress at the instant where it is largest, on the body as it is bent then."""
    motion = solution.bodies[body.name]
    worst = largest_stress(body, model, motion.coordinates).instant
    then = motion.at(np.array([worst]))
    stress = von_mises_by_end(body, model, then.coordinates)[0]
    displaced = deflections(body, then)[0]
    scale, enlarged = _enlargement(body, displaced)
    points = surface.deflections(body, then, observer(body, then))[0]
    return plot_contour(
        path,
        surface.rest + scale * points,
        surface.skin,
        stress_field(surface.at_points(stress[None])[0], units),
        node_ids=surface.mesh.node_ids[surface.nodes],
        undeformed=surface.rest,
        glyphs=surface_glyphs(surface, (body.nodes + scale * displaced)[None]),
        title=_title(body, float(solution.times[worst]), enlarged, units),
        units=units,
    )


def _sampled(body: BodyForm, solution: Solution) -> tuple[np.ndarray, FloatingMotion]:
    """Instants to search for the largest value, and the motion of a body then."""
    instants = instants_of(solution.times, N_INSTANTS)
    return instants, solution.bodies[body.name].at(instants)


def instants_of(times: np.ndarray, number: int) -> np.ndarray:
    """Places of at most so many times, spread evenly over all."""
    return np.unique(np.linspace(0, len(times) - 1, number).astype(int))
