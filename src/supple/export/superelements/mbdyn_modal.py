"""Bodies for MBDyn: the `.fem` file of its modal joint, with modes and inertia invariants.

MBDyn's modal joint is a linear body in a floating frame. Its invariants are integrals that are contained in
the body's Gram matrix G. With x~ the cross matrices of the points and phi_j~ those of the modes,

    3: int phi_j    4: int x x phi_j    5: int phi_i x phi_j    8: - int x~ phi_j~    9: int phi_i~ phi_j~

Therefore the file needs no nodal masses, and its only nodes are the interfaces.

Source: MBDyn's input manual, "Modal".
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.export.ascii_file import write_ascii
from supple.export.superelements.stated_frequencies import floating_frequencies, frequency_lines
from supple.reduction import ReducedBody

__all__ = ["write_mbdyn"]


def write_mbdyn(path: Path | str, body: ReducedBody) -> Path:
    """Write the linear part of a reduced body for MBDyn's modal joint; returns the path.

    Nodes 1 to n are the interfaces; the frame is that of the mesh. Set the joint's damping to `from file`.

    Raises ModelError for a body without interfaces; ResultFileError: the file cannot be written.
    """
    if not body.interfaces:
        raise ModelError(
            f"body '{body.name}' has no interface, and MBDyn joins bodies at interfaces; give it one"
        )
    r, n = body.r, len(body.interfaces)
    places = np.array([interface.position for interface in body.interfaces])
    shapes = np.array([interface.motion for interface in body.interfaces])
    lines = [f"** {line}" for line in (body.name, *frequency_lines(floating_frequencies(body)))]
    lines += _group(1, "HEADER", ["**   REVISION  NODE  NORMAL  ATTACHMENT  CONSTRAINT  REJECTED MODES"])
    lines += [f"REV0 {n} {r} 0 0 0", *_group(2, "FINITE ELEMENT NODE LIST", _rows([np.arange(1, n + 1)]))]
    lines += _group(3, "INITIAL MODAL DISPLACEMENTS", _rows(np.zeros((1, r))))
    lines += _group(4, "INITIAL MODAL VELOCITIES", _rows(np.zeros((1, r))))
    for group, axis in enumerate("XYZ", 5):
        lines += _group(group, f"NODAL {axis} COORDINATES", _rows(places[:, group - 5, None]))
    lines += _group(8, "MODE SHAPES", [])
    for mode in range(r):
        lines += [f"**    NORMAL MODE SHAPE # {mode + 1}", *_rows(shapes[:, :, mode])]
    own = slice(6 + 3 * r, None)
    lines += _group(9, "MODAL MASS MATRIX", _rows(body.gram[own, own]))
    lines += _group(10, "MODAL STIFFNESS MATRIX", _rows(body.stiffness))
    inertia = [np.array([body.mass]), body.centre_of_mass, *_about_centre(body)]
    lines += _group(12, "RIGID BODY INERTIA MATRIX", _rows(inertia))
    lines += _group(13, "MODAL DAMPING MATRIX", _rows(body.damping))
    for group, (number, values) in enumerate(invariants(body).items(), 14):
        lines += _group(group, f"INVARIANT {number}", _rows(values.reshape(3, -1)))
    return write_ascii(path, [*lines, "**"])


def invariants(body: ReducedBody) -> dict[int, FloatArray]:
    """Invariants 3, 4 (3, r), 8 (3, r, 3), 5 (3, r, r) and 9 (3, r, r, 3) by number, in the file's order."""
    r, gram = body.r, body.gram
    t, w, v = slice(0, 3), slice(3, 6), slice(6 + 3 * r, None)
    turned = gram[6 : 6 + 3 * r].reshape(r, 3, -1)
    among = turned[:, :, 6 : 6 + 3 * r].reshape(r, 3, r, 3)
    rates = turned[:, :, v]
    crossed = (rates - rates.transpose(2, 1, 0)) / 2  # antisymmetric for point masses
    return {
        3: gram[t, v],
        4: gram[w, v],
        8: gram[w, 6 : 6 + 3 * r].reshape(3, r, 3),
        5: crossed.transpose(1, 0, 2),
        9: -among.transpose(1, 0, 2, 3),
    }


def _about_centre(body: ReducedBody) -> FloatArray:
    x = body.centre_of_mass
    return body.gram[3:6, 3:6] - body.mass * (x @ x * np.eye(3) - np.outer(x, x))


def _group(number: int, words: str, rows: list[str]) -> list[str]:
    return ["**", f"** RECORD GROUP {number}, {words}", *rows]


def _rows(values: ArrayLike | list[FloatArray]) -> list[str]:
    """One line per row; integers without a decimal point, other numbers with 17 digits."""
    return [
        " ".join(str(x) if isinstance(x, np.integer) else f"{x:.16e}" for x in np.atleast_1d(row))
        for row in values  # ty: ignore[not-iterable]
    ]
