"""The numbers of an explicit run: parts, energies and their balance, steps, and what is tracked."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.explicit import (
    ENERGIES,
    STEPS,
    Energies,
    ExplicitSystem,
    ModalSubdomain,
    part_positions,
)
from supple.explicit.series_motion import series_of
from supple.integrate import Solution
from supple.machine import At
from supple.results.explicit_fields import largest_stress
from supple.results.run_summary import cost_numbers, unit_names
from supple.units import UNNAMED, UnitSystem

__all__ = ["energy_balance", "mean_motion", "summarize_explicit"]

FloatArray = NDArray[np.float64]


def energy_balance(solution: Solution) -> FloatArray:
    """By how much the sum of all energies less external work has changed since the start, (t,) J."""
    energies = series_of(solution, ENERGIES)
    external = Energies._fields.index("external")
    total = np.delete(energies, external, axis=1).sum(axis=1) - energies[:, external]
    return total - total[0]


def mean_motion(system: ExplicitSystem, solution: Solution, place: At) -> FloatArray:
    """Mean position (t, 3) of the nodes of a set."""
    subdomain = system.part(place.body).subdomain
    motion: Any = solution.bodies[place.body]
    return part_positions(subdomain, motion, system.node_numbers(place)).mean(axis=1)


def summarize_explicit(
    system: ExplicitSystem,
    solution: Solution,
    tracked: Mapping[str, FloatArray] = MappingProxyType({}),
    *,
    units: UnitSystem = UNNAMED,
) -> dict[str, Any]:
    """Numbers of a finished explicit run, and what they are in.

    tracked : mean positions (t, 3) of places, by their names
    """
    times = solution.times
    energies = series_of(solution, ENERGIES)
    steps = series_of(solution, STEPS)[1:]
    balance = energy_balance(solution)
    scale = float(np.abs(energies).max())
    return {
        "units": unit_names(units),
        "parts": {part.name: _part_numbers(part.subdomain, solution) for part in system.placed},
        "energies": {
            name: {
                "start": float(values[0]),
                "largest": float(values[np.abs(values).argmax()]),
                "time of largest": float(times[np.abs(values).argmax()]),
                "end": float(values[-1]),
            }
            for name, values in zip(Energies._fields, energies.T, strict=True)
        },
        "balance": {
            "largest": float(np.abs(balance).max()),
            "relative": float(np.abs(balance).max()) / scale if scale else 0.0,
        },
        "steps": {
            "smallest": float(steps[:, 0].min()) if len(steps) else 0.0,
            "largest": float(steps[:, 0].max()) if len(steps) else 0.0,
            "largest ratio": int(steps[:, 1].max()) if len(steps) else 1,
        },
        "tracked": {
            name: {
                "lowest position": position.min(axis=0).tolist(),
                "highest position": position.max(axis=0).tolist(),
                "last position": position[-1].tolist(),
            }
            for name, position in tracked.items()
        },
        "statistics": cost_numbers(solution.statistics),
    }


def _part_numbers(subdomain: Any, solution: Solution) -> dict[str, Any]:
    motion: Any = solution.bodies[subdomain.name]
    where = "node" if isinstance(subdomain, ModalSubdomain) else "cell"
    stress = largest_stress(subdomain, solution.times, motion)
    found = (
        {}
        if stress is None
        else {"largest stress": {"value": stress.value, "time": stress.time, where: stress.place}}
    )
    return _kind_numbers(subdomain, motion) | found


def _kind_numbers(subdomain: Any, motion: Any) -> dict[str, Any]:
    if not isinstance(subdomain, ModalSubdomain):
        return {
            "kind": "explicit",
            "mass": float(subdomain.masses.sum()),
            "nodes": len(subdomain.nodes),
            "elements": motion.alive.shape[1],
            "deleted": int((motion.alive[-1] == 0).sum()),
            "step limit": subdomain.step_limit,
            "largest plastic strain": float(motion.plastic_strain.max()),
        }
    return {
        "kind": "modal",
        "mass": float(np.asarray(subdomain.moments.S0).sum()),
        "nodes": len(subdomain.body.nodes),
        "modes": subdomain.n_modes,
        "step limit": subdomain.step_limit,
    }
