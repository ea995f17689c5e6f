"""Support structures for OpenFAST: the reduction file of ExtPtfm (FLEX's text format).

ExtPtfm joins a superelement at one point, the platform's reference point. All other interfaces are clamped,
or stand on springs to the ground, such as those of the soil.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy import linalg

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.export.ascii_file import write_ascii
from supple.export.superelements.interface_form import InterfaceForm
from supple.export.superelements.stated_frequencies import N_RIGID, N_STATED, frequencies

__all__ = ["extptfm_frequencies", "write_extptfm"]

Springs = Mapping[str, tuple[FloatArray, FloatArray]]

_LAST_TIME = 1e5
"""Last time of the constant loads, s."""
_LONGEST_LINE = 4096
"""Number of characters of a line of loads that ExtPtfm reads."""


def write_extptfm(
    path: Path | str,
    form: InterfaceForm,
    interface: str,
    *,
    gravity: ArrayLike = (0.0, 0.0, 0.0),
    springs: Springs | None = None,
) -> Path:
    """Write mass, stiffness, damping and weight of a body for ExtPtfm; returns the path.

    Interfaces other than `interface` and those on springs are clamped. Set FileFormat = 1 in the ExtPtfm
    input (0 is for Guyan reduction). OpenFAST needs SI units, and z upwards.

    Parameters
    ----------
    interface : interface that is joined to the tower
    gravity : (3,) in mesh axes, m/s^2; the constant loads are the weight of the undeformed body
    springs : stiffness and damping (6, 6) of springs to the ground, by interface; in mesh axes, translations
        first

    Raises
    ------
    ModelError          an unknown interface; more coordinates than ExtPtfm reads from a line of loads
    ResultFileError     the file cannot be written
    """
    matrices, columns = _supported(form, interface, springs or {})
    words, stated = extptfm_frequencies(form, interface, springs or {})
    listed = ", ".join(f"{value:.6g}" for value in stated)
    n = columns.shape[1]
    lines = [f"!{line}" for line in form.comment()]
    lines += [
        f"!Flex 5 format; {words}: {listed} cycles per unit of time",
        f"!Dimension: {n}",
        f"!Time increment in simulation: {_LAST_TIME:g}",
        f"!Total simulation time in file: {_LAST_TIME:g}",
    ]
    for name, matrix in matrices.items():
        lines += ["", f"!{name} Matrix", f"!Dimension: {n}", *_rows(matrix)]
    fall = np.zeros(len(form.mass))
    fall[: form.n_boundary] = np.tile(
        [*np.asarray(gravity, dtype=float), 0.0, 0.0, 0.0], len(form.interfaces)
    )
    weight = columns.T @ form.mass @ fall
    lines += ["", "!Loading and Wave Elevation", f"!Dimension: 1 time column -  {n} force columns"]
    lines += _rows(np.column_stack([[0.0, _LAST_TIME], np.tile(weight, (2, 1))]), digits=10)
    if len(lines[-1]) > _LONGEST_LINE:
        raise ModelError(
            f"body '{form.name}': ExtPtfm reads {_LONGEST_LINE} characters of a line of loads, and that "
            f"of {n} coordinates has {len(lines[-1])}: keep fewer modes"
        )
    return write_ascii(path, lines)


def extptfm_frequencies(form: InterfaceForm, interface: str, springs: Springs) -> tuple[str, FloatArray]:
    """Words for the support of the body in ExtPtfm, and its lowest frequencies, cycles per unit of time."""
    matrices, _ = _supported(form, interface, springs)
    # A body that only ExtPtfm supports has six zero frequencies.
    rigid = 0 if springs or len(form.interfaces) > 1 else N_RIGID
    found = frequencies(matrices["Stiffness"], matrices["Mass"])[rigid:][:N_STATED]
    standing = f"{', '.join(springs)} on springs, " if springs else ""
    return f"at {interface}, {standing}all other interfaces clamped", found


def _supported(
    form: InterfaceForm, interface: str, springs: Springs
) -> tuple[dict[str, FloatArray], FloatArray]:
    """Matrices by name in Craig-Bampton form with `interface`, and their coordinates (6 n + m, k)."""
    stiffness, damping = form.stiffness.copy(), form.damping.copy()
    kept = [form.rows(name) for name in (interface, *springs)]
    for own, (k, c) in zip(kept[1:], springs.values(), strict=True):
        stiffness[np.ix_(own, own)] += k
        damping[np.ix_(own, own)] += c
    inner = np.concatenate([*kept[1:], np.arange(form.n_boundary, len(form.mass))])
    columns = np.zeros((len(form.mass), 6 + len(inner)))
    columns[kept[0], :6] = np.eye(6)
    columns[inner, 6:] = np.eye(len(inner))
    if springs:
        own, to_interface = stiffness[np.ix_(inner, inner)], stiffness[np.ix_(inner, kept[0])]
        columns[inner, :6] = -np.linalg.solve(own, to_interface)
        columns[inner, 6:] = linalg.eigh(own, form.mass[np.ix_(inner, inner)])[1]
    all_of = {"Mass": form.mass, "Stiffness": stiffness, "Damping": damping}
    return {name: columns.T @ matrix @ columns for name, matrix in all_of.items()}, columns


def _rows(matrix: FloatArray, digits: int = 16) -> list[str]:
    return [" ".join(f"{value: .{digits}e}" for value in row) for row in matrix]
