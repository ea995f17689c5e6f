"""Linear modes of a condensed line as fields along it: velocities, momenta, internal forces, strains."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy import linalg

from supple.algebra import read_only
from supple.arrays import FloatArray
from supple.errors import AccuracyError, ModelError
from supple.methods.intrinsic.condensed_line import MASSLESS, CondensedLine
from supple.methods.intrinsic.load_path_tree import LoadPathTree
from supple.methods.intrinsic.root_support import RootSupport

__all__ = ["IntrinsicModes", "intrinsic_modes"]


LARGEST_DEFECT = 1e-8
"""Largest difference of a Gram matrix from the unit matrix; a larger one is an error."""


@dataclass(frozen=True, eq=False)
class IntrinsicModes:
    """Modes of a line: k rigid ones, which have no strain, then e elastic ones.

    All components are along axes that rotate with the material and are global at rest; so the line has no
    initial curvature, and its tangents t_i differ between segments. With mass-normalised modes Phi_a of
    (K_a - w_j^2 M_a) Phi_a = 0, whose root moves as its support allows,

        Phi_1 = Phi_a at stations,           M Phi_1
        Phi_2 = -1/w_j sum over the stations outboard of [F_k; M_k + (r_k - r_i+1/2) x F_k],
                [F; M] = w_j^2 M_a Phi_a
        C Phi_2 = 1/w_j (-Delta Phi_1 / Delta s + E^T mean Phi_1),    E^T [v; w] = [-t x w; 0]

    with Phi_2 and C Phi_2 at the middles of segments. Rigid modes have w = 0 and no Phi_2. The Gram matrices
    are unit matrices: Phi_1^T M Phi_1 = 1, Phi_2^T (C Phi_2) ds = 1.

    line : CondensedLine
    support : RootSupport
    omega : (k + e,)            rad/s, ascending; exactly zero for rigid modes
    velocities : (n, 6, k + e)  Phi_1
    momenta : (n, 6, k + e)     M Phi_1
    forces : (n - 1, 6, e)      Phi_2
    strains : (n - 1, 6, e)     C Phi_2
    n_second_order : int        number of second-order Ritz vectors, which are the last elastic modes
    """

    line: CondensedLine
    support: RootSupport
    omega: FloatArray
    velocities: FloatArray = field(repr=False)
    momenta: FloatArray = field(repr=False)
    forces: FloatArray = field(repr=False)
    strains: FloatArray = field(repr=False)
    n_second_order: int = 0

    @property
    def n_modes(self) -> int:
        """Number of all modes, k + e."""
        return len(self.omega)

    @property
    def n_rigid(self) -> int:
        """Number of rigid modes, k."""
        return self.n_modes - self.forces.shape[2]

    @property
    def n_elastic(self) -> int:
        """Number of elastic modes, e."""
        return self.forces.shape[2]

    @property
    def frequencies(self) -> FloatArray:
        """Elastic natural frequencies of the line on its support, rad/s, without second-order modes."""
        return self.omega[self.n_rigid : self.n_modes - self.n_second_order]

    @cached_property
    def orthonormality(self) -> tuple[float, float]:
        """Largest defects of the Gram matrices of Phi_1 and of Phi_2."""
        m, e = self.n_modes, self.n_elastic
        first = self.velocities.reshape(-1, m).T @ self.momenta.reshape(-1, m)
        weighted = self.forces * self.line.tree.lengths[:, None, None]
        second = weighted.reshape(-1, e).T @ self.strains.reshape(-1, e)
        return _defect(first), _defect(second)

    def truncated(self, n_modes: int) -> IntrinsicModes:
        """The `n_modes` lowest modes, rigid ones included; ModelError for too few or too many modes."""
        if not self.n_rigid <= n_modes <= self.n_modes or n_modes == 0:
            raise ModelError(
                f"line '{self.line.name}': {n_modes} modes requested; it has {self.n_modes} with mass, of "
                f"which {self.n_rigid} are rigid and must be retained"
            )
        e = n_modes - self.n_rigid
        n_lowest = self.n_elastic - self.n_second_order
        return IntrinsicModes(
            self.line,
            self.support,
            self.omega[:n_modes],
            self.velocities[..., :n_modes],
            self.momenta[..., :n_modes],
            self.forces[..., :e],
            self.strains[..., :e],
            max(e - n_lowest, 0),
        )


def intrinsic_modes(line: CondensedLine, support: RootSupport, n_modes: int | None = None) -> IntrinsicModes:
    """The lowest modes of a line on a support.

    Rigid modes follow from the geometry, not from a tolerance on frequencies. The elastic modes are those of
    the flexibility scaled by the masses, F^T K^-1 F with M = F F^T: massless freedoms follow statically, and
    the lowest modes are the most accurate ones.

    Parameters
    ----------
    n_modes : int       rigid and elastic modes together; default all that have mass

    Raises
    ------
    ModelError      more modes than freedoms with mass, or fewer than rigid modes; a free root motion that
                    moves no mass; a station without stiffness
    AccuracyError   modes that are not orthonormal to 1e-8, with the remedy
    Source: [Wang2015] (26)-(35), with the sign of (35) and the scale of the modes corrected.
    """
    R, Phi, omega = _normal_modes(line, support)
    all_modes = np.hstack([R, Phi])
    momenta = line.mass @ all_modes
    e = Phi.shape[1]
    forces, strains = _section_modes(
        line.tree, Phi.reshape(line.n, 6, e), momenta[:, R.shape[1] :].reshape(line.n, 6, e), omega
    )
    whole = IntrinsicModes(
        line=line,
        support=support,
        omega=read_only(np.append(np.zeros(R.shape[1]), omega)),
        velocities=read_only(all_modes.reshape(line.n, 6, -1)),
        momenta=read_only(momenta.reshape(line.n, 6, -1)),
        forces=read_only(forces),
        strains=read_only(strains),
    )
    return checked_modes(whole if n_modes is None else whole.truncated(n_modes))


def checked_modes(modes: IntrinsicModes) -> IntrinsicModes:
    """The given modes; AccuracyError, with the remedy, if they are not orthonormal to 1e-8."""
    first, second = modes.orthonormality
    if not max(first, second) < LARGEST_DEFECT:
        omega = modes.omega[modes.n_rigid :]
        raise AccuracyError(
            f"line '{modes.line.name}': its modes are orthonormal only to {first:.1e} (velocities) and "
            f"{second:.1e} (forces), over frequencies from {omega.min(initial=np.inf):.3g} to "
            f"{omega.max(initial=0):.3g} rad/s: request fewer modes (n_modes), or correct masses that are "
            "tiny compared with the others"
        )
    return modes


def _defect(gram: FloatArray) -> float:
    return float(np.abs(gram - np.eye(len(gram))).max(initial=0.0))


def _normal_modes(line: CondensedLine, support: RootSupport) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rigid modes (6 n, k), elastic modes (6 n, e), mass-normalised, and their frequencies (e,)."""
    k = support.free.shape[1]
    # The root moves along its free twists alone: x = T z.
    T = np.asarray(linalg.block_diag(support.free, np.eye(6 * line.n - 6)))
    K, M = T.T @ line.stiffness @ T, T.T @ line.mass @ T
    F = T.T @ _mass_factor(line.mass, line.tree.mean_length)
    R = np.vstack([np.eye(k), (line.twists @ support.free)[6:]])
    if k:
        gram = R.T @ M @ R
        scale = np.sqrt(np.diag(gram))
        if not np.all(scale > 0) or np.linalg.cond(gram / np.outer(scale, scale)) > 1e12:
            raise ModelError(
                f"line '{line.name}': a free motion of its root moves no mass: give the stations their "
                "inertia"
            )
        R = linalg.solve_triangular(np.linalg.cholesky(gram), R.T, lower=True).T
    # Rigid motion gets a stiffness, of the size of the elastic one, so that K has an inverse.
    momentum = M @ R
    square = np.sum(momentum**2, axis=0)
    shift = np.trace(K) / max(len(K), 1) / np.where(square > 0, square, 1.0)
    K_held = K + (momentum * shift) @ momentum.T
    diagonal = np.diag(K_held)
    D = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    try:
        factor = linalg.cho_factor(K_held * np.outer(D, D), lower=True)
    except linalg.LinAlgError as error:
        raise ModelError(
            f"line '{line.name}': motions other than those of its root have no stiffness ({error}): check "
            "for a station that is not connected, or that can rotate freely"
        ) from error
    flexible = D[:, None] * np.asarray(linalg.cho_solve(factor, D[:, None] * F))
    rigid_part = np.linalg.qr(F.T @ R)[0] if k else np.zeros((F.shape[1], 0))
    G = F.T @ flexible
    G = G - rigid_part @ (rigid_part.T @ G)
    G = G - (G @ rigid_part) @ rigid_part.T
    values, y = np.linalg.eigh(0.5 * (G + G.T))
    e = np.linalg.matrix_rank(F) - k
    y = y[:, ::-1][:, :e]
    values = values[::-1][:e]
    columns = np.hstack([R, flexible @ y / values])
    for _ in range(3):  # mass-orthonormal in their order, by Cholesky QR, repeated for round-off
        L = np.linalg.cholesky(columns.T @ M @ columns)
        columns = np.asarray(linalg.solve_triangular(L, columns.T, lower=True)).T
    Phi = columns[:, k:]
    omega = np.sqrt(np.einsum("ij,ij->j", Phi, K @ Phi))
    order = np.argsort(omega, kind="stable")
    Phi, omega = Phi[:, order], omega[order]
    largest = np.abs(Phi).argmax(axis=0)
    Phi = Phi * np.sign(Phi[largest, np.arange(e)])  # a fixed sign, independent of the solver
    return T @ R, T @ Phi, omega


def _mass_factor(mass: FloatArray, length: float) -> FloatArray:
    """F (6 n, r) with F F^T = M; one column per freedom with mass. length : m, scale of inertias to masses"""
    scale = np.tile(np.repeat([1.0, 1.0 / length], 3), len(mass) // 6)
    values, vectors = np.linalg.eigh(mass * np.outer(scale, scale))
    kept = values > MASSLESS * values.max(initial=0.0)
    return (vectors[:, kept] * np.sqrt(values[kept])) / scale[:, None]


def _section_modes(
    tree: LoadPathTree, Phi: FloatArray, momenta: FloatArray, omega: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Phi_2 and C Phi_2 at the middles of the segments, (n - 1, 6, e) each."""
    e = Phi.shape[2]
    force = -omega * momenta
    about_origin = force.copy()
    about_origin[:, 3:] += np.cross(tree.points[:, :, None], force[:, :3], axis=1)
    outboard = tree.outboard_sums(about_origin.reshape(tree.n, -1)).reshape(tree.n, 6, e)[1:]
    forces = outboard.copy()
    forces[:, 3:] -= np.cross(tree.middles[:, :, None], outboard[:, :3], axis=1)

    outer, inner = Phi[1:], Phi[tree.inner]
    strains = -(outer - inner) / tree.lengths[:, None, None]
    strains[:, :3] -= np.cross(tree.directions[:, :, None], 0.5 * (outer + inner)[:, 3:], axis=1)
    return forces, strains / np.where(omega > 0, omega, 1.0)
