"""Check whether plastic strain in explicit shells, which are of small strain, is large at an output time."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from supple.errors import ValidityError, ValidityWarning
from supple.integrate import Solution, Validity
from supple.machine import System
from supple.methods.explicit.explicit_shell import ExplicitShell
from supple.methods.explicit.motions import NodalMotion

__all__ = ["ShellStrainWatch", "shell_strain_watch"]

LARGEST = 0.2
"""Largest plastic strain. At it, engineering strain and logarithmic strain differ by 10 %."""
Strained = tuple[float, float, int]
"""Largest plastic strain of a shell, its time, and the number of the cell."""


@dataclass(frozen=True, eq=False)
class ShellStrainWatch:
    """The shells of a system that yield."""

    validity: Validity
    shells: tuple[ExplicitShell, ...]

    def observe(self, so_far: Mapping[str, Strained], leg: Solution) -> dict[str, Strained]:
        """Largest strains, updated by those of a leg; ValidityError at the first large one if strict."""
        merged = {}
        for shell in self.shells:
            strains = leg.motion(shell.name, NodalMotion).plastic_strain
            row, cell = np.unravel_index(strains.argmax(), strains.shape)
            found = float(strains[row, cell]), float(leg.times[row]), int(cell)
            merged[shell.name] = max(so_far.get(shell.name, found), found)
        if self.validity.strict:
            for message in self.excesses(merged):
                raise ValidityError(message)
        return merged

    def excesses(self, peaks: Mapping[str, Strained]) -> list[str]:
        """A message for every shell of large strain."""
        return [
            _is_large(shell, *peaks[shell.name]) for shell in self.shells if peaks[shell.name][0] > LARGEST
        ]

    def report(self, peaks: Mapping[str, Strained]) -> None:
        """Warn about every shell of large strain."""
        for message in self.excesses(peaks):
            warnings.warn(message, ValidityWarning, stacklevel=3)


def shell_strain_watch(system: System, validity: Validity) -> ShellStrainWatch:
    """Prepare the shells of a system."""
    shells = system.bodies_of(ExplicitShell).values()
    return ShellStrainWatch(validity, tuple(shell for shell in shells if shell.law is not None))


def _is_large(shell: ExplicitShell, strain: float, time: float, cell: int) -> str:
    mesh, sections = shell.mesh, shell.model.sections
    ids = np.concatenate([mesh.cell_ids[own.cell_type][own.cells] for own in sections])
    return (
        f"shell '{shell.name}' reaches a plastic strain of {strain:.3g} in cell {ids[cell]} "
        f"(t = {time:.4g}). Explicit shells are of small strain: above {LARGEST:g} their strain is wrong by "
        "more than 10 %, they do not become thinner, and cells can collapse, which shortens the steps. Use "
        "solids in that region, or a smaller deletion strain"
    )
