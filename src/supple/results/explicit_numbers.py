"""Further results of an explicit run: parts, energies (also as a quantity) and their balance, steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from supple.arrays import FloatArray
from supple.integrate import Motion, Solution
from supple.machine import System
from supple.methods.explicit import (
    ENERGIES,
    STEPS,
    Energies,
    ExplicitShell,
    ExplicitSubdomain,
    ModalSubdomain,
)
from supple.methods.explicit.motions import NodalMotion
from supple.quantities import Channel, QuantityKind
from supple.results.run_tables import Numbers


@dataclass(frozen=True)
class MarchEnergySensor:
    """Energies of an explicit run: kinetic, internal, plastic, ...; see `Energies`."""

    name: str

    def channels(self, _system: System) -> Sequence[Channel]:
        """One channel for each of `Energies`."""
        return [Channel(each, QuantityKind.ENERGY, "") for each in Energies._fields]

    def values(self, _system: System, solution: Solution) -> FloatArray:
        """The energies, (t, 8)."""
        return np.asarray(solution.series[ENERGIES])


def energy_balance(solution: Solution) -> FloatArray:
    """Sum of all energies minus the external work, less its value at the start, (t,) J."""
    energies = solution.series[ENERGIES]
    external = Energies._fields.index("external")
    total = np.delete(energies, external, axis=1).sum(axis=1) - energies[:, external]
    return total - total[0]


def march_numbers(solution: Solution) -> dict[str, Any]:
    """Energies, balance error, and steps of an explicit run; empty for other methods."""
    if ENERGIES not in solution.series:
        return {}
    times, energies, steps = solution.times, solution.series[ENERGIES], solution.series[STEPS][1:]
    opened, scale = float(np.abs(energy_balance(solution)).max()), float(np.abs(energies).max())
    return {
        "energies": {
            name: {
                "start": float(values[0]),
                "largest": float(values[np.abs(values).argmax()]),
                "time of largest": float(times[np.abs(values).argmax()]),
                "end": float(values[-1]),
            }
            for name, values in zip(Energies._fields, energies.T, strict=True)
        },
        "balance": {"largest": opened, "relative": opened / scale if scale else 0.0},
        "steps": {
            "smallest": float(steps[:, 0].min(initial=np.inf)) if len(steps) else 0.0,
            "largest": float(steps[:, 0].max(initial=0.0)),
            "largest ratio": int(steps[:, 1].max(initial=1)),
        },
    }


def part_numbers(body: ModalSubdomain | ExplicitSubdomain | ExplicitShell, motion: Motion) -> dict[str, Any]:
    """Size and step limit at rest of a part; for explicit elements, also plastic strain and deletions."""
    size: dict[str, Any] = {"mass": body.mass, "nodes": len(body.nodes), "step limit": body.step_limit}
    if body.has_frame:
        return {**size, "coordinates": body.n_coordinates}
    own = motion.of_type(NodalMotion)
    return {
        **size,
        "elements": own.alive.shape[1],
        "deleted": int((own.alive[-1] == 0).sum()),
        "largest plastic strain": float(own.plastic_strain.max()),
    }


def explicit_cost_line(numbers: Numbers) -> str:
    """Steps and seconds in one line; numbers from `summarize`."""
    steps, cost = numbers["steps"], numbers["statistics"]
    time = numbers["units"].get("time", "")
    longest = f"{steps['largest']:.3g}{f' {time}' if time else ''}"
    is_mixed = {"modal", "explicit"} <= {body["kind"] for body in numbers["bodies"].values()}
    per_modal_step = f", up to {steps['largest ratio']} per step of the modal parts" if is_mixed else ""
    return (
        f"{cost['steps']} explicit steps of at most {longest}{per_modal_step}; {cost['seconds']:.2f} s with "
        "compilation"
    )
