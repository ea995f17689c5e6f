"""Craig-Bampton reductions of one flexible body, with any number of fixed-interface modes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from supple.algebra import GrowingModes, RitzModes
from supple.body import FlexibleBody
from supple.reduction.bases.guyan import interface_shapes
from supple.reduction.bases.interface_columns import motion_rows, require_interfaces
from supple.reduction.components.deflation import residual_response
from supple.reduction.components.fixed_interface_component import (
    FixedInterfaceComponent,
    fixed_interface_component,
)
from supple.reduction.components.free_vibration import FreeVibrations, free_vibrations
from supple.reduction.eigenvalues.eigenvalue_error import EigenvalueErrorEstimator, error_terms

__all__ = ["CraigBamptonFamily"]

N_RIGID = 6

# If more modes are needed, their number grows at least by this factor; few eigensolutions then suffice.
GROWTH = 1.1


class CraigBamptonFamily:
    """Craig-Bampton reductions with 0, 1, 2 ... fixed-interface modes, which are computed when needed.

    body : FlexibleBody      ModelError if it has no interface
    """

    def __init__(self, body: FlexibleBody):
        require_interfaces(body, "a Craig-Bampton body")
        clamped = motion_rows(body.independent_interfaces)
        self.body = body
        self.shapes = interface_shapes(body)
        self.rigid_motion = clamped @ body.rigid_modes
        self.growing = GrowingModes(body.constrained(clamped), body.mass)
        self.modes: RitzModes = self.growing.found
        self.component: FixedInterfaceComponent = fixed_interface_component(body, self.modes)

    @property
    def n_available(self) -> int:
        """Number of fixed-interface modes of the body."""
        return self.growing.available

    @property
    def n_vibrations(self) -> int:
        """Number of elastic vibrations of the full free body."""
        return self.body.n - N_RIGID

    def vibrations(self, n_kept: int, n_vibrations: int) -> FreeVibrations:
        """The n_vibrations lowest elastic vibrations of the free reduced body with n_kept modes.

        If it has fewer, all of them.
        """
        self._know(max(n_kept, min(n_vibrations, self.n_available)))
        return free_vibrations(self.component.leading(n_kept), self.rigid_motion, n_vibrations)

    def errors(self, n_kept: int, n_vibrations: int, estimator: EigenvalueErrorEstimator) -> np.ndarray:
        """Estimated eigenvalue errors (n_vibrations,); infinite for vibrations not in the reduced body."""
        vibrations = self.vibrations(n_kept, n_vibrations)
        errors = np.full(n_vibrations, np.inf)
        errors[: vibrations.values.size] = estimator.errors(error_terms(self.component, vibrations))
        return errors

    def vectors(self, vibrations: FreeVibrations) -> np.ndarray:
        """N vibrations as M-orthonormal columns (n, N) on the coordinates of the flexible body."""
        amounts = np.zeros((self.modes.values.size, vibrations.values.size))
        amounts[: len(vibrations.modal)] = vibrations.modal
        return self.shapes @ vibrations.interfaces + self.modes.combine(amounts)

    def make_room(self) -> None:
        """Release the memory of the factor of K, and of the Krylov space except for the modes found."""
        self.body.grounded_stiffness.factor.release()
        self.growing.keep_modes_only()
        self.modes = self.growing.found

    def _know(self, n_kept: int) -> None:
        """Compute at least n_kept + 1 modes, and the residual response of all others.

        The eigenvalue of mode n_kept + 1 is a lower bound for those of the modes that are not kept.
        """
        known, needed = self.modes.values.size, min(n_kept + 1, self.n_available)
        if needed <= known:
            return
        self.modes = self.growing.at_least(min(max(needed, int(GROWTH * known)), self.n_available))
        inertia = self.body.mass @ self.shapes
        residual = residual_response(self.growing.inverse, self.body.mass, self.modes, inertia)
        self.component = replace(
            self.component,
            eigenvalues=self.modes.values,
            participation=self.modes.participation(inertia),
            residual_flexibility=residual.flexibility,
            residual_mass=residual.mass,
        )
