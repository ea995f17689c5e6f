"""The condensed line: stiffness and mass of a free slender body on the stations of its load paths."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg, sparse

from supple.algebra import read_only
from supple.arguments import check_numbers, check_text
from supple.body.rigid_motion import nodal_rigid_modes
from supple.errors import ModelError
from supple.methods.intrinsic.load_path_tree import LoadPathTree, load_path_tree
from supple.methods.intrinsic.station_mass import cleaned_mass

__all__ = ["CondensedLine", "clamped_line", "condensed_line"]

Array = NDArray[np.float64]

LARGEST_RIGID_FORCE = 1e-6
"""Of the forces that a stiffness has for each freedom alone: more under rigid motion is no round-off."""
ASYMMETRY = 1e-8
"""Of the largest entry."""
LARGEST_NEGATIVE = 1e-6
"""Of the largest principal stiffness: one as negative as that is a mistake, not round-off."""
ROUNDING = 1e-13
"""Of the largest mass: stations that share less share none."""


@dataclass(frozen=True, eq=False)
class CondensedLine:
    """A free slender body on n stations with six freedoms each; build it with `condensed_line`.

    name : str
    tree : LoadPathTree         where the stations are, and which hangs on which
    stiffness : (6 n, 6 n)      u and theta of each station, global axes; free of forces under rigid motion
    mass : (6 n, 6 n)           symmetric, not negative; freedoms without mass are allowed
    rigid_force : float         of the stiffness as given, relative: what was cleaned away
    """

    name: str
    tree: LoadPathTree
    stiffness: Array = field(repr=False)
    mass: Array = field(repr=False)
    rigid_force: float

    @property
    def n(self) -> int:
        """Number of stations."""
        return self.tree.n

    @property
    def twists(self) -> Array:
        """(6 n, 6) rigid motion of all stations by velocity and angular velocity at the root."""
        return rigid_twists(self.tree)

    @property
    def station_masses(self) -> Array | None:
        """(n, 6, 6) mass of each station where stations do not share mass; None where they do."""
        blocks = self.mass.reshape(self.n, 6, self.n, 6)
        own = np.einsum("iaib->iab", blocks)
        shared = np.abs(self.mass - np.asarray(linalg.block_diag(*own))).max()
        return own.copy() if shared <= ROUNDING * np.abs(self.mass).max() else None

    @property
    def total_mass(self) -> float:
        """Of a rigid translation, kg."""
        along = self.twists[:, 0]
        return float(along @ self.mass @ along)


def rigid_twists(tree: LoadPathTree) -> Array:
    """Rigid motion (6 n, 6) of stations: translations, then rotations about the root."""
    return nodal_rigid_modes(tree.points - tree.points[0], 6)


def condensed_line(
    name: str, points: ArrayLike, stiffness: Any, mass: Any, *, parents: ArrayLike | None = None
) -> CondensedLine:
    """A free line from the matrices of a condensation: Nastran's ASET, or any other program's.

    What round-off left of forces under rigid motion is cleaned away, with all that geometry knows of rigid
    motion R about the centre of mass:  K <- P^T K P,   P = 1 - R (R^T R)^-1 R^T

    Parameters
    ----------
    points : (n, 3)             stations, the root first, m
    stiffness, mass : (6 n, 6 n)   dense or sparse; ux uy uz rx ry rz of each station, global axes
    parents : (n,)              as for `load_path_tree`; one station after the other when omitted

    Raises
    ------
    ModelError      matrices of the wrong size, not finite or not symmetric; a stiffness that resists rigid
                    motion; a negative stiffness or mass; whatever `load_path_tree` refuses
    Source: [Wang2015] (20); [Guyan1965].
    """
    check_text("condensed_line, name", name)
    tree = load_path_tree(points, parents)
    K = _symmetric(name, "stiffness", stiffness, 6 * tree.n)
    M = _symmetric(name, "mass", mass, 6 * tree.n)
    R = rigid_twists(tree)
    left = _rigid_force(K, R, tree)
    if left > LARGEST_RIGID_FORCE:
        raise ModelError(
            f"line '{name}': its stiffness resists rigid motion by {left:.1e} of its own size (at most "
            f"{LARGEST_RIGID_FORCE:.0e} may be round-off): is a support in it (then use clamped_line), are "
            "the points those of its freedoms, and its rotations in rad?"
        )
    scale = np.tile(np.repeat([1.0, _length(tree)], 3), tree.n)
    Q = np.linalg.qr(scale[:, None] * R)[0]
    scaled = K / np.outer(scale, scale)
    scaled = scaled - Q @ (Q.T @ scaled)
    scaled = scaled - (scaled @ Q) @ Q.T
    _check_not_negative(name, 0.5 * (scaled + scaled.T))
    clean = scaled * np.outer(scale, scale)
    return CondensedLine(
        name, tree, read_only(0.5 * (clean + clean.T)), read_only(cleaned_mass(name, M, _length(tree))), left
    )


def clamped_line(
    name: str,
    points: ArrayLike,
    stiffness: Any,
    mass: Any,
    *,
    parents: ArrayLike | None = None,
    root_mass: ArrayLike | None = None,
) -> CondensedLine:
    """The free line of which matrices hold all stations but the root, which was clamped.

    The forces at the root follow from those of the others, for rigid motion needs none.

    Parameters
    ----------
    points : (n, 3)                     all stations, the clamped root first
    stiffness, mass : (6 n - 6, 6 n - 6)    without the root
    root_mass : (6, 6)                  of the root station, for a root that moves; zero if omitted

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


def _length(tree: LoadPathTree) -> float:
    """What makes rotations comparable with displacements: the mean segment, or one unit for a point."""
    return float(tree.lengths.mean()) if tree.n > 1 else 1.0


def _check_not_negative(name: str, scaled: Array) -> None:
    values, vectors = np.linalg.eigh(scaled)
    if values.size and values[0] < -LARGEST_NEGATIVE * np.abs(values).max():
        worst = int(np.argmax(np.abs(vectors[:, 0]))) // 6
        raise ModelError(
            f"line '{name}': its stiffness is negative at station {worst}: the smallest principal value is "
            f"{values[0] / np.abs(values).max():.1e} of the largest. Condense a body that is not "
            "prestressed, and export stiffness and mass under their own names"
        )


def _rigid_force(K: Array, R: Array, tree: LoadPathTree) -> float:
    """Forces K R against those of each freedom alone, the worst."""
    scale = np.tile(np.repeat([1.0, 1.0 / _length(tree)], 3), tree.n)
    size = np.abs(K) @ np.abs(R) * scale[:, None]
    largest = size.max(initial=0.0)
    return float(np.abs(K @ R * scale[:, None]).max(initial=0.0) / largest) if largest else 0.0


def _symmetric(name: str, what: str, given: Any, size: int) -> Array:
    matrix = given.toarray() if sparse.issparse(given) else given
    check_numbers(f"line '{name}', {what}", matrix)
    matrix = np.array(matrix, dtype=np.float64)
    if matrix.shape != (size, size):
        raise ModelError(
            f"line '{name}': its {what} has shape {matrix.shape}; {size // 6} stations of six freedoms need "
            f"({size}, {size})"
        )
    if not np.isfinite(matrix).all():
        raise ModelError(f"line '{name}': its {what} holds NaN or infinite entries")
    asymmetry = np.abs(matrix - matrix.T).max(initial=0.0)
    if asymmetry > ASYMMETRY * np.abs(matrix).max(initial=0.0):
        raise ModelError(f"line '{name}': its {what} is not symmetric, by {asymmetry:.2e}")
    return 0.5 * (matrix + matrix.T)
