"""Second-order modes: axial, shear and rigid motion of a bent line, in addition to its lowest modes.

The lowest modes of a slender line bend and twist it. A bent line also has other velocities, such as the rate
at which its projection shortens, along linear modes of high order. These velocities are quadratic in the
lowest modes. They follow without a run, from the kinematic couplings of the lowest modes and rigid motion at
constant strain. In a basis without them, motion causes spurious axial force.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from supple.algebra import read_only
from supple.arrays import FloatArray
from supple.methods.intrinsic.intrinsic_modes import IntrinsicModes, checked_modes

SMALLEST = 1e-3
"""Smallest second-order motion relative to the largest; smaller ones are omitted."""
SMALLEST_STRAIN = 1e-3
"""Smallest strain of a static response outside the modes, relative to its whole strain; less is omitted."""


def completed_modes(whole: IntrinsicModes, shapes: FloatArray, n_lowest: int) -> IntrinsicModes:
    """Modes with the shapes U (e, j), whose first columns are the lowest elastic modes.

        U^T W^2 U = diag(w^2),     Phi_1 <- Phi_1 U,     Phi_2 <- Phi_2 W U / w

    whole : all modes of a line
    shapes : orthonormal, as from `second_order_shapes`
    Raises AccuracyError as `intrinsic_modes`.
    """
    k = whole.n_rigid
    omega = np.sqrt(np.einsum("ij,i,ij->j", shapes, whole.omega[k:] ** 2, shapes))
    along = whole.omega[k:, None] * shapes / omega
    rigid = slice(None, k)

    def moving(fields: FloatArray) -> FloatArray:
        return read_only(np.concatenate([fields[..., rigid], fields[..., k:] @ shapes], axis=-1))

    return checked_modes(
        replace(
            whole,
            omega=read_only(np.append(whole.omega[rigid], omega)),
            velocities=moving(whole.velocities),
            momenta=moving(whole.momenta),
            forces=read_only(whole.forces @ along),
            strains=read_only(whole.strains @ along),
            n_second_order=shapes.shape[1] - n_lowest,
        )
    )


def second_order_shapes(whole: IntrinsicModes, n_lowest: int) -> FloatArray:
    """Amplitudes U (e, n + j), orthonormal, of the n lowest elastic modes and of j second-order ones.

    The strain of mode b is constant under velocities a if the omitted modes move at

        q_1 = <Phi_2, L_1(Phi_1a)^T C Phi_2b> / w

    for velocities a of the lowest modes and of rigid motion. Each pair (a, b) is weighted by the response
    of the two modes to a unit force. The Ritz vectors are the directions with the largest displacements and
    rotations; rotations are multiplied by the length of the line.

    whole : all modes of a line
    Source: the idea of modal derivatives, S. R. Idelsohn, A. Cardona, "A reduction method for nonlinear
    structural dynamic analysis", Comput. Methods Appl. Mech. Eng. 49 (1985) 253-279, for [Wang2015] (15).
    """
    k, e = whole.n_rigid, whole.n_elastic
    if n_lowest >= e:
        return np.eye(e)
    tree, omega = whole.line.tree, whole.omega[k:]
    lowest = whole.velocities[..., k : k + n_lowest] / omega[:n_lowest]
    twists = whole.line.twists
    masses = np.einsum("ia,ij,ja->a", twists, whole.line.mass, twists)
    moving = twists[:, masses > 0] / np.sqrt(masses[masses > 0]) / omega[0]
    velocities = np.concatenate([lowest, moving.reshape(whole.line.n, 6, -1)], axis=2)
    middle = 0.5 * (velocities[1:] + velocities[tree.inner])
    strains = whole.strains[..., :n_lowest] / omega[:n_lowest] * tree.lengths[:, None, None]
    left_out = whole.forces[..., n_lowest:].reshape(-1, e - n_lowest).T
    gram = np.zeros((e - n_lowest, e - n_lowest))
    extent = float(np.linalg.norm(np.ptp(tree.points, axis=0)))
    fields = whole.velocities[..., k + n_lowest :] * np.repeat([1.0, extent], 3)[:, None]
    sizes = np.linalg.qr(fields.reshape(-1, e - n_lowest), mode="r")
    for a in range(middle.shape[2]):
        v, w = middle[:, :3, a, None], middle[:, 3:, a, None]
        gamma, kappa = strains[:, :3], strains[:, 3:]
        sheared = np.cross(w, gamma, axis=1) + np.cross(v, kappa, axis=1)
        turned = -np.concatenate([sheared, np.cross(w, kappa, axis=1)], axis=1)
        moved = sizes @ (left_out @ turned.reshape(-1, n_lowest) / omega[n_lowest:, None])
        gram += moved @ moved.T
    squares, directions = np.linalg.eigh(gram)
    squares, directions = squares[::-1], directions[:, ::-1]
    number = int(np.count_nonzero(squares > SMALLEST**2 * squares[0])) if squares[0] > 0 else 0
    return _ritz_shapes(omega, linalg.solve_triangular(sizes, directions[:, :number]), n_lowest)


def with_static_shapes(
    whole: IntrinsicModes, shapes: FloatArray, n_lowest: int, stations: NDArray[np.intp]
) -> FloatArray:
    """The shapes, extended by the static responses to forces and moments at some stations.

    The response to a force F at a station has the amplitudes Phi_1^T F / w^2. Its part outside the shapes is
    added, so that the compliance of these stations is that of all modes.

    whole, shapes, n_lowest : as for `completed_modes`
    Source: [CraigBampton1968], and its dual with attachment modes.
    """
    omega = whole.omega[whole.n_rigid :]
    at_stations = whole.velocities[stations][..., whole.n_rigid :].reshape(-1, len(omega))
    strains = (at_stations / omega).T
    sizes = np.linalg.norm(strains, axis=0)
    known = np.linalg.qr(omega[:, None] * shapes)[0]
    added = strains[:, sizes > 0] / sizes[sizes > 0]
    for _ in range(2):  # twice for round-off
        added = added - known @ (known.T @ added)
    directions, parts, _ = np.linalg.svd(added, full_matrices=False)
    directions = directions[n_lowest:, parts > SMALLEST_STRAIN] / omega[n_lowest:, None]
    return _ritz_shapes(omega, np.hstack([shapes[n_lowest:, n_lowest:], directions]), n_lowest)


def _ritz_shapes(omega: FloatArray, columns: FloatArray, n_lowest: int) -> FloatArray:
    """The n lowest modes, and the Ritz vectors in the span of columns (e - n, j) of the other modes."""
    columns = np.linalg.qr(columns)[0]
    squared = columns.T @ (omega[n_lowest:, None] ** 2 * columns)
    ritz = columns @ np.linalg.eigh(0.5 * (squared + squared.T))[1]
    largest = np.abs(ritz).argmax(axis=0)
    ritz = ritz * np.sign(ritz[largest, np.arange(ritz.shape[1])])  # a fixed sign, independent of the solver
    return linalg.block_diag(np.eye(n_lowest), ritz)
