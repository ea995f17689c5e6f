"""The pictures of an explicit run: its energies, what is tracked, and films in stress and plastic strain."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.explicit import (
    ENERGIES,
    OBSTACLES,
    Energies,
    ExplicitShell,
    ExplicitSubdomain,
    ExplicitSystem,
    part_positions,
)
from supple.explicit.series_motion import series_of
from supple.integrate import Solution
from supple.results.explicit_fields import element_means, nodal_von_mises
from supple.units import UNNAMED, UnitSystem, labelled
from supple.viz.animation import animate
from supple.viz.mesh_skin import skin_of
from supple.viz.obstacle_surface import obstacle_actor
from supple.viz.scene import Actor, scene_of
from supple.viz.style import as_written
from supple.viz.time_history import Panel, Series, plot_time_history

__all__ = ["COLOURINGS", "Colouring", "animate_explicit", "draw_explicit"]

FloatArray = NDArray[np.float64]

N_FRAMES = 60
FRAMES_PER_SECOND = 12.0


@dataclass(frozen=True)
class Colouring:
    """What colours a film.

    values : of a part and its motion, (t, N); None where it has none
    label, factor : of a unit system: what stands under the colour bar, and what the values are shown times
    """

    values: Callable[[Any, Any], FloatArray | None]
    label: Callable[[UnitSystem], tuple[str, float]]


def _stress_label(units: UnitSystem) -> tuple[str, float]:
    unit, factor = units.stress_shown
    return labelled("von Mises stress", unit), factor


def _plastic_strain(subdomain: Any, motion: Any) -> FloatArray | None:
    yields = isinstance(subdomain, ExplicitShell) and subdomain.law is not None
    if not yields and not isinstance(subdomain, ExplicitSubdomain):
        return None
    return element_means(subdomain, motion.plastic_strain, motion.alive)


COLOURINGS: Mapping[str, Colouring] = MappingProxyType(
    {
        "von-mises": Colouring(nodal_von_mises, _stress_label),
        "plastic-strain": Colouring(_plastic_strain, lambda _: ("plastic strain", 1.0)),
    }
)
"""The ways to colour a film, by the names that case files use."""


def draw_explicit(
    folder: Path,
    solution: Solution,
    tracked: Mapping[str, FloatArray] = MappingProxyType({}),
    *,
    units: UnitSystem = UNNAMED,
) -> list[Path]:
    """Draw `energies.png`, every term of the balance over time, and `tracked-motion.png` if anything is.

    tracked : positions (t, 3) by name
    """
    times = solution.times
    energies = series_of(solution, ENERGIES)
    shown = [
        Series(name, times, values)
        for name, values in zip(Energies._fields, energies.T, strict=True)
        if values.any()
    ]
    pictures = [
        plot_time_history(
            folder / "energies.png",
            [Panel(labelled("energy", units.energy), shown or [Series("kinetic", times, energies[:, 0])])],
            units=units,
        )
    ]
    if tracked:
        panels = [
            Panel(
                labelled(f"{axis}, global", units.length),
                [Series(as_written(name), times, position[:, i]) for name, position in tracked.items()],
            )
            for i, axis in enumerate("xyz")
        ]
        pictures.append(plot_time_history(folder / "tracked-motion.png", panels, units=units))
    return pictures


def animate_explicit(
    path: Path,
    system: ExplicitSystem,
    solution: Solution,
    colouring: Colouring,
    *,
    units: UnitSystem = UNNAMED,
    progress: Callable[[float], None] | None = None,
) -> Path | None:
    """Animate the parts and the obstacles; None where no part has what the film is to be coloured by."""
    chosen = np.unique(np.linspace(0, len(solution.times) - 1, N_FRAMES).astype(int))
    label, factor = colouring.label(units)
    actors = []
    for part in system.placed:
        motion: Any = solution.bodies[part.name].at(chosen)
        values = colouring.values(part.subdomain, motion)
        shown = None if values is None else factor * values
        actors.append(Actor(skin_of(part.mesh), part_positions(part.subdomain, motion), shown))
    if all(actor.values is None for actor in actors):
        return None
    seen = np.concatenate([actor.positions.reshape(-1, 3) for actor in actors])
    if OBSTACLES in solution.bodies:
        moved = series_of(solution, OBSTACLES)[chosen]
        for number, contact in enumerate(system.rigid_contacts):
            offsets = moved[:, 6 * number : 6 * number + 3]
            actors.append(obstacle_actor(contact.obstacle, offsets, seen))
    scene = scene_of(actors)
    return animate(
        path,
        solution.times[chosen],
        scene.positions,
        scene.skin,
        values=scene.values,
        values_label=label,
        frames_per_second=FRAMES_PER_SECOND,
        units=units,
        progress=progress,
    )
