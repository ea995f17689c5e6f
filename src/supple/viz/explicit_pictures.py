"""The pictures of an explicit run: its energies, what is tracked, and films in stress and plastic strain."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.integrate import Solution
from supple.machine import System
from supple.methods.explicit import (
    ENERGIES,
    OBSTACLES,
    Energies,
    ExplicitShell,
    ExplicitSubdomain,
    ModalSubdomain,
)
from supple.methods.explicit.modal_stress import isotropic_materials
from supple.results import without_noise
from supple.results.explicit_fields import element_means, nodal_von_mises
from supple.units import UNNAMED, UnitSystem, labelled
from supple.viz.animation import animate
from supple.viz.contact_clearance import clear_of_contact
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


def _stress(subdomain: Any, motion: Any) -> FloatArray:
    """Without what round-off leaves in a body that flies undeformed: strains of 1e-9."""
    model = subdomain.body.model if isinstance(subdomain, ModalSubdomain) else subdomain.model
    assert model is not None  # of which the stress is
    moduli = [material.youngs_modulus for material in isotropic_materials(model)]
    return without_noise(nodal_von_mises(subdomain, motion), like=moduli)


def _plastic_strain(subdomain: Any, motion: Any) -> FloatArray | None:
    yields = isinstance(subdomain, ExplicitShell) and subdomain.law is not None
    if not yields and not isinstance(subdomain, ExplicitSubdomain):
        return None
    return element_means(subdomain, motion.plastic_strain, motion.alive)


COLOURINGS: Mapping[str, Colouring] = MappingProxyType(
    {
        "von-mises": Colouring(_stress, _stress_label),
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
    """Draw `energies.png`, every term of the balance, and in `tracked-motion.png` the way of places.

    tracked : positions (t, 3) by name
    """
    times = solution.times
    energies = without_noise(solution.series[ENERGIES])
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
        all_of = np.concatenate(list(tracked.values()))
        moved = {name: without_noise(place - place[0], like=all_of) for name, place in tracked.items()}
        panels = [
            Panel(
                labelled(f"{axis}, global, from the start", units.length),
                [Series(as_written(name), times, motion[:, i]) for name, motion in moved.items()],
            )
            for i, axis in enumerate("xyz")
        ]
        pictures.append(plot_time_history(folder / "tracked-motion.png", panels, units=units))
    return pictures


def animate_explicit(
    path: Path,
    system: System,
    solution: Solution,
    colouring: Colouring,
    *,
    units: UnitSystem = UNNAMED,
    progress: Callable[[float], None] | None = None,
) -> Path | None:
    """Animate the parts and the obstacles; None where no part has what the film is to be coloured by."""
    chosen = np.unique(np.linspace(0, len(solution.times) - 1, N_FRAMES).astype(int))
    label, factor = colouring.label(units)
    parts = {placed.body.name: placed.body for placed in system.bodies}
    motions: dict[str, Any] = {name: solution.bodies[name].at(chosen) for name in parts}
    values = {name: colouring.values(part, motions[name]) for name, part in parts.items()}
    if all(own is None for own in values.values()):
        return None
    positions = {name: part.positions(motions[name]) for name, part in parts.items()}
    obstacles = system.rigid_contacts
    moved = solution.series[OBSTACLES][chosen] if obstacles else np.zeros((len(chosen), 0))
    offsets = moved.reshape(len(chosen), -1, 6)[:, :, :3]
    positions = clear_of_contact(system, positions, offsets)
    actors = [
        Actor(skin_of(system.mesh_of(name)), positions[name], None if own is None else factor * own)
        for name, part in parts.items()
        for own in [values[name]]
    ]
    seen = np.concatenate([actor.positions.reshape(-1, 3) for actor in actors])
    actors += [
        obstacle_actor(contact.obstacle, offsets[:, number], seen) for number, contact in enumerate(obstacles)
    ]
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
