"""Standard input data (SID): a body in a floating frame, for Simpack and Modelica's FlexibleBodies.

Every block is a Taylor series in the coordinates, `m0(row, column) + m1(row, k, column) q_k`. With the
positions x of the points, their displacement u and the modes phi_k, and with integrals from the Gram matrix,

    mdCM = int x + u                          J  = - int (x + u)~ (x + u)~ to first order: xx yy zz xy xz yz
    Ct   = int phi^T                          Cr = int phi^T (x + u)~^T
    Me   = int phi^T phi                      Gr_k = -2 int (x + u)~ phi_k~
    Ge_k = -2 int phi^T phi_k~                Oe Omega = int phi^T w~ w~ (x + u)
    Ke, De : stiffness, damping               Omega = (w_x^2, w_y^2, w_z^2, w_x w_y, w_y w_z, w_x w_z)

Gr has three columns for each coordinate; Ge has r columns for each axis, one per coordinate. With the
acceleration a of the frame's origin, its angular acceleration alpha and angular velocity w, the equations are

    Me q'' + Ct a + Cr alpha + Ge_k q_k' w + Oe Omega + Ke q + De q' = loads

A nonlinear body has geometric stiffness to first order: a unit acceleration or a unit product of angular
velocities deforms it by `q_s = - Ke^-1 (Ct | Cr | Oe)`. The stiffness A3(q_s) of its cubic tensor is added to
the first-order parts of Ct, Cr and Oe.

Source: [Wallrapp1994]; the layout as in public descriptions of the format.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.export.ascii_file import write_ascii
from supple.reduction import ReducedBody
from supple.reduction.tensors import unpack_symmetric

__all__ = ["StandardInputData", "TaylorSeries", "standard_input_data", "write_sid"]


PRODUCTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
"""Products of angular velocity components, in the order of Oe's columns."""

INERTIA = np.array([0, 1, 2, 0, 0, 1]), np.array([0, 1, 2, 1, 2, 2])
"""Rows and columns of the inertia tensor, in the order of J."""

_ZERO, _FULL = 0, 3
"""Structure codes: zero and full. Symmetric matrices are written in full: not all readers mirror them."""


@dataclass(frozen=True, eq=False)
class TaylorSeries:
    """A block of SID: terms of order zero (rows, columns) and of order one (rows, columns, r), or None."""

    zeroth: FloatArray = field(repr=False)
    first: FloatArray | None = field(default=None, repr=False)


@dataclass(frozen=True, eq=False)
class StandardInputData:
    """The blocks of a body by their names in the file, and the frames of its interfaces.

    mass : float;   frequencies : (r,) of the body in its frame, cycles per unit of time
    blocks : mdCM (3, 1), J (6, 1), Ct (r, 3), Cr (r, 3), Me (r, r), Gr (3, 3 r), Ge (r, 3 r),
    Oe (r, 6), Ke (r, r), De (r, r)
    frames : by interface, origin (3, 1), phi (3, r), psi (3, r), AP (3, 3)
    """

    name: str
    mass: float
    frequencies: FloatArray = field(repr=False)
    blocks: dict[str, TaylorSeries] = field(repr=False)
    frames: dict[str, dict[str, TaylorSeries]] = field(repr=False)


def standard_input_data(body: ReducedBody) -> StandardInputData:
    """The SID blocks of a reduced body; for a nonlinear body, with geometric stiffness to first order.

    Raises ModelError: a body with strain energy outside its tensors.
    """
    if body.elastic_elsewhere:
        raise ModelError(
            f"body '{body.name}' has strain energy outside its tensors, which SID cannot hold: reduce it "
            "with fewer modes, or reduce body.linearized()"
        )
    r, gram = body.r, body.gram
    t, w, k, v = slice(0, 3), slice(3, 6), slice(6, 6 + 3 * r), slice(6 + 3 * r, None)
    turned = gram[k].reshape(r, 3, -1)
    by_origin = gram[w, k].reshape(3, r, 3)  # - int x~ phi_k~
    rates = turned[:, :, v]  # (k, i, l), for q_k, w_i and q_l'
    among = turned[:, :, k].reshape(r, 3, r, 3)
    centre = body.centre_of_mass * body.mass
    gyroscopic = rates.transpose(2, 1, 0) - rates
    by_coordinate = by_origin.transpose(0, 2, 1) + by_origin.transpose(2, 0, 1)
    centrifugal = [-(by_origin[i, :, j] + by_origin[j, :, i]) * (0.5 if i == j else 1.0) for i, j in PRODUCTS]
    softening = [-(among[:, i, :, j] + among[:, j, :, i]) * (0.5 if i == j else 1.0) for i, j in PRODUCTS]
    Ct, Cr, Oe = gram[v, t], gram[v, w], np.stack(centrifugal, axis=1)
    blocks = {
        "mdCM": TaylorSeries(centre[:, None], gram[t, v][:, None]),
        "J": TaylorSeries(gram[w, w][INERTIA][:, None], by_coordinate[INERTIA][:, None]),
        "Ct": TaylorSeries(Ct, _stiffening(body, Ct)),
        "Cr": TaylorSeries(Cr, rates.transpose(2, 1, 0) + _stiffening(body, Cr)),
        "Me": TaylorSeries(gram[v, v]),
        "Gr": TaylorSeries(2 * gram[w, k], 2 * among.transpose(1, 2, 3, 0).reshape(3, 3 * r, r)),
        "Ge": TaylorSeries(gyroscopic.reshape(r, 3 * r)),
        "Oe": TaylorSeries(Oe, np.stack(softening, axis=1) + _stiffening(body, Oe)),
        "Ke": TaylorSeries(body.stiffness),
        "De": TaylorSeries(body.damping),
    }
    frames = {}
    for interface in body.interfaces:
        phi, psi = interface.motion[:3], interface.motion[3:]
        frames[interface.name] = {
            "origin": TaylorSeries(interface.position[:, None], phi[:, None]),
            "phi": TaylorSeries(phi),
            "psi": TaylorSeries(psi),
            "AP": TaylorSeries(np.eye(3), _cross_of_columns(psi)),
        }
    return StandardInputData(body.name, body.mass, body.frequencies / (2 * np.pi), blocks, frames)


def write_sid(path: Path | str, body: ReducedBody) -> Path:
    """Write a reduced body as SID with 17 digits; returns the path.

    Raises
    ------
    ModelError          as for `standard_input_data`
    ResultFileError     the file cannot be written
    """
    data = standard_input_data(body)
    r = body.r
    comment = f"supple: {data.name}; nodes: {', '.join(data.frames)}"
    lines = [f"{len(data.frames):5d} {r:5d} :No. nodes, No. modes: {comment}", "part", "new modal", "refmod"]
    lines += [f"    mass           = {_number(data.mass)}", f"    nelastq        = {r}"]
    lines += [
        f"    ielastq ( {number}) = Eigen Mode {number} : {value:.9g} per unit of time"
        for number, value in enumerate(data.frequencies, 1)
    ]
    lines += ["end refmod", "frame"]
    for number, series in enumerate(data.frames.values(), 1):
        lines += [f"new node = {number}", "rframe = body ref"]
        for block, values in series.items():
            lines += _block(block, values, r)
        lines.append("end node")
    lines.append("end frame")
    for block, values in data.blocks.items():
        if block == "Ke":
            lines += ["ksigma", *_head(0, (r, 1), r, _ZERO), "end ksigma"]
        lines += _block(block, values, r)
    return write_ascii(path, [*lines, "end modal", "end part"])


def _stiffening(body: ReducedBody, inertia: FloatArray) -> FloatArray:
    """Geometric stiffness (r, c, r) of the static deformation under each column; zeros for a linear body."""
    r = len(inertia)
    if body.cubic is None:
        return np.zeros((r, inertia.shape[1], r))
    steady = -np.linalg.solve(body.stiffness, inertia)
    return unpack_symmetric((body.cubic @ steady).T, r).transpose(1, 0, 2)


def _cross_of_columns(vectors: FloatArray) -> FloatArray:
    """Cross matrices (3, 3, r) of the columns (3, r)."""
    x, y, z = vectors
    o = np.zeros_like(x)
    return np.array([[o, -z, y], [z, o, -x], [-y, x, o]])


def _block(name: str, series: TaylorSeries, r: int) -> list[str]:
    """Lines of one Taylor series."""
    order = 0 if series.first is None else 1
    lines = [name, *_head(order, series.zeroth.shape, r, _FULL)]
    rows, columns = series.zeroth.shape
    places = [(i, j) for i in range(rows) for j in range(columns)]
    lines += [f"    m0( {i + 1}, {j + 1}) = {_number(series.zeroth[i, j])}" for i, j in places]
    if series.first is not None:
        lines += [
            f"    m1( {i + 1}, {number}, {j + 1}) = {_number(value)}"
            for i, j in places
            for number, value in enumerate(series.first[i, j], 1)
        ]
    return [*lines, f"end {name}"]


def _number(value: float) -> str:
    """A number with 17 digits and the exponent letter D."""
    return f"{value:.16e}".replace("e", "D")


def _head(order: int, shape: tuple[int, ...], r: int, structure: int) -> list[str]:
    values = {"order": order, "nrow": shape[0], "ncol": shape[1], "nq": r, "nqn": 0, "structure": structure}
    return [f"    {key:<9} = {value}" for key, value in values.items()]
