"""Pictures of the blade: modes, derivatives, tip motion, errors, self-correction; an animation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from supple.integrate import FloatingMotion
from supple.mesh import skin_of
from supple.quantities import displacement_from_axes, node_positions, stress_modes
from supple.reduction import CraigBampton, modal_derivatives, rayleigh_ritz
from supple.units import SI
from supple.viz import (
    REFERENCE,
    SOLID,
    Camera,
    Panel,
    RoundErrors,
    Series,
    animate,
    mode_titles,
    plot_mesh,
    plot_mode_shapes,
    plot_rms_error,
    plot_self_correction,
    plot_time_history,
)
from supple_benchmarks.blade.full_run import FullRun
from supple_benchmarks.blade.run import BladeRun
from supple_benchmarks.compared_models import FRAMES, ROOT, turned_axes
from supple_benchmarks.nrel5mw_blade import AXIS, BODY, TipMotion
from supple_benchmarks.progress import Progress
from supple_benchmarks.table import Row

__all__ = ["animation", "draw_figures"]

SIDE = (0.9, 0.5, -0.25)
"""Direction of view: from upwind and slightly in front of the leading edge."""
N_MODES = 6
_ANIMATION_FRAMES = 60


def draw_figures(run: BladeRun, folder: Path) -> list[Path]:
    """Draw all still pictures; returns their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    pictures = [_draw_mesh(run, folder), *_draw_shapes(run, folder)]
    for case in run.benchmark.cases:
        tag = case.name.replace(" ", "_")
        full = [each for each in run.full if each.case.case == case]
        if full:
            tips = _full_tips(full)
            end = min(tip.times[-1] for _, tip in tips)
            pictures.append(_plot_tips(folder / f"figure_10_full_{tag}.png", tips, end))
        reduced = [each for each in run.reduced if each.case == case]
        for frame in FRAMES:
            own = [each for each in reduced if each.basis.frame == frame]
            reference = run.full_of(case, frame)
            curves = [(f"full, {frame}", reference.tip)] if reference else []
            curves += [(each.basis.label, each.tip) for each in own]
            end = min(tip.times[-1] for _, tip in curves)
            pictures.append(_plot_tips(folder / f"figure_11_reduced_{tag}_{frame}.png", curves, end))
            errors = {each.basis.label: each.error for each in own if each.error is not None}
            if errors:
                pictures.append(
                    plot_rms_error(folder / f"figure_11d_error_{tag}_{frame}.png", errors, units=SI)
                )
    if run.corrected:
        pictures.append(_draw_rounds(run, folder))
    return pictures


def _camera() -> Camera:
    # The span runs to the right.
    return Camera.looking(along=SIDE, up=(-1.0, 0.0, 0.0))


def _draw_mesh(run: BladeRun, folder: Path) -> Path:
    mesh = run.benchmark.blade.mesh
    return plot_mesh(folder / "mesh.png", mesh.nodes, skin_of(mesh), camera=_camera(), units=SI)


def _draw_shapes(run: BladeRun, folder: Path) -> list[Path]:
    """Modes of the blade clamped at its root, and the derivatives of the first three."""
    body, mesh, frame = run.body, run.benchmark.blade.mesh, FRAMES["nodal-fixed"]
    basis = rayleigh_ritz(body, frame, CraigBampton(n_modes=N_MODES).build(body, frame))
    derivatives = modal_derivatives(body, frame, basis)
    first = np.flatnonzero((derivatives.pairs < 3).all(axis=1))

    def shapes(vectors: np.ndarray) -> np.ndarray:
        nodal = (body.expansion @ vectors).T
        return nodal.reshape(len(nodal), len(body.nodes), -1)[:, :, :3]

    look: Row = {"skin": skin_of(mesh), "camera": _camera()}
    modes = mode_titles(basis.frequencies / (2 * np.pi), SI)
    return [
        plot_mode_shapes(folder / "modes.png", mesh.nodes, modes=shapes(basis.vectors), titles=modes, **look),
        plot_mode_shapes(
            folder / "derivatives.png",
            mesh.nodes,
            modes=shapes(derivatives.vectors[:, first]),
            titles=[derivatives.labels[i] for i in first],
            **look,
        ),
    ]


def _full_tips(full: Sequence[FullRun]) -> list[tuple[str, TipMotion]]:
    names = {"green-lagrange": "Green-Lagrange", "von-karman": "von Karman"}
    return [
        (f"{each.case.frame}, {'linear' if each.case.linear else names[each.case.kinematics]}", each.tip)
        for each in full
    ]


def _plot_tips(path: Path, curves: Sequence[tuple[str, TipMotion]], end: float = np.inf) -> Path:
    """Displacement of the tip relative to the root; the first curve is the reference."""

    def panel(quantity: str, values: Callable[[TipMotion], np.ndarray]) -> Panel:
        return Panel(
            quantity,
            [
                Series(
                    label,
                    tip.times[tip.times <= end],
                    values(tip)[tip.times <= end],
                    REFERENCE if i == 0 else SOLID,
                )
                for i, (label, tip) in enumerate(curves)
            ],
        )

    return plot_time_history(
        path,
        [
            panel("flap, x (m)", lambda tip: tip.flap),
            panel("edge, y (m)", lambda tip: tip.edge),
            panel("span, z (m)", lambda tip: tip.span),
        ],
        units=SI,
    )


def _draw_rounds(run: BladeRun, folder: Path) -> Path:
    rounds = {
        f"{each.case.name}, {each.frame}": RoundErrors(
            sizes=[one.size for one in each.rounds],
            estimated=[one.estimated_error for one in each.rounds],
            missing_motion=[one.indicator for one in each.rounds],
            allowed=[each.allowed] * len(each.rounds),
            true=each.true_errors,
        )
        for each in run.corrected
    }
    return plot_self_correction(folder / "self_correction.png", rounds, units=SI)


def animation(run: BladeRun, path: Path, progress: Progress) -> Path:
    """Animate the self-corrected first case in axes that rotate with the hub, coloured by stress."""
    corrected = run.corrected[0]
    body, solution = corrected.rounds[-1].body, corrected.rounds[-1].solution
    mesh, motion = run.benchmark.blade.mesh, solution.motion(BODY, FloatingMotion)
    last = int(np.searchsorted(solution.times, 4 * corrected.case.start))
    rows = np.unique(
        np.linspace(0, min(last, len(solution.times) - 1), _ANIMATION_FRAMES).round().astype(int)
    )
    still = motion.at(rows)
    positions = node_positions(body, still)
    axes = turned_axes(AXIS, corrected.case.spin(solution.times[rows]))
    seen = displacement_from_axes(positions, body.interface(ROOT).position, axes, np.zeros(3))
    assert run.body.model is not None  # a lofted blade has its elements
    stress = stress_modes(body, run.body.model).von_mises(still.coordinates)
    return animate(
        path,
        solution.times[rows],
        seen,
        skin_of(mesh),
        values=1e-6 * stress,
        values_label="von Mises stress (MPa)",
        camera=_camera(),
        units=SI,
        progress=progress,
    )
