"""The study of tolerances in numbers: the JSON report and its tables."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from supple.reduction import ReducedBody
from supple_benchmarks.computer import describe_computer
from supple_benchmarks.machines.run import MachineRun, PointHistory, Variant
from supple_benchmarks.machines.study import APART, Separation, Study
from supple_benchmarks.table import Row, Table

__all__ = ["QUANTITIES", "report", "tables"]

Array = NDArray[np.float64]

QUANTITIES = ("position", "velocity", "acceleration", "stress", "strain")
"""Quantities of node A, in m, m/s, m/s^2, Pa, 1."""
TABLED = ("position", "velocity", "stress")
VARIANTS = {
    Variant.MODAL_COORDINATES: "tolerances",
    Variant.WITH_ATTACHMENT_MODES: "with_attachment_modes",
    Variant.WHOLE_BASIS: "whole_bases",
}
"""Variants of the reduced body, and their keys in the report."""
SHORT = {
    Variant.UNREDUCED: "unreduced",
    Variant.EXACT_MODES: "exact",
    Variant.MODAL_COORDINATES: "modal",
    Variant.WITH_ATTACHMENT_MODES: "attached",
    Variant.WHOLE_BASIS: "whole",
}
"""Short names for a table."""


def report(study: Study) -> Row:
    """All measurements, ready for JSON."""
    machine, reference = study.machine, study.reference
    mesh = machine.model.mesh
    exact = study.of(Variant.EXACT_MODES)
    return {
        "benchmark": machine.name,
        "body": {
            "element": mesh.only_cell_type().name.lower(),
            "cells": mesh.n_cells,
            "nodes": mesh.n_nodes,
            "coordinates": machine.body.n,
        },
        "node_a": {"number": machine.point, "position": mesh.nodes[machine.point]},
        "duration": machine.duration,
        "step": machine.step,
        "unreduced": _kept(reference) | _cost(reference) | {"largest": _largest(reference.point)},
        "compared_until": study.compared_until,
        "chaos": {
            "criterion": f"node A of two runs of one body with a distance above {APART * machine.size:g} m",
            "takes_over_at": min((s.time for s in study.separations if s.time is not None), default=None),
            "separations": [_separation(each) for each in study.separations],
        },
        **{name: [_row(study, run) for run in study.of(variant)] for variant, name in VARIANTS.items()},
        "exact_modes": _row(study, exact[0]) if exact else None,
        "smaller_e_smaller_error": {
            "from": machine.compared_from,
            "share_of_outputs": {
                name: _ordered_shares(study, study.of(variant), reference)
                for variant, name in VARIANTS.items()
            },
            "share_of_outputs_against_exact_modes": _ordered_shares(
                study, study.of(Variant.MODAL_COORDINATES), exact[0]
            )
            if exact
            else None,
        },
        "machine": describe_computer(),
    }


def _cost(run: MachineRun) -> Row:
    statistics = run.solution.statistics
    return {
        "seconds": statistics.seconds,
        "us_per_step": 1e6 * statistics.seconds / max(statistics.steps, 1),
        "steps": statistics.steps,
        "iterations": statistics.iterations,
        "compile_seconds": statistics.compile_seconds,
    }


def _kept(run: MachineRun) -> dict[str, float]:
    return {"energy_drift": run.drift.energy, "joint_drift": run.drift.joints}


def _row(study: Study, run: MachineRun) -> Row:
    reduced = run.system.bodies_of(ReducedBody).get(run.body.name)
    proven = reduced.report.certificate if reduced is not None else None
    exact = study.of(Variant.EXACT_MODES)[0]
    return {
        "e": run.tolerance,
        "modes": run.modes,
        "coordinates": run.body.n_coordinates,
        "largest_eigenvalue_error": None if proven is None else proven.largest_error,
        "errors": errors(study, run, study.reference),
        "errors_against_exact_modes": errors(study, run, exact),
        **_kept(run),
        "offline_seconds": run.offline_seconds,
        **_cost(run),
    }


def errors(study: Study, run: MachineRun, against: MachineRun) -> dict[str, dict[str, float]]:
    """Largest and RMS distance of every quantity of node A, until the motion becomes chaotic.

    If `against` is the unreduced body, also the error of the whole deformation in the energy norm.
    """
    compared = run.point.times <= study.compared_until * (1 + 1e-12)

    def measured(distance: Array, scale: float) -> dict[str, float]:
        return {
            "max": float(distance.max()),
            "rms": float(np.sqrt(np.mean(distance**2))),
            "max_over_largest": float(distance.max()) / scale if scale else 0.0,
        }

    found = {
        quantity: measured(
            _distance(run.point, against.point, quantity)[compared],
            float(np.abs(getattr(against.point, quantity)).max()),
        )
        for quantity in QUANTITIES
    }
    if against is study.reference:
        norm = float(against.deformation_error[compared].max())
        found["deformation"] = measured(run.deformation_error[compared], norm)
    return found


def _distance(one: PointHistory, other: PointHistory, quantity: str) -> Array:
    difference = np.abs(getattr(one, quantity) - getattr(other, quantity))
    return difference if difference.ndim == 1 else np.linalg.norm(difference, axis=1)


def _largest(point: PointHistory) -> dict[str, float]:
    return {quantity: float(np.abs(getattr(point, quantity)).max()) for quantity in QUANTITIES}


def _ordered_shares(study: Study, runs: list[MachineRun], against: MachineRun) -> Row | None:
    """Share of the outputs at which each smaller tolerance has the smaller error."""
    if len(runs) < 2:
        return None
    shares: Row = {}
    if against is study.reference:
        shares["deformation"] = ordered_share(study, [run.deformation_error for run in runs])
    # The error of a vibrating node passes through zero repeatedly: its RMS up to each output is compared.
    shares["node_a_rms_so_far"] = {
        quantity: ordered_share(
            study, [_sum_so_far(study, _distance(run.point, against.point, quantity)) for run in runs]
        )
        for quantity in QUANTITIES
    }
    return shares


def _sum_so_far(study: Study, distance: Array) -> Array:
    return np.cumsum(np.where(study.reference.point.times > study.machine.compared_from, distance, 0.0) ** 2)


def ordered_share(study: Study, errors: list[Array]) -> float:
    """Share of the compared outputs at which no error (t,) exceeds that of the next looser tolerance."""
    times = study.reference.point.times
    compared = (times > study.machine.compared_from) & (times <= study.compared_until * (1 + 1e-12))
    ordered = np.all([tighter <= looser for looser, tighter in pairwise(errors)], axis=0)
    return float(ordered[compared].mean())


def _separation(each: Separation) -> Row:
    coarse, fine = each.solutions
    return {
        "steps": [each.coarse, each.fine],
        "numbers_of_steps": [coarse.statistics.steps, fine.statistics.steps],
        "apart_at": each.time,
        "largest_distance": float(each.distance.max()),
    }


def _brief(number: float) -> str:
    """Two digits, without zeros in the exponent."""
    mantissa, exponent = f"{number:.1e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def tables(study: Study) -> list[Table]:
    """The report's tables: title, column heads, rows."""
    heads = ["basis", "e, %", "modes", "size", "u, %", "r, m", "v, m/s", "Pa", "us/step"]
    rows = []
    for run in study.runs:
        found = errors(study, run, study.reference)
        rows.append(
            [
                SHORT[run.variant],
                "0" if run.tolerance is None else f"{100 * run.tolerance:g}",
                "" if run.modes is None else str(run.modes),
                str(run.body.n_coordinates),
                f"{100 * found['deformation']['max_over_largest']:.2g}",
                *(_brief(found[quantity]["max"]) for quantity in TABLED),
                f"{_cost(run)['us_per_step']:.0f}",
            ]
        )
    largest = _largest(study.reference.point)
    full = [SHORT[Variant.UNREDUCED], "", "", str(study.machine.body.n)]
    full += ["100", *(_brief(largest[quantity]) for quantity in TABLED)]
    rows.append([*full, f"{_cost(study.reference)['us_per_step']:.0f}"])
    title = (
        f"Largest errors until {study.compared_until:.4g} s: of the deformation u in the energy norm, and of "
        "node A; last row: largest values"
    )
    apart = [
        [each.coarse, each.fine, "never" if each.time is None else f"{each.time:.3f}"]
        for each in study.separations
    ]
    return [
        (title, heads, rows),
        ("Time at which two runs of one body differ by 1 % of its length", ["one", "other", "at, s"], apart),
    ]
