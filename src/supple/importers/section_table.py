"""Section tables: position, 6 x 6 stiffness and 6 x 6 inertia along the curve of a beam."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from supple.algebra import read_only
from supple.algebra.cross import cross_matrices
from supple.arguments import check_numbers
from supple.arrays import FloatArray
from supple.errors import ModelError

__all__ = ["SectionTable", "check_sections", "section_matrix", "twisted_axes"]

ASYMMETRY = 1e-6
"""Largest difference of mirrored entries, relative to the geometric mean of their diagonal entries.

Also the largest error of the scalar products of axes. Larger values raise ModelError.
"""
SMALLEST_STIFFNESS = 1e-9
"""Smallest eigenvalue of a stiffness with its diagonal scaled to 1; smaller values raise ModelError."""
NO_SECTION = 1e-3
"""Largest relative error of an inertia compared with that of a plane mass; larger ones raise ModelError."""
LEAST_COSINE = 0.5
"""Smallest cosine of the angle between a chord and axis z of its sections; smaller ones raise ModelError."""

UPPER = np.triu_indices(6)
"""Row and column of the 21 numbers of a symmetric matrix: the upper triangle, row by row."""
PAIRS = [f"{i + 1}{j + 1}" for i, j in zip(*UPPER, strict=True)]
"""The same as in the names of columns: 11, 12 .. 66."""


@dataclass(frozen=True, eq=False)
class SectionTable:
    """Sections along a curve, from its root to its tip.

    Section axes: x and y across the curve, z along it, from the root to the tip. Forces and velocities come
    before moments and angular velocities, x before y before z, all at the point of the section on the curve:

        (F, M) = K (gamma, kappa),   gamma = u' + t x theta,   kappa = theta'
        (p, l) = M (v, omega),       M = [m 1, -m c~; m c~, J],   c = (c_x, c_y, 0)

    per unit length; t is the unit vector z, and c~ r = c x r. A centre of tension at (x, y) gives K_34 = EA y
    and K_35 = -EA x, a centre of mass M_34 = m y and M_35 = -m x. Between sections, positions and
    matrices are linear in the length along the chords, and the axes rotate at a constant rate.

    positions : (n, 3)      in the body's axes
    axes : (n, 3, 3)        their columns are the unit vectors x, y, z of a section in the body's axes
    stiffness : (n, 6, 6)   symmetric, positive definite
    inertia : (n, 6, 6)     of a mass in the plane of the section

    Raises
    ------
    ModelError      arrays of the wrong shape, coincident sections, axes that are not a rotation or not
                    along the curve; errors of `check_sections`
    """

    positions: FloatArray
    axes: FloatArray = field(repr=False)
    stiffness: FloatArray = field(repr=False)
    inertia: FloatArray = field(repr=False)

    def __post_init__(self) -> None:
        shapes = {"positions": (3,), "axes": (3, 3), "stiffness": (6, 6), "inertia": (6, 6)}
        n = len(np.atleast_1d(self.positions))
        for name, shape in shapes.items():
            check_numbers(f"section table, {name}", getattr(self, name))
            array = read_only(getattr(self, name))
            if n < 2 or array.shape != (n, *shape) or not np.isfinite(array).all():
                raise ModelError(
                    f"section table: {name} have shape {array.shape}; give finite numbers "
                    f"(n, {', '.join(map(str, shape))}) of the same n >= 2 sections"
                )
            object.__setattr__(self, name, array)
        where = [f"section {k}" for k in range(n)]
        check_sections(where, self.stiffness, self.inertia)
        _check_curve(where, self.positions, self.axes)

    @property
    def n(self) -> int:
        """Number of sections."""
        return len(self.positions)

    @cached_property
    def lengths(self) -> FloatArray:
        """Lengths (n,) from the first section to each section, along the chords between sections."""
        return read_only(np.append(0.0, np.linalg.norm(np.diff(self.positions, axis=0), axis=1).cumsum()))

    @property
    def mass(self) -> float:
        """Mass of the sections, whose mass per length is linear in between."""
        return float(np.trapezoid(self.inertia[:, 0, 0], self.lengths))

    def at(self, lengths: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Positions, axes, stiffness and inertia at some lengths (k,) along the chords, in this order."""
        s = np.asarray(lengths, dtype=float)
        first = np.clip(np.searchsorted(self.lengths, s, side="right") - 1, 0, self.n - 2)
        share = (s - self.lengths[first]) / np.diff(self.lengths)[first]

        def between(values: FloatArray) -> FloatArray:
            weight = share.reshape(-1, *(1,) * (values.ndim - 1))
            return (1 - weight) * values[first] + weight * values[first + 1]

        start, turn = Rotation.from_matrix(self.axes[first]), Rotation.from_matrix(self.axes[first + 1])
        turned = start * Rotation.from_rotvec(share[:, None] * (start.inv() * turn).as_rotvec())
        return between(self.positions), turned.as_matrix(), between(self.stiffness), between(self.inertia)


def section_matrix(upper: ArrayLike) -> FloatArray:
    """Symmetric matrices (..., 6, 6) of upper triangles (..., 21), row by row: 11, 12, .. 16, 22, .. 66."""
    upper = np.asarray(upper, dtype=float)
    full = np.zeros((*upper.shape[:-1], 6, 6))
    full[..., UPPER[0], UPPER[1]] = upper
    full[..., UPPER[1], UPPER[0]] = upper
    return full


def twisted_axes(tangents: ArrayLike, twist: ArrayLike) -> FloatArray:
    """Axes (n, 3, 3) of sections normal to a curve along z, rotated by a twist about -z, rad.

    Without twist, x of the section has no component along y of the body. This is the convention of windIO and
    BeamDyn: z from root to tip, x to the suction side, y to the trailing edge, twist positive at the root.

    tangents : (n, 3)       of the curve, of any length; with a component along x or z
    """
    z = np.asarray(tangents, dtype=float)
    z = z / np.linalg.norm(z, axis=1)[:, None]
    x = np.column_stack([z[:, 2], np.zeros(len(z)), -z[:, 0]])
    x /= np.linalg.norm(x, axis=1)[:, None]
    turn = Rotation.from_rotvec(-np.asarray(twist)[:, None] * z)
    return (turn * Rotation.from_matrix(np.stack([x, np.cross(z, x), z], axis=2))).as_matrix()


def check_sections(where: Sequence[str], stiffness: FloatArray, inertia: FloatArray) -> None:
    """Raise ModelError unless each stiffness is positive definite and each inertia is that of a plane mass.

    where : label of each section in messages, such as its line in a file
    """
    for name, matrices in (("stiffness", stiffness), ("inertia", inertia)):
        diagonal = np.einsum("nii->ni", matrices)
        low = diagonal <= 0 if name == "stiffness" else (diagonal < 0) | (np.arange(6) < 3) & (diagonal == 0)
        if low.any():
            k, i = np.argwhere(low)[0]
            raise ModelError(
                f"{where[k]}: {name} {i + 1}{i + 1} is {diagonal[k, i]:.4g}; it must be positive: a beam "
                "needs its stiffness and its mass"
            )
        scale = np.sqrt(np.einsum("ni,nj->nij", diagonal, diagonal))
        off = np.abs(matrices - matrices.swapaxes(1, 2)) > ASYMMETRY * scale
        if off.any():
            k, i, j = np.argwhere(off)[0]
            raise ModelError(
                f"{where[k]}: {name} is not symmetric: {i + 1}{j + 1} is {matrices[k, i, j]:.6g} and "
                f"{j + 1}{i + 1} is {matrices[k, j, i]:.6g}; correct one of them"
            )
    root = np.sqrt(np.einsum("nii->ni", stiffness))
    least = np.linalg.eigvalsh(stiffness / (root[:, :, None] * root[:, None]))[:, 0]
    if least.min() < SMALLEST_STIFFNESS:
        k = int(least.argmin())
        raise ModelError(
            f"{where[k]}: its stiffness is not positive definite: with the diagonal scaled to 1, the "
            f"smallest principal value is {least[k]:.2g}; check couplings, units and the order x, y, z of "
            "forces, then of moments, with z along the curve"
        )
    _check_inertia(where, inertia)


def _check_inertia(where: Sequence[str], inertia: FloatArray) -> None:
    mass = inertia[:, 0, 0]
    arm = np.column_stack([inertia[:, 1, 5], -inertia[:, 0, 5], np.zeros(len(mass))]) / mass[:, None]
    c = cross_matrices(arm)
    about_centre = inertia[:, 3:, 3:] + mass[:, None, None] * (c @ c)
    size = np.sqrt(np.maximum(np.trace(inertia[:, 3:, 3:], axis1=1, axis2=2) / mass, 0.0))
    parts = (
        (
            np.abs(inertia[:, :3, :3] / mass[:, None, None] - np.eye(3)).max(axis=(1, 2)) > NO_SECTION,
            "its mass differs with the direction (11, 22, 33, and 12, 13, 23 zero)",
        ),
        (
            np.abs(inertia[:, 3:, :3] / mass[:, None, None] - c).max(axis=(1, 2)) > NO_SECTION * size,
            "its first moments are not of a mass in its plane (26 = m x = -35, 34 = m y = -16, others zero)",
        ),
        (
            np.linalg.eigvalsh(about_centre)[:, 0] < -NO_SECTION * mass * size**2,
            "its moments of inertia are less than mass times squared distance of its centre of mass",
        ),
        (
            inertia[:, 5, 5] < (1 - NO_SECTION) * np.maximum(inertia[:, 3, 3], inertia[:, 4, 4]),
            "its polar moment of inertia, 66, is less than 44 or 55",
        ),
    )
    for bad, what in parts:
        if bad.any():
            raise ModelError(
                f"{where[int(np.argmax(bad))]}: {what}: no section has such an inertia; check signs, units "
                "and the order x, y, z of velocities, then of rotations, with z along the curve"
            )


def _check_curve(where: Sequence[str], positions: FloatArray, axes: FloatArray) -> None:
    chords = np.diff(positions, axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    if not (lengths > 0).all():
        k = int(np.argmin(lengths))
        raise ModelError(f"sections {k} and {k + 1} are at the same position; leave one of them out")
    off = np.abs(axes.swapaxes(1, 2) @ axes - np.eye(3)).max(axis=(1, 2)) > ASYMMETRY
    off |= np.linalg.det(axes) < 0
    if off.any():
        raise ModelError(
            f"{where[int(np.argmax(off))]}: its axes are no rotation: give columns x, y, z of unit vectors, "
            "right-handed"
        )
    directions = chords / lengths[:, None]
    cosine = np.minimum(
        np.einsum("ni,ni->n", directions, axes[:-1, :, 2]), np.einsum("ni,ni->n", directions, axes[1:, :, 2])
    )
    if cosine.min() < LEAST_COSINE:
        k = int(np.argmin(cosine))
        raise ModelError(
            f"{where[k]}: the curve to the next section is at {np.degrees(np.arccos(cosine[k])):.0f} degrees "
            "from its axis z; z must be along the curve, from the root to the tip"
        )


PIECES = 100
"""Smallest number of straight pieces of a blade: no step exceeds 1 / PIECES of its length."""


def fine_grid(grid: FloatArray) -> FloatArray:
    """The ascending grid (n,) with points added so that no step exceeds 1 / PIECES of its whole length."""
    parts = np.ceil(np.diff(grid) / (grid[-1] - grid[0]) * PIECES - 1e-9).astype(int)
    steps = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(grid[:-1], grid[1:], parts, strict=True)]
    return np.append(np.concatenate(steps), grid[-1])


def matrices_at(fine: FloatArray, grid: FloatArray, matrices: FloatArray) -> FloatArray:
    """Matrices (k, 6, 6) at `fine` (k,), linear between the matrices (n, 6, 6) at the grid (n,)."""
    flat = matrices.reshape(len(grid), 36)
    return np.column_stack([np.interp(fine, grid, column) for column in flat.T]).reshape(-1, 6, 6)
