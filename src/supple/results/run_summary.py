"""The results of a finished run, under the names of its JSON report."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from supple.arguments import checked_arguments
from supple.body import BodyForm, FullBody
from supple.fem import FiniteElementModel, cells_without_stress, has_stress
from supple.integrate import FramedMotion, Motion, Solution, Statistics
from supple.machine import System
from supple.methods.explicit import ExplicitShell, ExplicitSubdomain, ModalSubdomain
from supple.methods.intrinsic import IntrinsicBody
from supple.quantities.contact_force import contact_forces
from supple.quantities.force_sensors import joint_loads, joint_meanings
from supple.quantities.stress_history import largest_stress
from supple.quantities.tracked_motion import TrackedMotion
from supple.reduction import ReducedBody, clamped_modes
from supple.results.explicit_fields import has_explicit_elements, largest_part_stress
from supple.results.explicit_numbers import march_numbers, part_numbers
from supple.results.run_start import start_numbers
from supple.units import UNNAMED, UnitSystem, headed

__all__ = ["body_numbers", "stress_numbers", "summarize", "unit_names"]

N_FREQUENCIES = 5
N_DRAWN_MODES = 6
"""Numbers of frequencies in tables, and of modes in pictures, for each body."""
_QUANTITIES = ("length", "mass", "time", "force", "moment", "stress", "energy")


@checked_arguments
def summarize(
    system: System,
    solution: Solution,
    tracked: Mapping[str, TrackedMotion] = MappingProxyType({}),
    *,
    fulls: Mapping[str, FullBody] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> dict[str, Any]:
    """Results of a finished run: bodies, tracked places, joint forces, start, errors, cost and units.

    tracked : motions of places, by their names
    fulls : full bodies by the names of their reduced bodies; their frequencies are given in the results
    units : units of the model; frequencies are in Hz, or in one over its unit of time if that has no name;
        all other numbers are as computed
    """
    meanings = joint_meanings(system)
    return {
        "units": unit_names(units),
        "bodies": {
            body.name: body_numbers(body, units, fulls.get(body.name), solution.bodies[body.name])
            for body in (placed.body for placed in system.bodies)
        },
        **march_numbers(solution),
        "tracked": {name: _place_numbers(place, solution.times) for name, place in tracked.items()},
        "joints": {
            name: {**meanings[name], **_joint_numbers(loads, solution.times)}
            for name, loads in joint_loads(system, solution).items()
        },
        "contacts": {
            each.name: _contact_numbers(each.force, solution.times)
            for each in contact_forces(system, solution)
        },
        "start": start_numbers(system, solution),
        "errors": {name: each.plain() for name, each in solution.errors.items()},
        "statistics": cost_numbers(solution.statistics),
    }


def stress_numbers(
    system: System,
    solution: Solution,
    elements: Mapping[str, FiniteElementModel],
    *,
    units: UnitSystem = UNNAMED,
) -> dict[str, Any]:
    """By body: its largest von Mises stress over all output times and nodes, or cells of explicit parts.

    elements : finite element models of the bodies, by name; bodies without a model or without recovery points
        of stress are left out
    """
    found = {}
    for body in (placed.body for placed in system.bodies):
        model = elements.get(body.name)
        if model is None or not has_stress(model):
            continue
        if has_explicit_elements(body):
            found[body.name] = largest_part_stress(body, solution, units)
        elif body.n_coordinates:
            motion = solution.motion(body.name, FramedMotion)
            largest = largest_stress(body, model, motion.coordinates)
            found[body.name] = {
                "largest von Mises stress": largest.value,
                "unit": units.stress,
                "node": int(model.mesh.node_ids[largest.node]),
                "point": model.mesh.nodes[largest.node].tolist(),
                "time": float(solution.times[largest.instant]),
            }
            if without := cells_without_stress(model):
                found[body.name]["cells without stress"] = without
    return found


def unit_names(units: UnitSystem) -> dict[str, str]:
    """Name of the unit of each quantity of a report; quantities whose unit has no name are left out."""
    named = {what: getattr(units, what) for what in _QUANTITIES} | {"frequency": units.frequency_shown.unit}
    return {what: unit for what, unit in named.items() if unit}


def body_numbers(
    body: BodyForm,
    units: UnitSystem = UNNAMED,
    full: FullBody | None = None,
    motion: Motion | None = None,
) -> dict[str, Any]:
    """Kind, size, mass and frequencies of a body.

    units : of the model; frequencies are in Hz, or in one over its unit of time if that has no name
    full : full body of a reduced body; its frequencies are then given instead of those of the basis
    motion : motion of a part of an explicit run
    """
    match body:
        case ModalSubdomain() | ExplicitSubdomain() | ExplicitShell() if motion is not None:
            own = part_numbers(body, motion)
        case IntrinsicBody():
            own = _numbers_of_intrinsic(body, units)
        case FullBody():
            own = {"nodes": len(body.nodes), "coordinates": body.n_coordinates}
        case ReducedBody():
            own = _numbers_of_reduced(body, units, full)
        case _:
            own = {"mass": body.mass}
    return {"kind": body.kind, **own}


def _numbers_of_reduced(body: ReducedBody, units: UnitSystem, full: FullBody | None) -> dict[str, Any]:
    clamped = {i.name: clamped_modes(body, i.name, n_modes=N_FREQUENCIES) for i in body.interfaces}
    damped = {name: modes.damping_ratios for name, modes in clamped.items()} if body.damping.any() else {}
    if full is None:
        in_frame = body.frequencies[:N_FREQUENCIES]
        held = {name: modes.frequencies for name, modes in clamped.items()}
    else:
        in_frame = _lowest(full, full.frame.constraint(full.body))
        held = {i.name: _lowest(full, i.motion) for i in full.interfaces}
    proven, hertz = body.report.certificate, units.frequency_shown.unit
    further: dict[str, Any] = {} if proven is None else {"eigenvalues": str(proven)}
    if (locking := body.report.locking) is not None:
        further["locking"] = {
            "largest": locking.largest_remaining,
            "largest without condensation": locking.largest_plain,
            "without condensation": dict(zip(locking.loads, locking.plain.tolist(), strict=True)),
        }
    return {
        "mass": body.mass,
        "nodes": len(body.nodes),
        "freedoms": body.nodal_basis.shape[0],
        "coordinates": body.r,
        "linear columns": len(body.report.linear),
        "derivative columns": len(body.report.derivatives),
        "dropped columns": list(body.report.dropped),
        "largest singular value dropped": float(np.max(body.report.singular_values_dropped, initial=0.0)),
        headed("frequencies in the frame", hertz): _shown(in_frame, units),
        headed("frequencies held", hertz): {name: _shown(each, units) for name, each in held.items()},
        **({"damping ratios held": damped} if damped else {}),
        "frequencies of": "the basis" if full is None else "the body",
        **further,
        "seconds": dict(body.report.seconds),
    }


def _lowest(full: FullBody, constraint: np.ndarray | csr_array) -> np.ndarray:
    """The lowest frequencies of the full body, rad/s, up to `N_FREQUENCIES`."""
    return full.body.lowest_frequencies(min(N_FREQUENCIES, full.body.n - constraint.shape[0]), constraint)


def _numbers_of_intrinsic(body: IntrinsicBody, units: UnitSystem) -> dict[str, Any]:
    first, second = body.modes.orthonormality
    hertz, free = units.frequency_shown.unit, body.support.free.shape[1]
    lowest = _shown(body.modes.frequencies[:N_FREQUENCIES], units)
    root = next((name for name, station in body.stations.items() if station == 0), "root")
    held = root if free == 0 else f"{root}, with {free} free motions"
    what, shown = ("frequencies in the frame", lowest) if free == 6 else ("frequencies held", {held: lowest})
    return {
        "mass": body.mass,
        "nodes": len(body.nodes),
        "stations": body.line.n,
        "coordinates": body.n_coordinates,
        headed(what, hertz): shown,
        "orthonormality": {"velocities": first, "forces": second},
    }


def _shown(omega: np.ndarray, units: UnitSystem) -> np.ndarray:
    return units.frequency_shown.factor * omega / (2 * np.pi)


def _place_numbers(place: TrackedMotion, times: np.ndarray) -> dict[str, Any]:
    peaks = np.argmax(np.abs(place.deflection), axis=0)
    return {
        "lowest position": place.position.min(axis=0),
        "highest position": place.position.max(axis=0),
        "seen from": place.seen_from,
        "elastic": place.is_elastic,
        "largest deflection": place.deflection[peaks, range(3)],
        "at time": times[peaks],
        "last deflection": place.deflection[-1],
        "last position": place.position[-1],
    }


def _joint_numbers(loads: Mapping[str, np.ndarray], times: np.ndarray) -> dict[str, Any]:
    numbers: dict[str, Any] = {}
    for what, components in loads.items():
        numbers |= _peak_numbers(what, components, times)[1] | {f"last {what}": components[-1]}
    return numbers


def _contact_numbers(force: np.ndarray, times: np.ndarray) -> dict[str, Any]:
    largest, numbers = _peak_numbers("force", force, times)
    return numbers | {"components of largest force": force[largest]}


def _peak_numbers(what: str, components: np.ndarray, times: np.ndarray) -> tuple[int, dict[str, float]]:
    """Index of the largest magnitude of components (t, 3), and this magnitude with its time."""
    size = np.linalg.norm(components, axis=1)
    largest = int(np.argmax(size))
    return largest, {
        f"largest {what}": float(size[largest]),
        f"time of largest {what}": float(times[largest]),
    }


def cost_numbers(cost: Statistics) -> dict[str, float]:
    """The cost of a run under the names of the JSON report."""
    numbers = {
        "steps": cost.steps,
        "iterations": cost.iterations,
        "cuts": cost.rejected_steps,
        "seconds": cost.seconds,
        "compile_seconds": cost.compile_seconds,
        "largest local error of a step": cost.largest_error,
        "largest turn in a step, rad": cost.largest_turn,
    }
    if cost.factorizations and cost.contraction is not None:  # a frozen tangent
        numbers |= {"factorizations": cost.factorizations, "residual left by an iteration": cost.contraction}
    return numbers
