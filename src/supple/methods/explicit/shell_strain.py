"""Check whether plastic strain in explicit shells, which are of small strain, is large at an output time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray
from supple.integrate import Solution, Validity
from supple.machine import System
from supple.methods.explicit.explicit_shell import ExplicitShell
from supple.methods.explicit.motions import NodalMotion
from supple.methods.explicit.peak_watch import Peak, PeakWatch

LARGEST = 0.2
"""Largest plastic strain. At it, engineering strain and logarithmic strain differ by 10 %."""


@dataclass(frozen=True, eq=False)
class ShellStrainWatch(PeakWatch):
    """The shells of a system that yield, and their plastic strains."""

    shells: tuple[ExplicitShell, ...]

    def values(self, leg: Solution) -> Iterator[tuple[str, FloatArray]]:
        """Plastic strains (t, cells) of each shell."""
        for shell in self.shells:
            yield shell.name, leg.motion(shell.name, NodalMotion).plastic_strain

    def excesses(self, found: Mapping[str, Peak]) -> list[str]:
        """A message for every shell of large strain."""
        return [
            _is_large(shell, *found[shell.name]) for shell in self.shells if found[shell.name][0] > LARGEST
        ]


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
