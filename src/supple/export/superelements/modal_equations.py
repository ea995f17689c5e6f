"""Superelements for CalculiX: masses and springs of the free modes, tied to the interfaces by equations.

CalculiX reads no matrices. Masses, springs and equations represent the superelement instead. With the modes
of the free body, `u = B z`, each modal coordinate z has mass 1 and stiffness omega^2. The interface motion u
is independent. Some modal coordinates z_d, one for each component of u, depend on u and on the other modal
coordinates z_f (`*EQUATION`):

    B_d z_d = u - B_f z_f

Any program with point masses, grounded springs and linear equations can use this form.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from supple.arrays import FloatArray
from supple.export.ascii_file import write_ascii
from supple.export.superelements.interface_form import InterfaceForm
from supple.export.superelements.stated_frequencies import N_RIGID

__all__ = ["write_calculix_superelement"]


_TERMS_PER_LINE = 4


def write_calculix_superelement(path: Path | str, form: InterfaceForm) -> Path:
    """Write nodes, masses, springs and equations, to be included (`*INCLUDE`) before steps; returns the path.

    For interface i, node 2 i - 1 has the translations and node 2 i the rotations, as components 1 to 3. Use
    them as reference node and rotation node of a `*RIGID BODY` of your own mesh. Node sets are named after
    the interfaces. No damping is written.

    Raises ResultFileError: the file cannot be written.
    """
    omega, motion = _free_vibrations(form)
    dependent, free, by_interfaces, by_free = _dependence(form, motion)
    n_found = max(1, (len(omega) - N_RIGID) // 4)
    lines = [
        *(f"** {line}" for line in form.comment()),
        "** interfaces: the first node of a set has translations, the second has rotations, as DOF 1 to 3:",
        "** REF NODE and ROT NODE of a *RIGID BODY. To run it alone, request a quarter of the modes at most:",
        f"** *BOUNDARY / {set_names(form)[0]}, 1, 3 / *STEP / *FREQUENCY / {n_found} / *END STEP",
        *_nodes(form, len(omega)),
        *_masses_and_springs(form, omega),
        *_equations(form, dependent, free, by_interfaces, by_free),
    ]
    return write_ascii(path, lines)


def set_names(form: InterfaceForm) -> list[str]:
    """Names of node sets: a number and the interface's name, with underscores for special characters."""
    plain = ("".join(c if c.isascii() and c.isalnum() else "_" for c in name) for name in form.interfaces)
    return [f"I{number}_{name.upper()}" for number, name in enumerate(plain, 1)]


def _free_vibrations(form: InterfaceForm) -> tuple[FloatArray, FloatArray]:
    """Angular frequencies (k,) of the free modes, six zeros first, and their interface motion (6 n, k)."""
    scale = 1.0 / np.sqrt(np.diag(form.mass))
    K, M = (matrix * np.outer(scale, scale) for matrix in (form.stiffness, form.mass))
    squares, modes = linalg.eigh(K, M)
    squares[:N_RIGID] = 0.0
    return np.sqrt(squares), (scale[:, None] * modes)[: form.n_boundary]


def _dependence(
    form: InterfaceForm, motion: FloatArray
) -> tuple[NDArray[np.intp], NDArray[np.intp], FloatArray, FloatArray]:
    """Numbers of the modal coordinates z_d and z_f, and the matrices that give z_d from u and from z_f."""
    sizes = np.linalg.norm(motion, axis=1)
    order = linalg.qr(motion / sizes[:, None], mode="r", pivoting=True)[1]
    dependent, free = np.sort(order[: form.n_boundary]), np.sort(order[form.n_boundary :])
    inverse = linalg.inv(motion[:, dependent])
    return dependent, free, inverse, -inverse @ motion[:, free]


def _nodes(form: InterfaceForm, n_modes: int) -> list[str]:
    n = 2 * len(form.interfaces)
    places = np.repeat(form.positions, 2, axis=0)
    modal = np.tile(form.positions[0], (-(-n_modes // 3), 1))
    lines = ["*NODE, NSET=SUPPLE_ALL"]
    lines += [
        f"{number}, {x:.12e}, {y:.12e}, {z:.12e}"
        for number, (x, y, z) in enumerate(np.concatenate([places, modal]), 1)
    ]
    for number, name in enumerate(set_names(form)):
        lines += [f"*NSET, NSET={name}", f"{2 * number + 1}, {2 * number + 2}"]
    return [*lines, "*NSET, NSET=SUPPLE_INTERFACES, GENERATE", f"1, {n}"]


def _masses_and_springs(form: InterfaceForm, omega: FloatArray) -> list[str]:
    """Masses and springs, three modal coordinates per node; unused components of the last node are fixed."""
    first, k = 2 * len(form.interfaces) + 1, len(omega)
    last = first + (k - 1) // 3
    lines = ["*ELEMENT, TYPE=MASS, ELSET=SUPPLE_MASSES"]
    lines += [f"{number - first + 1}, {number}" for number in range(first, last + 1)]
    lines += ["*MASS, ELSET=SUPPLE_MASSES", "1.0"]
    for number in range(N_RIGID, k):
        element, node, component = last - first + 1 + number, *_place(first, number)
        lines += [
            f"*ELEMENT, TYPE=SPRING1, ELSET=SUPPLE_MODE_{number + 1}",
            f"{element}, {node}",
            f"*SPRING, ELSET=SUPPLE_MODE_{number + 1}",
            f"{component}",
            f"{omega[number] ** 2:.12e}",
        ]
    if k % 3:
        lines += ["*BOUNDARY", f"{last}, {k % 3 + 1}, 3"]
    return lines


def _place(first: int, number: int) -> tuple[int, int]:
    """Node and component of a modal coordinate."""
    return first + number // 3, number % 3 + 1


def _equations(
    form: InterfaceForm,
    dependent: NDArray[np.intp],
    free: NDArray[np.intp],
    own: FloatArray,
    others: FloatArray,
) -> list[str]:
    first = 2 * len(form.interfaces) + 1
    of_interfaces = [_place(1, number) for number in range(form.n_boundary)]
    independent = of_interfaces + [_place(first, int(number)) for number in free]
    lines = []
    for number, row in zip(dependent, np.hstack([own, others]), strict=True):
        there = np.flatnonzero(row)
        terms = [(*_place(first, int(number)), -1.0)]
        terms += [(*independent[j], float(row[j])) for j in there]
        lines += ["*EQUATION", f"{len(terms)}"]
        words = [f"{node}, {component}, {value:.12e}" for node, component, value in terms]
        starts = range(0, len(words), _TERMS_PER_LINE)
        lines += [", ".join(words[at : at + _TERMS_PER_LINE]) for at in starts]
    return lines
