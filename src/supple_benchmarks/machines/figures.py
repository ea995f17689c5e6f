"""The figures of [Han2020] section 5 redrawn, and an animation of the machine."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from supple.body import in_space
from supple.integrate import FloatingMotion, Solution
from supple.mesh.skin import skin_of
from supple.quantities import node_positions, von_mises_history
from supple.units import SI
from supple.viz.animation import Traces, animate
from supple.viz.contour import plot_contour
from supple.viz.mesh_plot import NodalField, plot_mesh
from supple.viz.response_errors import Response, plot_response_errors
from supple.viz.scene import Actor, scene_of
from supple.viz.style import COLOURS, REFERENCE, Stroke
from supple.viz.time_history import Panel, Series, plot_time_history
from supple_benchmarks.machines.flexible_machine import FlexibleMachine
from supple_benchmarks.machines.run import MachineRun, Variant, equivalent_strain
from supple_benchmarks.machines.study import Study
from supple_benchmarks.progress import Progress

__all__ = ["animation", "draw_figures"]

_VECTORS = {"position": "m", "velocity": "m/s", "acceleration": "m/s²"}
_SCALARS = {"stress": "von Mises stress (Pa)", "strain": "von Mises strain"}
_MOST_FRAMES = 60


def draw_figures(study: Study, folder: Path) -> list[Path]:
    """Responses of node A with their errors, errors of the deformation, contours, divergence of two runs."""
    folder.mkdir(parents=True, exist_ok=True)
    pictures = [_draw_machine(study, folder / "machine.png")]
    for quantity in _VECTORS:
        moving = np.ptp(getattr(study.reference.point, quantity), axis=0) > 0.0
        rows = [_component(study, quantity, axis) for axis in np.flatnonzero(moving).tolist()]
        pictures.append(_draw_responses(study, rows, folder / f"{quantity}.png"))
    rows = [_scalar(study, quantity) for quantity in _SCALARS]
    pictures.append(_draw_responses(study, rows, folder / "stress_strain.png"))
    pictures.append(_draw_deformation_errors(study, folder / "deformation.png"))
    for variant in DASHES:
        pictures += _draw_contours(study, study.of(variant), folder)
    if study.separations:
        pictures.append(_draw_separations(study, folder / "separation.png"))
    return pictures


DASHES = {
    Variant.MODAL_COORDINATES: (3.0, 1.5),
    Variant.WITH_ATTACHMENT_MODES: (1.0, 1.0),
    Variant.WHOLE_BASIS: (),
}
"""Dashes of the variants of the reduced body; the colours show the tolerances."""


def _label(run: MachineRun) -> str:
    return f"{100 * (run.tolerance or 0):g} %, {run.variant.value}"


def _response(study: Study, quantity: str, values: Callable[[MachineRun], np.ndarray]) -> Response:
    def series(run: MachineRun, label: str, stroke: Stroke) -> Series:
        return Series(label, run.point.times, values(run), stroke)

    models = [
        series(run, _label(run), Stroke(COLOURS[rank], dashes, width=0.9))
        for variant, dashes in DASHES.items()
        for rank, run in enumerate(study.of(variant))
    ]
    return Response(quantity, series(study.reference, "unreduced", REFERENCE), models)


def _component(study: Study, quantity: str, axis: int) -> Response:
    name = f"{'xyz'[axis]} {quantity} ({_VECTORS[quantity]})"
    return _response(study, name, lambda run: getattr(run.point, quantity)[:, axis])


def _scalar(study: Study, quantity: str) -> Response:
    return _response(study, _SCALARS[quantity], lambda run: getattr(run.point, quantity))


def _draw_responses(study: Study, rows: list[Response], path: Path) -> Path:
    return plot_response_errors(path, rows, until=study.compared_until, units=SI)


def _draw_deformation_errors(study: Study, path: Path) -> Path:
    """Errors of the deformation in the energy norm, which decrease with a larger space."""
    truth = study.reference
    rows = slice(1, None)  # undeformed at the start
    models = [
        Series(
            _label(run),
            truth.point.times[rows],
            np.log10(np.maximum(run.deformation_error[rows], 1e-16)),
            Stroke(COLOURS[rank], dashes, width=0.9),
        )
        for variant, dashes in DASHES.items()
        for rank, run in enumerate(study.of(variant))
    ]
    size = Series(
        "unreduced, its own norm", truth.point.times[rows], np.log10(truth.deformation_error[rows]), REFERENCE
    )
    return plot_time_history(path, [Panel("log10 of the energy norm (J$^{1/2}$)", [*models, size])], units=SI)


def _draw_contours(study: Study, runs: list[MachineRun], folder: Path) -> list[Path]:
    """Errors of stress and strain over the whole body, at the largest stress of node A before chaos."""
    machine, reference = study.machine, study.reference
    compared = reference.point.times <= study.compared_until
    i = int(np.argmax(np.where(compared, reference.point.stress, 0.0)))
    mesh = machine.model.mesh
    true = _stress_at(machine, reference, i)
    pictures = []
    for run in runs:
        error = np.abs(_stress_at(machine, run, i) - true)
        title = f"{_label(run)}, t = {reference.point.times[i]:.4g} s"
        variant = run.variant.value.replace(" ", "_")
        fields = {"stress": error, "strain": equivalent_strain(machine.material, error)}
        for quantity, field in fields.items():
            path = folder / f"{quantity}_error_{variant}_{100 * (run.tolerance or 0):g}.png"
            shown = NodalField(f"error of {_SCALARS[quantity]}", field)
            pictures.append(plot_contour(path, mesh.nodes, skin_of(mesh), shown, title=title, units=SI))
    return pictures


def _stress_at(machine: FlexibleMachine, run: MachineRun, i: int) -> np.ndarray:
    coordinates = run.solution.motion(run.body.name, FloatingMotion).coordinates[i : i + 1]
    return von_mises_history(run.body, machine.model, coordinates)[0]


def _draw_separations(study: Study, path: Path) -> Path:
    panels = []
    for each in study.separations:
        distance = np.log10(np.maximum(each.distance[1:], 1e-16))
        panels.append(
            Panel("log10 distance (m)", [Series(f"{each.coarse} / {each.fine}", each.times[1:], distance)])
        )
    return plot_time_history(path, panels, units=SI)


def _actors(study: Study, run: MachineRun, rows: slice, *, coloured: bool) -> list[Actor]:
    machine = study.machine
    mesh = machine.model.mesh
    motion = run.solution.motion(run.body.name, FloatingMotion).at(rows)
    stress = von_mises_history(run.body, machine.model, motion.coordinates) if coloured else None
    actors = [
        Actor(skin_of(mesh), node_positions(run.body, motion), None if stress is None else 1e-6 * stress)
    ]
    for name, look in machine.looks.items():
        rigid = run.solution.motion(name, FloatingMotion).at(rows)
        actors.append(Actor(skin_of(look), in_space(rigid.position, rigid.rotation, look.nodes[None])))
    return actors


def _draw_machine(study: Study, path: Path) -> Path:
    scene = scene_of(_actors(study, study.reference, slice(0, 1), coloured=False))
    return plot_mesh(path, scene.positions[0], scene.skin, camera=study.machine.camera, units=SI)


def animation(study: Study, path: Path, progress: Progress) -> Path:
    """The machine in motion as a GIF, its flexible body coloured by the von Mises stress."""
    run = study.of(Variant.WITH_ATTACHMENT_MODES)[-1]
    solution: Solution = run.solution
    rows = slice(0, None, max(1, len(solution.times) // _MOST_FRAMES))
    scene = scene_of(_actors(study, run, rows, coloured=True))
    return animate(
        path,
        solution.times[rows],
        scene.positions,
        scene.skin,
        values=scene.values,
        values_label="von Mises stress (MPa)",
        traces=Traces(
            solution.times, node_positions(run.body, solution.bodies[run.body.name], [study.machine.point])
        ),
        camera=study.machine.camera,
        units=SI,
        progress=progress,
    )
