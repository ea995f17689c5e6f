"""The tables that a run prints, and the same numbers for a JSON file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from rich.table import Table

from supple.body import FullBody, RigidBody
from supple.cli.tracked_motion import TrackedMotion
from supple.integrate import Solution, Statistics
from supple.machine import System
from supple.reduction import clamped_modes

N_FREQUENCIES = 5


def summarize(system: System, tracked: Sequence[TrackedMotion], solution: Solution) -> dict[str, Any]:
    """Numbers of a finished run: bodies, tracked places, joint forces, cost."""
    return {
        "bodies": {placed.body.name: body_numbers(placed.body) for placed in system.bodies},
        "tracked": {place.place: _place_numbers(place, solution.times) for place in tracked},
        "joints": {
            name: _joint_numbers(loads, solution.times)
            for name, loads in joint_loads(system, solution).items()
        },
        "statistics": cost_numbers(solution.statistics),
    }


def body_numbers(body: Any) -> dict[str, Any]:
    """Kind, size, mass and frequencies of a body."""
    if isinstance(body, RigidBody):
        return {"kind": "rigid", "mass": body.mass}
    if isinstance(body, FullBody):
        return {"kind": "full", "nodes": len(body.nodes), "coordinates": body.n_coordinates}
    held = {
        i.name: _hertz(clamped_modes(body, i.name, n_modes=N_FREQUENCIES).frequencies)
        for i in body.interfaces
    }
    proven = body.report.certificate
    return {
        "kind": "reduced",
        "mass": float(body.gram[0, 0]),
        "nodes": len(body.nodes),
        "freedoms": body.nodal_basis.shape[0],
        "coordinates": body.r,
        "linear columns": len(body.report.linear),
        "derivative columns": len(body.report.derivatives),
        "dropped columns": list(body.report.dropped),
        "largest singular value dropped": float(np.max(body.report.singular_values_dropped, initial=0.0)),
        "frequencies in the frame, Hz": _hertz(body.frequencies[:N_FREQUENCIES]),
        "frequencies held, Hz": held,
        **({} if proven is None else {"eigenvalues": str(proven)}),
        "seconds": dict(body.report.seconds),
    }


def _hertz(omega: np.ndarray) -> np.ndarray:
    return omega / (2 * np.pi)


def _place_numbers(place: TrackedMotion, times: np.ndarray) -> dict[str, Any]:
    peaks = np.argmax(np.abs(place.deflection), axis=0)
    return {
        "seen from": place.seen_from,
        "largest deflection": place.deflection[peaks, range(3)],
        "at time": times[peaks],
        "last deflection": place.deflection[-1],
        "last position": place.position[-1],
    }


def joint_loads(system: System, solution: Solution) -> dict[str, dict[str, np.ndarray]]:
    """Force and moment (t, k) on the second end of each joint, in the joint's axes on the first end."""
    loads: dict[str, dict[str, np.ndarray]] = {}
    for joint in system.joints:
        # The multipliers hold the second end back along the gap that they close: it feels their opposite.
        acting = -solution.joint_forces[joint.name]
        forces = np.array([row.startswith("position") for row in joint.rows])
        parts = {"force": acting[:, forces], "moment": acting[:, ~forces]}
        loads[joint.name] = {what: part for what, part in parts.items() if part.shape[1]}
    return loads


def _joint_numbers(loads: Mapping[str, np.ndarray], times: np.ndarray) -> dict[str, Any]:
    numbers: dict[str, Any] = {}
    for what, components in loads.items():
        size = np.linalg.norm(components, axis=1)
        largest = int(np.argmax(size))
        numbers[f"largest {what}"] = float(size[largest])
        numbers[f"time of largest {what}"] = float(times[largest])
        numbers[f"last {what}"] = components[-1]
    return numbers


def body_table(numbers: Mapping[str, Any]) -> Table:
    """One row per body: size and lowest frequencies."""
    table = Table(
        "body", "kind", "mass", "nodes", "coordinates", "held at", "lowest frequencies, Hz", title="Bodies"
    )
    for name, body in numbers["bodies"].items():
        cells = [name, body["kind"], _number(body.get("mass")), _count(body.get("nodes"))]
        coordinates = _count(body.get("coordinates"))
        if body["kind"] == "reduced":
            coordinates = f"{coordinates} of {body['freedoms']}"
        held = {"(its frame)": body.get("frequencies in the frame, Hz", ())} | body.get(
            "frequencies held, Hz", {}
        )
        for row, (place, frequencies) in enumerate(held.items()):
            head = [*cells, coordinates] if row == 0 else [""] * 5
            if len(frequencies) or row == 0:
                table.add_row(*head, place if len(frequencies) else "", _vector(frequencies, digits=4))
    return table


def place_table(numbers: Mapping[str, Any]) -> Table:
    """One row per axis of each tracked place."""
    table = Table(
        "place", "seen from", "axis", "largest deflection", "at time", "at the end", title="Tracked motion"
    )
    for name, place in numbers["tracked"].items():
        for axis, letter in enumerate("xyz"):
            head = [name, place["seen from"]] if axis == 0 else ["", ""]
            values = (place[key][axis] for key in ("largest deflection", "at time", "last deflection"))
            table.add_row(*head, letter, *(_number(value) for value in values))
    return table


def joint_table(numbers: Mapping[str, Any]) -> Table:
    """Force and moment on the second end of each joint."""
    table = Table(
        "joint",
        "on its second end",
        "largest",
        "at time",
        "at the end (x, y, z of the joint)",
        title="Joints",
    )
    for name, joint in numbers["joints"].items():
        for row, what in enumerate(what for what in ("force", "moment") if f"largest {what}" in joint):
            table.add_row(
                name if row == 0 else "",
                what,
                _number(joint[f"largest {what}"]),
                _number(joint[f"time of largest {what}"]),
                _vector(joint[f"last {what}"]),
            )
    return table


def cost_numbers(cost: Statistics) -> dict[str, float]:
    """The cost of a run under the names that scripts read."""
    return {
        "steps": cost.steps,
        "iterations": cost.iterations,
        "cuts": cost.rejected_steps,
        "seconds": cost.seconds,
        "compile_seconds": cost.compile_seconds,
    }


def cost_line(solution: Solution) -> str:
    """Steps, iterations and seconds in one line."""
    cost = solution.statistics
    return (
        f"{cost.steps} steps, {cost.iterations} Newton iterations, {cost.rejected_steps} cuts; "
        f"{cost.seconds:.2f} s of simulation after {cost.compile_seconds:.1f} s of compilation"
    )


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.5g}"


def _count(value: int | None) -> str:
    return "" if value is None else str(value)


def _vector(values: Sequence[float] | np.ndarray, digits: int = 5) -> str:
    return "  ".join(f"{value:.{digits}g}" for value in values)
