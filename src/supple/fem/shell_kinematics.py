"""Kinematics of the flat shell triangle: its gradients, its strains, and their quadratic form N.

All vectors are in the axes of the element, z the normal; theta_i is the rotation vector of corner i, theta
their mean; H = (u,x u,y; v,x v,y) with symmetric part S, grad w = (w,x, w,y), omega = (v,x - u,y)/2. On side
k, of direction s_k, t_k is the mean rotation of its ends and b_k = t_k x z the corresponding slope.

    E   = S + 1/2 (H^T H + grad w grad w)                               membrane
    d_i = theta_iz - omega + 1/6 tr(H) omega - 1/2 grad w . theta_i     drilling
          + V . (5/6 theta_i - 1/3 Y - 1/6 grad w x z)
    r_i = theta_i + 1/3 S theta_i - 1/2 theta x theta_i                 rotation of a corner, in the plane
    m_k = grad w + b_k + 1/3 H^T b_k - 1/6 t_kz t_k                     Kirchhoff's condition on a side

Only differences of the r_i, and the component of m_k along side k, contribute to the energy. In V = grad w +
b and Y = t, b and t are least-squares fits to the sides: s_k . b = s_k . b_k and s_k . t = s_k . t_k; V is
zero at constant curvature. For a rigid rotation rho and small rotations delta_i relative to it (exp(theta_i)
= exp(rho) exp(delta_i)), the strains are those of delta_i, with errors of order rho^3 delta and rho^4: the
coefficients cancel all terms up to rho^2 delta. Without these coefficients the curvature is too small by the
fraction rho^2/3. Bending of a rotated facet would also cause drilling strain: a facet of size h and thickness
t would be too stiff by the fraction (rho h / t)^2.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray
from supple.fem.kinematics import green_lagrange_form

__all__ = ["GREEN_LAGRANGE", "VON_KARMAN", "ShellKinematics"]

# Indices of the gradients a = G q.
UX, UY, VX, VY, WX, WY = range(6)
ROTATION = 6 + np.arange(9).reshape(3, 3)
V, Y = (15, 16), (17, 18)
N_GRADIENTS = 19

# Indices of the strains.
MEMBRANE = slice(0, 3)
DRILLING = slice(3, 6)
BENDING = slice(6, 18)
CORNER_ROTATION = 6 + np.arange(6).reshape(3, 2)
SIDE_MISMATCH = 12 + np.arange(6).reshape(3, 2)
N_STRAINS = 18

SIDES = ((0, 1), (1, 2), (2, 0))

Terms = Iterator[tuple[int, int, int, float]]


@dataclass(frozen=True, eq=False)
class ShellKinematics:
    """Kinematics of a shell.

    gradients : tuple of int            the gradients in the quadratic strain
    form : (18, d, d)    N over these gradients
    rotation_limit : largest rotation relative to the body's frame, rad
    """

    gradients: tuple[int, ...]
    form: FloatArray
    rotation_limit: float

    def __post_init__(self) -> None:
        self.form.setflags(write=False)


def _drilling_terms() -> Terms:
    """Products (strain, gradient, gradient, coefficient) of the drilling d_i."""
    for row, theta in zip(range(DRILLING.start, DRILLING.stop), ROTATION, strict=True):
        for stretch in (UX, VY):
            yield row, stretch, VX, 1 / 12
            yield row, stretch, UY, -1 / 12
        for plane, slope in ((0, WX), (1, WY)):
            yield row, slope, theta[plane], -1 / 2
            yield row, V[plane], theta[plane], 5 / 6
            yield row, V[plane], Y[plane], -1 / 3
        yield row, V[0], WY, -1 / 6
        yield row, V[1], WX, 1 / 6


def _corner_terms() -> Terms:
    """Products of the bending rotations r_i."""
    for corner, (x, y) in enumerate(CORNER_ROTATION):
        theta = ROTATION[corner]
        yield x, UX, theta[0], 1 / 3
        yield y, VY, theta[1], 1 / 3
        for shear in (UY, VX):
            yield x, shear, theta[1], 1 / 6
            yield y, shear, theta[0], 1 / 6
        for other in np.delete(ROTATION, corner, axis=0):
            yield x, other[1], theta[2], -1 / 6
            yield x, other[2], theta[1], 1 / 6
            yield y, other[2], theta[0], -1 / 6
            yield y, other[0], theta[2], 1 / 6


def _side_terms() -> Terms:
    """Products of the mismatches m_k."""
    for (x, y), ends in zip(SIDE_MISMATCH, SIDES, strict=True):
        for end in ends:
            theta = ROTATION[end]
            # b_k = (t_y, -t_x), with t the mean of two ends.
            for row, along, across in ((x, UX, VX), (y, UY, VY)):
                yield row, along, theta[1], 1 / 6
                yield row, across, theta[0], -1 / 6
            for other in ends:
                yield x, theta[0], ROTATION[other][2], -1 / 24
                yield y, theta[1], ROTATION[other][2], -1 / 24


def _finite_rotation_form() -> FloatArray:
    form = np.zeros((N_STRAINS, N_GRADIENTS, N_GRADIENTS))
    form[MEMBRANE, :6, :6] = green_lagrange_form(3, ((0, 0), (1, 1), (0, 1)))
    for terms in (_drilling_terms(), _corner_terms(), _side_terms()):
        for strain, first, second, coefficient in terms:
            form[strain, first, second] += coefficient
            form[strain, second, first] += coefficient
    return form


def _slope_form() -> FloatArray:
    form = np.zeros((N_STRAINS, 2, 2))
    form[MEMBRANE] = green_lagrange_form(1, ((0, 0), (1, 1), (0, 1)))
    return form


GREEN_LAGRANGE = ShellKinematics(tuple(range(N_GRADIENTS)), _finite_rotation_form(), rotation_limit=0.5)
"""Finite rotations, for general use: any rigid rotation leaves strain of third order or higher."""

VON_KARMAN = ShellKinematics((WX, WY), _slope_form(), rotation_limit=0.3)
"""Slopes of the normal displacement in the membrane strain, linear curvature: for flat structures that bend
out of their plane.

A closed section that rotates in the plane of one of its walls is far too stiff, as the in-plane rotation is
missing.
"""
