"""Results of the blade benchmark: JSON report, and tables that include the numbers of [Wu2019] Table 3."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np

from supple_benchmarks.blade.corrected_run import CorrectedRun
from supple_benchmarks.blade.full_run import FullRun
from supple_benchmarks.blade.reduced_run import ReducedRun
from supple_benchmarks.blade.run import BladeRun
from supple_benchmarks.compared_models import STRAINS
from supple_benchmarks.computer import describe_computer
from supple_benchmarks.nrel5mw_blade import BladeCase
from supple_benchmarks.table import Row, Table

__all__ = ["PUBLISHED", "report", "tables"]

PUBLISHED = {
    "mean-axis": {"full": 155307, "basis": 2053, "tensors": 230, "online": 72, "iterations": 10598},
    "nodal-fixed": {"full": 49254, "basis": 13.25, "tensors": 241, "online": 125, "iterations": 17758},
}
"""Seconds for 100 s of motion, and iterations of the reduced run; [Wu2019] Table 3: MATLAB on eight cores."""


def report(run: BladeRun) -> Row:
    """All measurements, ready for JSON; the first six keys must not change."""
    mesh, body = run.benchmark.blade.mesh, run.body
    along_x = body.rigid_modes[:, 0]
    return {
        "mesh": {
            "nodes": mesh.n_nodes,
            "triangles": sum(len(cells) for cells in mesh.cells.values()),
            "mass": float(along_x @ (body.mass @ along_x)),
            "frequencies_hz": (run.frequencies / (2 * np.pi)).tolist(),
        },
        "offline": _offline(run),
        "full": [_full_numbers(full) for full in run.full],
        "roms": [_reduced_numbers(run, rom) for rom in run.reduced],
        "self_correcting": [row for corrected in run.corrected for row in _rounds(corrected)],
        "batch": run.batch and {**asdict(run.batch), "cases_per_s": run.batch.cases_per_s},
        "published": PUBLISHED,
        "machine": describe_computer(),
    }


def _offline(run: BladeRun) -> dict[str, dict[str, float]]:
    """Cost of the first basis of each frame, the ten linear columns with fifteen derivatives."""
    offline: dict[str, dict[str, float]] = {}
    for rom in run.reduced:
        seconds = rom.body.report.seconds
        offline.setdefault(
            rom.basis.frame,
            {
                "basis_s": seconds["linear basis"] + seconds["derivatives"],
                "tensors_s": seconds["tensors"],
            },
        )
    return offline


def _full_numbers(full: FullRun) -> Row:
    wanted, statistics = full.case, full.solution.statistics
    return {
        "case": wanted.case.name,
        "frame": wanted.frame,
        "linear": wanted.linear,
        "kinematics": wanted.kinematics,
        "omega": wanted.case.speed,
        "iterations": statistics.iterations,
        "steps": statistics.steps,
        "seconds": statistics.seconds,
        "simulated_s": float(full.solution.times[-1]),
        "tip_amplitude_m": full.tip.amplitude,
        "tip_extremes_m": {
            name: [float(values.min()), float(values.max())]
            for name, values in (("flap", full.tip.flap), ("edge", full.tip.edge), ("span", full.tip.span))
        },
    }


def _reduced_numbers(run: BladeRun, rom: ReducedRun) -> Row:
    statistics = rom.solution.statistics
    full = run.full_of(rom.case, rom.basis.frame)
    simulated = float(rom.solution.times[-1])
    online = statistics.seconds / simulated
    speedups: dict[str, float | None] = {"speedup_online": None, "speedup_with_offline": None}
    if full is not None:
        at_full_length = _pace(full) * simulated
        speedups = {
            "speedup_online": _pace(full) / online,
            "speedup_with_offline": at_full_length / (rom.offline_seconds + statistics.seconds),
        }
    return {
        "case": rom.case.name,
        "frame": rom.basis.frame,
        "basis": rom.basis.name,
        "derivatives": rom.basis.derivatives_name,
        "tensors": rom.basis.tensors,
        "size": rom.body.r,
        "omega": rom.case.speed,
        "max_rms": None if rom.error is None else rom.error.max_rms,
        "max_rms_over_tip": None
        if rom.error is None or full is None
        else rom.error.max_rms / full.tip.amplitude,
        "iterations": statistics.iterations,
        "seconds": statistics.seconds,
        **speedups,
        "simulated_s": simulated,
        "compared_s": None if rom.error is None else float(rom.error.times[-1]),
        "offline_seconds": rom.offline_seconds,
        "compile_seconds": statistics.compile_seconds,
        "failed_at": rom.failed_at,
    }


def _pace(full: FullRun) -> float:
    """Seconds of computing per second of motion."""
    return full.solution.statistics.seconds / float(full.solution.times[-1])


def _rounds(corrected: CorrectedRun) -> list[Row]:
    truth = corrected.true_errors or (None,) * len(corrected.rounds)
    return [
        {
            "case": corrected.case.name,
            "frame": corrected.frame,
            "round": number,
            "size": each.size,
            "estimated_error": each.estimated_error if known else None,
            "indicator": each.indicator,
            "true_error": true,
            "estimate_over_truth": each.estimated_error / true if true is not None and known else None,
            "allowed": corrected.allowed,
            "reached": corrected.reached and number == len(corrected.rounds) - 1,
            "seconds": each.seconds,
        }
        for number, (each, true) in enumerate(zip(corrected.rounds, truth, strict=True))
        for known in (np.isfinite(each.estimated_error),)
    ]


def tables(run: BladeRun) -> list[Table]:
    """The report's tables: title, column heads, rows."""
    return [
        table
        for table in (_full_table(run), _cost_table(run), _error_table(run), _round_table(run))
        if table[2]
    ]


def _full_table(run: BladeRun) -> Table:
    rows = [
        [
            _short(full.case.case, full.case.frame),
            STRAINS[full.case.kinematics] + (", linear" if full.case.linear else ""),
            f"{full.solution.times[-1]:g}",
            f"{full.tip.amplitude:.4f}",
            f"{full.solution.statistics.iterations}",
            f"{1e3 * full.solution.statistics.seconds / full.solution.statistics.steps:.0f}",
        ]
        for full in run.full
    ]
    heads = ["model", "strains", "s", "tip, m", "iterations", "ms/step"]
    return "Full-order runs (GL: Green-Lagrange, vK: von Karman)", heads, rows


def _cost_table(run: BladeRun) -> Table:
    """[Wu2019] Table 3: the first basis of each frame at the first speed."""
    rows = []
    for frame, offline in _offline(run).items():
        rom = next(each for each in run.reduced if each.basis.frame == frame)
        full, theirs = run.full_of(rom.case, frame), PUBLISHED[frame]
        per_100 = 100 / float(rom.solution.times[-1])
        ours = [
            "-" if full is None else f"{100 * _pace(full):.0f}",
            f"{offline['basis_s']:.2f}",
            f"{offline['tensors_s']:.2f}",
            f"{per_100 * rom.solution.statistics.seconds:.2f}",
            f"{per_100 * rom.solution.statistics.iterations:.0f}",
        ]
        rows.append([f"{frame}, ours", *ours])
        rows.append([f"{frame}, [Wu2019]", *(f"{value:g}" for value in theirs.values())])
    heads = ["model", "full", "basis", "tensors", "online", "iterations"]
    return "Seconds for 100 s of operation, 10 + 15 columns ([Wu2019] Table 3)", heads, rows


def _error_table(run: BladeRun) -> Table:
    rows = []
    for rom in run.reduced:
        numbers = _reduced_numbers(run, rom)
        missing = rom.error is None
        rows.append(
            [
                _short(rom.case, rom.basis.frame),
                rom.basis.label,
                "-" if missing else f"{numbers['max_rms']:.1e}",
                "-" if missing else f"{numbers['max_rms_over_tip']:.1e}",
                f"{rom.solution.statistics.seconds:.2f}" + ("" if rom.failed_at is None else "*"),
                "-" if missing else f"{numbers['speedup_online']:.0f}",
            ]
        )
    heads = ["model", "columns", "RMS, m", "of tip", "s", "speed-up"]
    return "Bases of fixed size: largest RMS error against the full model in the same frame", heads, rows


def _round_table(run: BladeRun) -> Table:
    rows = [
        [
            _short(corrected.case, corrected.frame),
            f"{row['round']}",
            f"{row['size']}",
            "-" if row["estimated_error"] is None else f"{row['estimated_error']:.1e}",
            "-" if row["true_error"] is None else f"{row['true_error']:.1e}",
            f"{row['allowed']:.1e}",
            f"{row['seconds']:.1f}",
        ]
        for corrected in run.corrected
        for row in _rounds(corrected)
    ]
    heads = ["model", "round", "size", "estimated, m", "true, m", "allowed, m", "s"]
    return "Self-correction from 5 modes and 5 derivatives", heads, rows


def _short(case: BladeCase, frame: str) -> str:
    return f"{case.name}, {frame}"
