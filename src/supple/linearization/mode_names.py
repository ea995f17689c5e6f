"""Names of modes by their motion: flap, edge and torsion of blades, whirl of rotors."""

from __future__ import annotations

from collections import Counter

import numpy as np

from supple.linearization.linear_machine import Array
from supple.linearization.machine_modes import MachineModes
from supple.linearization.whirl import whirl
from supple.machine import Spin

__all__ = ["mode_names"]

AWAY = 0.25
"""Ratio of the distance of the nodes' mean position from the axis to their largest radius, above which a body
is a blade, not a rotor."""
ON_AXIS = 1e-3
"""Ratio of the largest radius to the size of a body up to which it is a shaft of beams, not a blade:
unbalance moves it off the axis."""
SECTIONS = 12
"""Number of sections of a blade; motion relative to the mean of its section is torsion."""
TRANSLATING = 0.25
"""Share of the kinetic energy in the translation of the nodes, below which the motion is torsion: nodes of
beams and of lines do not translate in torsion."""


def mode_names(modes: MachineModes) -> tuple[str, ...]:
    """A name for each mode, numbered among equal names, such as "flap 1", "forward whirl 1", "tower 2".

    For rotating blades: flap along the spin axis, edge around it, stretch along the blade, torsion.
    """
    shares, senses = modes.kinetic_shares, whirl(modes).sense
    counted: Counter[str] = Counter()
    names = []
    for number in range(len(modes.eigenvalues)):
        name = _kind(modes, number, int(np.argmax(shares[:, number])), int(senses[number]))
        counted[name] += 1
        names.append(f"{name} {counted[name]}")
    return tuple(names)


def _kind(modes: MachineModes, number: int, body: int, sense: int) -> str:
    spin, placed = modes.machine.spin, modes.machine.system.bodies[body]
    if not modes.kinetic_shares[:, number].any():
        return "controller"
    name = placed.body.name
    if spin is None or (spin.bodies is not None and name not in spin.bodies):
        return name
    arms = placed.positions() - spin.point
    radii = arms - np.outer(arms @ spin.axis, spin.axis)  # (N, 3), of all nodes from the axis
    largest = float(np.linalg.norm(radii, axis=1).max(initial=0.0))
    on_axis = largest <= ON_AXIS * np.ptp(placed.positions(), axis=0).max(initial=0.0)
    if not on_axis and np.linalg.norm(radii.mean(axis=0)) > AWAY * largest > 0:
        return _of_blade(modes, number, body, spin, radii)
    return {1: "forward whirl", -1: "backward whirl"}.get(sense, name)


def _of_blade(modes: MachineModes, number: int, body: int, spin: Spin, radii: Array) -> str:
    """Name of the motion with the largest part of the sum of squares over the nodes, by sections."""
    along = radii.mean(axis=0) / np.linalg.norm(radii.mean(axis=0))
    placed, own = modes.machine.system.bodies[body], modes.machine.slices[body]
    shape = modes.shapes[:, number]
    motion = modes.machine.moving_at(np.array([shape.real, shape.imag])).bodies[placed.body.name]
    real, imaginary = placed.body.node_motion(motion, np.arange(len(placed.body.nodes))).velocity
    moved = real + 1j * imaginary  # (N, 3), of all nodes in space
    places = radii @ along
    edges = np.linspace(places.min(), places.max(), SECTIONS + 1)[1:-1]
    sections = np.searchsorted(edges, places)
    sizes = np.bincount(sections, minlength=SECTIONS)
    sums = np.zeros((SECTIONS, 3), dtype=complex)
    np.add.at(sums, sections, moved)
    means = sums / np.maximum(sizes, 1)[:, None]
    directions = {"flap": spin.axis, "edge": np.cross(spin.axis, along), "stretch": along}
    squares = {name: float(sizes @ abs(means @ axis) ** 2) for name, axis in directions.items()}
    squares["torsion"] = float(np.sum(abs(moved - means[sections]) ** 2))
    energy = np.real(shape[own].conj() @ (modes.machine.full_mass @ shape)[own])  # twice the kinetic energy
    if placed.body.mass * np.mean(np.sum(abs(moved) ** 2, axis=1)) < TRANSLATING * energy:
        return "torsion"
    return max(squares, key=lambda name: squares[name])
