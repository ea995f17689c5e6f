"""Condensed line: stiffness and mass of a free slender body on the stations of its load paths."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy import linalg, sparse

from supple.algebra import read_only
from supple.arguments import check_numbers, check_text
from supple.arrays import FloatArray
from supple.body.rigid_motion import nodal_rigid_modes
from supple.errors import ModelError
from supple.methods.intrinsic.load_path_tree import LoadPathTree, load_path_tree

__all__ = ["CondensedLine", "clamped_line", "condensed_line"]

Matrix = ArrayLike | sparse.sparray | sparse.spmatrix

LARGEST_RIGID_FORCE = 1e-6
"""Largest entry of K R relative to that of |K| |R|, for rigid motions R; a larger one is an error."""
ASYMMETRY = 1e-8
"""Largest difference of mirrored entries relative to the largest entry; a larger one is an error."""
LARGEST_NEGATIVE = 1e-6
"""Largest magnitude of a negative principal stiffness, or mass, relative to the largest; a larger one is an
error."""
MASSLESS = 1e-10
"""Mass relative to the largest; a smaller one is zero."""
ROUNDING = 1e-13
"""Mass entry between two stations, relative to the largest entry, below which it counts as zero."""


@dataclass(frozen=True, eq=False)
class CondensedLine:
    """Free slender body on n stations with six freedoms each; built by `condensed_line`.

    name : str
    tree : LoadPathTree         positions of the stations, and the parent of each
    stiffness : (6 n, 6 n)      u and theta of each station, global axes; zero forces under rigid motion
    mass : (6 n, 6 n)           symmetric, not negative; massless freedoms are allowed
    rigid_force : float         largest entry of K R relative to that of |K| |R|, for the given stiffness K
                                and rigid motions R; removed in `stiffness`
    """

    name: str
    tree: LoadPathTree
    stiffness: FloatArray = field(repr=False)
    mass: FloatArray = field(repr=False)
    rigid_force: float

    @property
    def n(self) -> int:
        """Number of stations."""
        return self.tree.n

    @property
    def twists(self) -> FloatArray:
        """(6 n, 6) rigid motion of all stations for unit velocities and angular velocities of the root."""
        return rigid_twists(self.tree)

    @property
    def station_masses(self) -> FloatArray | None:
        """(n, 6, 6) mass of each station where stations do not share mass; None where they do."""
        blocks = self.mass.reshape(self.n, 6, self.n, 6)
        own = np.einsum("iaib->iab", blocks)
        shared = np.abs(self.mass - np.asarray(linalg.block_diag(*own))).max()
        return own.copy() if shared <= ROUNDING * np.abs(self.mass).max() else None

    @property
    def translating(self) -> FloatArray:
        """(n, 6, 3) momenta of the stations in unit translations of the line."""
        return self.mass.reshape(self.n, 6, self.n, 6).sum(axis=2)[:, :, :3]

    @property
    def total_mass(self) -> float:
        """Total mass, kg."""
        along = self.twists[:, 0]
        return float(along @ self.mass @ along)


def rigid_twists(tree: LoadPathTree) -> FloatArray:
    """Rigid motion (6 n, 6) of stations: translations, then rotations about the root."""
    return nodal_rigid_modes(tree.points - tree.points[0], 6)


def condensed_line(
    name: str, points: ArrayLike, stiffness: Matrix, mass: Matrix, *, parents: ArrayLike | None = None
) -> CondensedLine:
    """Free line from the matrices of a condensation by Nastran (ASET) or any other program.

    Rigid-body forces due to round-off are removed with the rigid motion R of the stations (rotations scaled
    by the mean segment):  K <- P^T K P,   P = 1 - R (R^T R)^-1 R^T

    Parameters
    ----------
    points : (n, 3)             stations, the root first, m
    stiffness, mass : (6 n, 6 n)   dense or sparse; ux uy uz rx ry rz of each station, global axes
    parents : (n,)              as for `load_path_tree`; by default each station follows the one before

    Raises
    ------
    ModelError      matrices of the wrong size, not finite or not symmetric; a stiffness with rigid-body
                    forces; a negative stiffness or mass; no mass; and as `load_path_tree`
    Source: [Wang2015] (20); [Guyan1965].
    """
    check_text("condensed_line, name", name)
    tree = load_path_tree(points, parents)
    K = _symmetric(name, "stiffness", stiffness, 6 * tree.n)
    M = _symmetric(name, "mass", mass, 6 * tree.n)
    R = rigid_twists(tree)
    scale = np.tile(np.repeat([1.0, tree.mean_length], 3), tree.n)
    largest = (np.abs(K) @ np.abs(R) / scale[:, None]).max(initial=0.0)
    left = float(np.abs(K @ R / scale[:, None]).max(initial=0.0) / (largest or 1.0))
    if left > LARGEST_RIGID_FORCE:
        raise ModelError(
            f"line '{name}': rigid motion causes forces of {left:.1e} times those of single freedoms (at "
            f"most {LARGEST_RIGID_FORCE:.0e} can be round-off): if the stiffness includes a support, use "
            "clamped_line; check that the points belong to its freedoms, and that rotations are in rad"
        )
    Q = np.linalg.qr(scale[:, None] * R)[0]
    scaled = K / np.outer(scale, scale)
    scaled = scaled - Q @ (Q.T @ scaled)
    scaled = scaled - (scaled @ Q) @ Q.T
    _check_not_negative(name, 0.5 * (scaled + scaled.T))
    clean = scaled * np.outer(scale, scale)
    M = _cleaned_mass(name, M, tree.mean_length)
    return CondensedLine(name, tree, read_only(0.5 * (clean + clean.T)), read_only(M), left)


def clamped_line(
    name: str,
    points: ArrayLike,
    stiffness: Matrix,
    mass: Matrix,
    *,
    parents: ArrayLike | None = None,
    root_mass: ArrayLike | None = None,
) -> CondensedLine:
    """Free line from matrices of all stations except the root, which was clamped.

    The stiffness of the root follows from that of the other stations, since rigid motion causes no forces.

    Parameters
    ----------
    points : (n, 3)                     all stations, the clamped root first
    stiffness, mass : (6 n - 6, 6 n - 6)    without the root
    root_mass : (6, 6)                  mass of the root station, if the root moves; default zero

    Raises ModelError as `condensed_line`.
    """
    tree = load_path_tree(points, parents)
    size = 6 * (tree.n - 1)
    K, M = _symmetric(name, "stiffness", stiffness, size), _symmetric(name, "mass", mass, size)
    R = rigid_twists(tree)[6:]
    full_mass = linalg.block_diag(np.zeros((6, 6)) if root_mass is None else np.asarray(root_mass), M)
    coupling = K @ R
    full = np.block([[R.T @ coupling, -coupling.T], [-coupling, K]])
    return condensed_line(name, points, full, full_mass, parents=parents)


def _check_not_negative(name: str, scaled: FloatArray) -> None:
    values, vectors = np.linalg.eigh(scaled)
    if values.size and values[0] < -LARGEST_NEGATIVE * np.abs(values).max():
        worst = int(np.argmax(np.abs(vectors[:, 0]))) // 6
        raise ModelError(
            f"line '{name}': its stiffness is negative at station {worst}: the smallest principal value is "
            f"{values[0] / np.abs(values).max():.1e} of the largest. Condense the body without prestress, "
            "and export stiffness and mass under their own names"
        )


def _cleaned_mass(name: str, mass: FloatArray, length: float) -> FloatArray:
    """The mass matrix without small negative principal values; ModelError for larger ones, or no mass.

    length : m, scale of inertias to masses
    """
    scale = np.tile(np.repeat([1.0, 1.0 / length], 3), len(mass) // 6)
    values, vectors = np.linalg.eigh(mass * np.outer(scale, scale))
    largest = np.abs(values).max(initial=0.0)
    if values.size and values[0] < -LARGEST_NEGATIVE * largest:
        worst = int(np.argmax(np.abs(vectors[:, 0]))) // 6
        raise ModelError(
            f"line '{name}': its mass is negative at station {worst}: the smallest principal value is "
            f"{values[0]:.3g} kg, with the mean segment as radius; the largest is {largest:.3g}. "
            "Export the mass matrix again, or correct the inertias"
        )
    if not largest > 0:
        raise ModelError(f"line '{name}': it has no mass: give its stations or elements mass")
    if values[0] >= 0:
        return mass
    kept = values > MASSLESS * largest
    root = (vectors[:, kept] * np.sqrt(values[kept])) / scale[:, None]
    return root @ root.T


def _symmetric(name: str, what: str, given: Matrix, size: int) -> FloatArray:
    matrix = sparse.csr_array(given).toarray() if sparse.issparse(given) else given
    check_numbers(f"line '{name}', {what}", matrix)
    matrix = np.array(matrix, dtype=np.float64)
    if matrix.shape != (size, size):
        raise ModelError(
            f"line '{name}': its {what} has shape {matrix.shape}; {size // 6} stations of six freedoms need "
            f"({size}, {size})"
        )
    if not np.isfinite(matrix).all():
        raise ModelError(f"line '{name}': its {what} has NaN or infinite entries: export it again")
    asymmetry = np.abs(matrix - matrix.T).max(initial=0.0)
    if asymmetry > ASYMMETRY * np.abs(matrix).max(initial=0.0):
        raise ModelError(
            f"line '{name}': its {what} is not symmetric (largest difference of mirrored entries "
            f"{asymmetry:.2e}): export the symmetric matrix"
        )
    return 0.5 * (matrix + matrix.T)
