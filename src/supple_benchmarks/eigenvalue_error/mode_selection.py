"""Rules for choosing fixed-interface modes, compared on one body at equal numbers of coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from supple.algebra import GrowingModes
from supple.body import FlexibleBody, MeanAxisFrame
from supple.errors import ModelError
from supple.reduction import (
    CouplingMoment,
    EffectiveInterfaceMass,
    FixedInterfaceComponent,
    RitzComponent,
    craig_bampton_component,
    fixed_interface_component,
    residual_component,
)
from supple.reduction.bases.interface_columns import motion_rows, require_interfaces
from supple.reduction.bases.mode_selection import best_first
from supple.viz import plot_error_over_parameter
from supple_benchmarks.table import Row

# A vibration with a smaller fraction of its kinetic energy at the interfaces counts as invisible there.
VISIBLE = 1e-6


@dataclass(frozen=True)
class SelectionQuality:
    """Accuracy at the interfaces of a Craig-Bampton body with selected modes, compared with the full body.

    selection : name of the rule
    size : number of modes and residual modes, besides the constraint modes
    transfer_error : root mean square, over frequency, of |H - H_full| / |H_full|, H the receptance
    eigenvalue_error : largest relative error of the free body's modes that are visible at the interfaces;
                       infinite when the reduced body has too few of them
    """

    selection: str
    size: int
    transfer_error: float
    eigenvalue_error: float

    def as_row(self) -> Row:
        """A row of a report."""
        finite = np.isfinite(self.eigenvalue_error)
        return {
            "selection": self.selection,
            "size": self.size,
            "transfer_error": self.transfer_error,
            "eigenvalue_error": self.eigenvalue_error if finite else None,
        }


def compare_selections(
    body: FlexibleBody,
    sizes: Sequence[int],
    *,
    n_vibrations: int = 12,
    candidates: int = 150,
    loss_factor: float = 0.02,
    n_frequencies: int = 200,
) -> tuple[SelectionQuality, ...]:
    """Quality of each selection rule for growing bases, measured by the receptance

        H(omega) = B ((1 + i eta) K - omega^2 M)^-1 B^T

    at logarithmic steps from a third of the first frequency of the free body to the frequency of the last
    mode compared. Forces and moments, displacements and rotations are weighted by the interface mass. Modes
    without motion at the interfaces are not compared: a rule based on the interfaces omits them on purpose,
    and no force at an interface excites them. The last rule replaces the highest of the lowest modes by
    residual modes, six for each interface.

    sizes : numbers of modes, besides the constraint modes
    n_vibrations : number of modes of the free body, the lowest that are visible at its interfaces
    candidates : number of fixed-interface modes to select from; H_full is that of all candidates with the
        residual modes of the omitted ones
    loss_factor : eta
    Raises ModelError when a size exceeds the candidates, or the body has no interface.
    """
    require_interfaces(body, "a comparison of mode selections")
    if not 0 <= min(sizes) <= max(sizes) <= candidates:
        raise ModelError(f"sizes {list(sizes)} for {candidates} candidates; give sizes between 0 and those")
    clamped = GrowingModes(body.constrained(motion_rows(body.interfaces)), body.mass)
    component = fixed_interface_component(body, clamped.at_least(candidates)).leading(candidates)
    exact = _visible_values(body, component, n_vibrations)
    reference = _interface_modes(residual_component(component), component)
    omega = np.sqrt(exact[-1]) * np.geomspace(np.sqrt(exact[0] / exact[-1]) / 3.0, 1.0, n_frequencies)
    squares = omega**2 / (1.0 + 1j * loss_factor)
    full = reference.receptance(squares)
    qualities = []
    for name, size, model in _models(body, component, sizes):
        modes = _interface_modes(model, component)
        difference = np.linalg.norm(modes.receptance(squares) - full, axis=(1, 2))
        relative = difference / np.linalg.norm(full, axis=(1, 2))
        error = _largest_error(modes, exact)
        qualities.append(SelectionQuality(name, size, float(np.sqrt(np.mean(relative**2))), error))
    return tuple(qualities)


def draw_transfer_errors(path: Path | str, qualities: Sequence[SelectionQuality]) -> Path:
    """Transfer error over the size of the basis, one curve for each rule; returns the path."""
    sizes = sorted({quality.size for quality in qualities})
    errors: dict[str, np.ndarray] = {}
    for quality in qualities:
        values = errors.setdefault(quality.selection, np.full(len(sizes), np.nan))
        values[sizes.index(quality.size)] = 100.0 * quality.transfer_error
    return plot_error_over_parameter(
        path, np.array(sizes), errors, parameter_label="modes kept", error_label="transfer error (%)"
    )


class _InterfaceModes(NamedTuple):
    """Vibrations at the interfaces, in coordinates of unit interface mass."""

    values: np.ndarray
    motion: np.ndarray

    def receptance(self, squares: np.ndarray) -> np.ndarray:
        """H (f, b, b) at complex squares of frequencies (f,)."""
        weights = 1.0 / (self.values - squares[:, None])
        return (self.motion * weights[:, None, :]) @ self.motion.T

    def visible(self) -> np.ndarray:
        """Eigenvalues of the elastic vibrations visible at the interfaces, ascending."""
        elastic = slice(6, None)
        return self.values[elastic][np.sum(self.motion[:, elastic] ** 2, axis=0) > VISIBLE]


def _models(
    body: FlexibleBody, component: FixedInterfaceComponent, sizes: Sequence[int]
) -> list[tuple[str, int, RitzComponent]]:
    m, b = component.n_modes, len(component.interface_mass)
    orders = {
        "lowest frequency": np.arange(m),
        "effective interface mass": best_first(EffectiveInterfaceMass(m).scores(body, component)),
        "coupling moment": best_first(CouplingMoment(m).scores(body, component)),
    }
    models = [
        (name, size, craig_bampton_component(component.keeping(np.sort(order[:size]))))
        for name, order in orders.items()
        for size in sizes
    ]
    return models + [
        ("lowest frequency, residual modes", size, residual_component(component.leading(size - b)))
        for size in sizes
        if size >= b
    ]


def _interface_modes(model: RitzComponent, component: FixedInterfaceComponent) -> _InterfaceModes:
    values, vectors = model.interfaces_free().modes()
    motion = model.interface_motion @ vectors
    return _InterfaceModes(values, np.linalg.cholesky(component.interface_mass).T @ motion)


def _visible_values(body: FlexibleBody, component: FixedInterfaceComponent, n_values: int) -> np.ndarray:
    """Exact eigenvalues of the vibrations of the free body that are visible at the interfaces."""
    free = GrowingModes(body.constrained(MeanAxisFrame().constraint(body)), body.mass)
    triangle, B = np.linalg.cholesky(component.interface_mass).T, motion_rows(body.interfaces)
    n_modes = min(2 * n_values, free.available)
    while True:
        modes = free.at_least(n_modes)
        shown = np.sum((triangle @ modes.participation(B.T).T) ** 2, axis=0) > VISIBLE
        if np.sum(shown) >= n_values:
            return modes.values[shown][:n_values]
        if n_modes == free.available:
            raise ModelError(f"only {np.sum(shown)} vibrations of body '{body.name}' show at its interfaces")
        n_modes = min(2 * n_modes, free.available)


def _largest_error(modes: _InterfaceModes, exact: np.ndarray) -> float:
    found = modes.visible()
    if found.size < exact.size:
        return np.inf
    return float(np.max(np.abs(found[: exact.size] / exact - 1.0)))
