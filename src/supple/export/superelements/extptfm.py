"""Support structures for OpenFAST: the reduction file of ExtPtfm (FLEX's text format).

ExtPtfm joins a superelement at one point, the platform's reference point; all other interfaces are clamped.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.errors import ModelError, did_you_mean
from supple.export.ascii_file import write_ascii
from supple.export.superelements.interface_form import InterfaceForm

__all__ = ["write_extptfm"]

_LAST_TIME = 1e5
"""Last time of the constant loads, s."""


def write_extptfm(
    path: Path | str, form: InterfaceForm, interface: str, *, gravity: ArrayLike = (0.0, 0.0, 0.0)
) -> Path:
    """Write mass, stiffness, damping and weight of a body for ExtPtfm; returns the path.

    All interfaces but one are clamped. Set FileFormat = 1 in the ExtPtfm input (0 is for Guyan reduction).
    OpenFAST needs SI units, and z upwards.

    Parameters
    ----------
    interface : interface that is joined to the tower
    gravity : (3,) in mesh axes, m/s^2; the constant loads are the weight of the undeformed body

    Raises
    ------
    ModelError          an unknown interface
    ResultFileError     the file cannot be written
    """
    if interface not in form.interfaces:
        near = did_you_mean(interface, form.interfaces)
        raise ModelError(
            f"body '{form.name}' has no interface '{interface}'{near}; it has: {', '.join(form.interfaces)}"
        )
    first, n = 6 * form.interfaces.index(interface), form.n_boundary
    kept = np.r_[first : first + 6, n : n + form.n_modal]
    lines = [f"!{line}" for line in form.comment()]
    lines.append(f"!Flex 5 format; at {interface}, all other interfaces clamped: {_stated(form, interface)}")
    lines += [
        f"!Dimension: {len(kept)}",
        f"!Time increment in simulation: {_LAST_TIME:g}",
        f"!Total simulation time in file: {_LAST_TIME:g}",
    ]
    for name in ("Mass", "Stiffness", "Damping"):
        matrix = getattr(form, name.lower())[np.ix_(kept, kept)]
        lines += ["", f"!{name} Matrix", f"!Dimension: {len(kept)}", *_rows(matrix)]
    weight = (form.mass @ _translations(form) @ np.asarray(gravity, dtype=float))[kept]
    lines += ["", "!Loading and Wave Elevation", f"!Dimension: 1 time column -  {len(kept)} force columns"]
    lines += _rows(np.column_stack([[0.0, _LAST_TIME], np.tile(weight, (2, 1))]))
    return write_ascii(path, lines)


def _stated(form: InterfaceForm, interface: str) -> str:
    others = [name for name in form.interfaces if name != interface]
    return ", ".join(f"{value:.6g}" for value in form.frequencies(others)[:6]) + " cycles per unit of time"


def _translations(form: InterfaceForm) -> NDArray[np.float64]:
    """Motion (6 n + m, 3) of all degrees of freedom with unit rigid translations."""
    motion = np.zeros((len(form.mass), 3))
    motion[: form.n_boundary] = np.tile(np.eye(6)[:, :3], (len(form.interfaces), 1))
    return motion


def _rows(matrix: NDArray[np.float64]) -> list[str]:
    return [" ".join(f"{value:24.16e}" for value in row) for row in matrix]
