"""Superelements for Abaqus: `*MATRIX INPUT` and `*MATRIX ASSEMBLE`, on nodes at the interfaces."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from supple.export.ascii_file import write_ascii
from supple.export.superelements.interface_form import InterfaceForm

__all__ = ["write_abaqus_superelement"]


def write_abaqus_superelement(path: Path | str, form: InterfaceForm) -> Path:
    """Write nodes and matrices, to be included (`*INCLUDE`) before the steps; returns the path.

    Nodes 1 to n are the interfaces with six degrees of freedom; each further node has a modal coordinate as
    degree of freedom 1.

    Raises ResultFileError: the file cannot be written.
    """
    matrices = form.matrices("STIFFNESS", "MASS", "VISCOUS DAMPING")
    n, labels = len(form.interfaces), form.freedoms(of_modal=1)
    places = np.concatenate([form.positions, np.tile(form.positions[:1], (form.n_modal, 1))])
    lines = [f"** {line}" for line in form.comment()]
    lines += [f"** nodes 1 to {n}: interfaces; the others have modal coordinates as DOF 1", "*NODE"]
    lines += [f"{number}, {x:.16e}, {y:.16e}, {z:.16e}" for number, (x, y, z) in enumerate(places, 1)]
    for role, matrix in matrices.items():
        lines.append(f"*MATRIX INPUT, NAME=SUPPLE_{role.split()[-1]}, TYPE=SYMMETRIC")
        rows, columns = np.nonzero(np.tril(matrix))
        lines += [
            f"{labels[i, 0]}, {labels[i, 1]}, {labels[j, 0]}, {labels[j, 1]}, {matrix[i, j]:.16e}"
            for i, j in zip(rows, columns, strict=True)
        ]
    named = ", ".join(f"{role}=SUPPLE_{role.split()[-1]}" for role in matrices)
    return write_ascii(path, [*lines, f"*MATRIX ASSEMBLE, {named}"])
