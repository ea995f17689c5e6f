"""The rotating beam's numbers: the JSON report, the tables with the paper's values."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple_benchmarks.compared_models import STRAINS
from supple_benchmarks.computer import describe_computer
from supple_benchmarks.rotating_beam.exact_beam import ExactTip
from supple_benchmarks.rotating_beam.run import BeamRun, FullRun, ReducedRun
from supple_benchmarks.rotating_beam.tip_motion import TipMotion, apart
from supple_benchmarks.table import Row, Table

__all__ = ["PUBLISHED_PEAKS", "PUBLISHED_RMS", "report", "tables"]

Array = NDArray[np.float64]

PUBLISHED_PEAKS = {6.0: -0.576, 8.0: -0.726, 10.0: -0.858, 12.0: -0.972}
"""m: largest transverse tip deflection by final speed; at 6 rad/s the literature spans -0.574 to -0.578."""
PUBLISHED_EXTENSION = 5.14e-4
"""m: steady axial extension at 6 rad/s, rho A omega^2 L^3 / (3 EA)."""
PUBLISHED_RMS = {"nodal-fixed": 1.5e-4, "mean-axis": 2e-5}
"""m: largest RMS error with 10 + 10 columns at 6 rad/s, [Wu2019] Fig. 7a."""


def _frame_of_record(run: BeamRun, omega: float) -> FullRun:
    """The full run used as reference: nodal-fixed, as in the literature, Green-Lagrange."""
    candidates = [full for full in run.full if full.omega == omega]
    return max(
        candidates, key=lambda full: (full.kinematics == "green-lagrange", full.frame == "nodal-fixed")
    )


def _parting(tip: TipMotion, exact: ExactTip) -> Row:
    """Largest distance of a tip from the exact beam's, and the time at which it exceeds 1 % of the peak.

    The keys `.._at_the_same_step` compare with the exact beam at the model's own step, which has the same
    time integration error: the difference is then the error of the model.
    """
    difference, peak = apart(tip, exact), np.max(abs(exact.v))
    of_the_model = apart(tip, exact.at_the_models_step)
    beyond = difference > 0.01 * peak
    return {
        "max_difference_m": float(difference.max()),
        "over_peak": float(difference.max() / peak),
        "parts_by_1_percent_at_s": float(tip.times[np.argmax(beyond)]) if beyond.any() else None,
        "max_difference_at_s": float(tip.times[np.argmax(difference)]),
        "rms_difference_m": _rms(difference),
        "compared_until_s": float(tip.times[len(difference) - 1]),
        "max_difference_at_the_same_step_m": float(of_the_model.max()),
        "rms_difference_at_the_same_step_m": _rms(of_the_model),
    }


def _rms(difference: Array) -> float:
    return float(np.sqrt(np.mean(difference**2)))


def _tip_numbers(tip: TipMotion, steady_from: float) -> dict[str, float]:
    peak, time = tip.peak()
    return {
        "v_peak": peak,
        "v_peak_time": time,
        "u_mean_after_16s": tip.mean_extension(steady_from),
    }


def report(run: BeamRun) -> Row:
    """All measurements, ready for JSON; the keys `tip`, `roms`, `full` and `machine` must not change."""
    steady = run.problem.steady_from
    speeds = [omega for omega in run.problem.speeds if any(full.omega == omega for full in run.full)]
    return {
        "tip": {
            f"{omega:g}": {
                **_tip_numbers(_frame_of_record(run, omega).tip, steady),
                "model": f"full, {_model(_frame_of_record(run, omega))}",
            }
            for omega in speeds
        },
        "exact_beam": {
            f"{omega:g}": {
                **_tip_numbers(run.exact[omega], steady),
                "step": run.exact[omega].step,
                "converged_within_m": run.exact[omega].converged_within,
                "time_error_at_the_models_step_m": float(
                    apart(run.exact[omega].at_the_models_step, run.exact[omega]).max()
                ),
            }
            for omega in speeds
        },
        "full": [
            {
                "frame": full.frame,
                "kinematics": full.kinematics,
                "omega": full.omega,
                "iterations": full.solution.statistics.iterations,
                "steps": full.solution.statistics.steps,
                "seconds": full.solution.statistics.seconds,
                **_tip_numbers(full.tip, steady),
                "against_exact_beam": _parting(full.tip, run.exact[full.omega]),
            }
            for full in run.full
        ],
        "roms": [_reduced_numbers(rom, run.exact[rom.full.omega]) for rom in run.reduced],
        "problem": vars(run.problem),
        "machine": describe_computer(),
    }


def _reduced_numbers(rom: ReducedRun, exact: ExactTip) -> Row:
    statistics = rom.solution.statistics
    return {
        "frame": rom.full.frame,
        "basis": rom.basis.name,
        "derivatives": rom.basis.derivatives_name,
        "tensors": rom.basis.tensors,
        "kinematics": rom.full.kinematics,
        "linear": rom.basis.n_linear,
        "added": rom.basis.n_added,
        "size": rom.body.r,
        "omega": rom.full.omega,
        "max_rms": rom.error.max_rms,
        "re_percent": rom.error.relative_percent,
        "iterations": statistics.iterations,
        "seconds": statistics.seconds,
        "compile_seconds": statistics.compile_seconds,
        "offline_seconds": rom.offline_seconds,
        "cuts": statistics.rejected_steps,
        "failed_at": rom.failed_at,
        "against_exact_beam": _parting(rom.tip, exact),
    }


def tables(run: BeamRun) -> list[Table]:
    """The report's tables: title, column heads, rows."""
    steady = run.problem.steady_from
    motion = []
    for omega, exact in run.exact.items():
        rows: list[tuple[str, TipMotion]] = [("exact beam", exact)]
        rows += [(_model(full), full.tip) for full in run.full if full.omega == omega]
        for model, tip in rows:
            peak, time = tip.peak()
            published = PUBLISHED_PEAKS.get(omega)
            off = 100 * apart(tip, exact).max() / np.max(abs(exact.v))
            motion.append(
                [
                    f"{omega:g}",
                    model,
                    f"{peak:.4f}",
                    "" if published is None else f"{published:.3f}",
                    f"{time:.2f}",
                    f"{tip.mean_extension(steady):.3e}",
                    f"{off:.2f}",
                ]
            )
    errors = []
    for rom in run.reduced:
        statistics, reference = rom.solution.statistics, rom.full.solution.statistics
        published = PUBLISHED_RMS[rom.full.frame] if rom.basis.n_added and rom.full.omega == 6.0 else None
        errors.append(
            [
                f"{rom.full.omega:g}",
                _model(rom.full),
                rom.columns,
                f"{rom.error.max_rms:.1e}" + ("" if rom.failed_at is None else "*"),
                "" if published is None else f"{published:.1e}",
                f"{statistics.seconds:.2f}",
                f"{reference.seconds / statistics.seconds:.0f}",
            ]
        )
    broken = [rom for rom in run.reduced if rom.failed_at is not None]
    note = "; * stopped at " + ", ".join(f"{rom.failed_at:.2f} s" for rom in broken) if broken else ""
    return [
        (
            "Tip motion in axes that rotate with the root (GL: Green-Lagrange, vK: von Karman)",
            ["rad/s", "model", "peak v, m", "paper", "at, s", "mean u, m", "from exact, %"],
            motion,
        ),
        (
            "Largest RMS error against the full model in the same frame" + note,
            ["rad/s", "model", "columns", "RMS, m", "paper", "s", "speed-up"],
            errors,
        ),
    ]


def _model(full: FullRun) -> str:
    return f"{full.frame} {STRAINS[full.kinematics]}"
