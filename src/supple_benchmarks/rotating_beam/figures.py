"""The figures of [Wu2019] section 6.1 redrawn, and an animation of the beam."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from supple.mesh.skin import skin_of
from supple.quantities.tracked_motion import node_positions
from supple.results.camera import Camera
from supple.units import SI
from supple.viz.animation import Traces, animate
from supple.viz.error_curves import plot_error_over_parameter, plot_rms_error
from supple.viz.style import REFERENCE, SOLID
from supple.viz.time_history import Panel, Series, plot_time_history
from supple_benchmarks.progress import Progress
from supple_benchmarks.rotating_beam.report import PUBLISHED_RMS
from supple_benchmarks.rotating_beam.run import BeamRun, ReducedRun
from supple_benchmarks.rotating_beam.tip_motion import TipMotion

__all__ = ["animation", "draw_figures"]


def draw_figures(run: BeamRun, folder: Path) -> list[Path]:
    """Draw figures 6 and 7 of [Wu2019] with the results here; returns the paths of the pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    omega = run.problem.speeds[0]
    kinematics = run.problem.kinematics[0]
    full = [one for one in run.full if one.omega == omega and one.kinematics == kinematics]
    roms = [one for one in run.reduced if one.full.omega == omega and one.full.kinematics == kinematics]
    exact = run.exact[omega]
    motions: list[tuple[str, TipMotion]] = [("exact beam", exact)]
    motions += [(f"full, {one.frame}", one.tip) for one in full]
    motions += [(_label(one), one.tip) for one in roms if one.basis.derivatives_name != "picked"]
    strokes = [REFERENCE] + [SOLID] * (len(motions) - 1)

    def curves(values: Callable[[TipMotion], np.ndarray]) -> list[Series]:
        return [
            Series(label, tip.times, values(tip), stroke)
            for (label, tip), stroke in zip(motions, strokes, strict=True)
        ]

    panels = [Panel("v (m)", curves(lambda tip: tip.v)), Panel("u (m)", curves(lambda tip: tip.u))]
    enriched = {_label(one): one.error for one in roms if one.basis.n_added}
    pictures = [
        plot_time_history(folder / "figure_6_tip_motion.png", panels, units=SI),
        plot_rms_error(
            folder / "figure_7a_rms_error.png",
            enriched,
            published={f"{frame}, [Wu2019]": bound for frame, bound in PUBLISHED_RMS.items()},
            units=SI,
        ),
    ]
    speeds = [speed for speed in run.problem.speeds if any(one.full.omega == speed for one in run.reduced)]
    if len(speeds) > 1:
        pictures.append(_draw_error_over_speed(run, kinematics, speeds, folder))
    return pictures


def animation(run: BeamRun, path: Path, progress: Progress) -> Path:
    """Animate the spin-up at the first speed as a GIF.

    The motion is that of the last reduced model with derivatives and condensed tensors.
    """
    first = [one for one in run.reduced if one.full.omega == run.problem.speeds[0]]
    rom = [one for one in first if one.basis.n_added and one.basis.tensors == "condensed"][-1]
    motion = rom.solution.bodies[rom.body.name]
    every = max(1, round(_ANIMATION_STEP / run.problem.output_step))
    end = int(np.searchsorted(rom.solution.times, _ANIMATION_END))
    rows = slice(0, end, every)
    shown, whole = motion.at(rows), slice(0, end)
    mesh = run.problem.mesh()
    tip = node_positions(rom.body, motion.at(whole), mesh.nodes_of("tip_centre"))
    return animate(
        path,
        rom.solution.times[rows],
        node_positions(rom.body, shown),
        skin_of(mesh),
        traces=Traces(rom.solution.times[whole], tip),
        camera=Camera.looking(along=(0.25, 1.0, -0.15), up=(0.0, 0.0, 1.0)),
        units=SI,
        progress=progress,
    )


_ANIMATION_STEP, _ANIMATION_END = 0.36, 12.0


def _label(rom: ReducedRun) -> str:
    return f"{rom.full.frame}, {rom.columns}"


def _draw_error_over_speed(run: BeamRun, kinematics: str, speeds: list[float], folder: Path) -> Path:
    errors: dict[str, np.ndarray] = {}
    for rom in run.reduced:
        if rom.basis.n_added and rom.full.kinematics == kinematics:
            values = errors.setdefault(_label(rom), np.full(len(speeds), np.nan))
            values[speeds.index(rom.full.omega)] = rom.error.relative_percent
    return plot_error_over_parameter(
        folder / "figure_7b_relative_error.png",
        np.array(speeds),
        errors,
        parameter_label="final speed (rad/s)",
    )
