"""Inertia, to leading order, of the condensed motion z of a reduced body.

The displacements of a reduced body are `V g + z(g)`, z quadratic in the coordinates g: a bent beam shortens.
To second order in g, the kinetic energy depends on three moments of z about the origin of the frame. The
interfaces do not move in z; v and w are the velocity and angular velocity of the frame:

    s = sum m z,     c = sum m x cross z,     J: the change of the inertia tensor,     each `g G_i g / 2`,

    T_z = v . (ds/dt + w x s) + w . dc/dt + w J w / 2.

In a mean-axis frame, and with columns that contain the static shapes of the interfaces, s and c vanish: z is
zero at the interfaces and K-orthogonal to the responses to interface forces that rigid-body inertia balances.
The remaining term, `w J w / 2`, has the form of blocks of the inertia Gram matrix and is added to them. A
body without axial columns then has its centrifugal stiffening; energy and momenta are conserved, and the run
costs no more.

In a nodal-fixed frame, velocities along the columns can nearly cancel the velocity of the frame. The velocity
of z is not small compared with the remainder, and would make the mass matrix indefinite. The inertia of z is
therefore omitted, also in a mean-axis frame if s or c is not negligible. The missing stiffness is computed,
and a warning reports it.

Source: derived here; theory page on tensors.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from supple.arrays import FloatArray
from supple.body import FlexibleBody, MeanAxisFrame
from supple.body.rigid_motion import nodal_rigid_modes
from supple.reduction.tensors import number_of_coordinates, unpack_symmetric

if TYPE_CHECKING:
    from supple.reduction.reduced_body import ReducedBody

N_MOMENTS = 12
"""Number of moments: s and c (3 each), and J_ij, i <= j (6)."""
NEGLIGIBLE = 1e-3
"""Largest entry of s (times the size of the body) and c, relative to the largest entry of J; above this value
the inertia of z is omitted."""
_FIRST, _SECOND = np.triu_indices(3)
_PLACE = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
_DIAGONAL = [0, 3, 5]


def condensed_moments(body: FlexibleBody, fields: FloatArray, amplitudes: FloatArray) -> FloatArray:
    """Second derivatives of s, c and J_ij (i <= j) with respect to the coordinates, by pairs, (12, r(r+1)/2).

        s = Phi_t^T M z,     c = Phi_w0^T M z,
        J_ij = Phi_w0,i^T M (e_j x z) + Phi_w0,j^T M (e_i x z)

    Phi_t, Phi_w0: unit translations and rotations of the undeformed body. In a rotation at angular velocity w
    the kinetic energy thus changes by w J w / 2, to first order in z.

    body : FlexibleBody
    fields : (n_nodal, m);  amplitudes : (m, r(r+1)/2)     of a `CondensedMotion`
    """
    d, n_nodes = body.dofs_per_node, len(body.nodes)
    momenta = body.nodal_mass @ nodal_rigid_modes(body.nodes, d)
    # Axes: node; translation or rotation; component; axis of the unit rotation.
    of_rotation = momenta.reshape(n_nodes, d // 3, 3, 6)[..., 3:]
    unit = np.eye(3)
    weights = np.zeros((n_nodes, d, N_MOMENTS))
    weights.reshape(-1, N_MOMENTS)[:, :6] = momenta
    for k, (i, j) in enumerate(zip(_FIRST, _SECOND, strict=True)):
        # b . (e x z) = z . (b x e)
        about_both = np.cross(of_rotation[..., i], unit[j]) + np.cross(of_rotation[..., j], unit[i])
        weights[:, :, 6 + k] = about_both.reshape(n_nodes, d)
    moments = (weights.reshape(-1, N_MOMENTS).T @ fields) @ amplitudes
    on_diagonal = np.equal(*np.triu_indices(number_of_coordinates(amplitudes.shape[1])))
    return moments * np.where(on_diagonal, 2.0, 1.0)


def condensed_gram(body: ReducedBody) -> FloatArray:
    """The inertia Gram matrix (6 + 4r, 6 + 4r) of a reduced body, with the inertia of z if it is included.

    The term `w J w / 2` couples the fields `g_k w_i` and `g_l w_j`.
    """
    moments = _moments(body)
    if moments is None or not _keeps_definite(body, moments):
        return body.gram
    r = body.r
    gram, turned = np.array(body.gram), slice(6, 6 + 3 * r)
    J = unpack_symmetric(moments[6:], body.r)
    gram[turned, turned] += J[_PLACE].transpose(2, 0, 3, 1).reshape(3 * r, 3 * r) / 2
    return gram


def missing_centrifugal_stiffness(body: ReducedBody) -> FloatArray:
    """Missing centrifugal stiffness relative to the stiffness, per squared angular velocity, (3,), s^2.

        max over g of  (- g J_ii g / 2) / (g K g),     zero where the inertia of z is included

    One value for the rotation about each axis of the body's frame, through the origin of the frame.
    """
    moments = _moments(body)
    if moments is None or _keeps_definite(body, moments):
        return np.zeros(3)
    values, vectors = np.linalg.eigh(body.stiffness)
    unit = vectors / np.sqrt(values)
    about_axes = unpack_symmetric(moments[6:], body.r)[_DIAGONAL]
    return np.maximum([np.linalg.eigvalsh(-unit.T @ J @ unit / 2)[-1] for J in about_axes], 0.0)


def _moments(body: ReducedBody) -> FloatArray | None:
    """Moments of the body's condensed motion; None for a linearised body."""
    return None if body.is_linear or body.condensed is None else body.condensed.moments


def _keeps_definite(body: ReducedBody, moments: FloatArray) -> bool:
    """True in a mean-axis frame with negligible s and c: the mass matrix with J is then definite."""
    if not isinstance(body.frame, MeanAxisFrame):
        return False
    size = float(np.linalg.norm(np.ptp(body.nodes, axis=0)))
    frame = max(np.abs(moments[:3]).max(initial=0.0) * size, np.abs(moments[3:6]).max(initial=0.0))
    return bool(frame <= NEGLIGIBLE * np.abs(moments[6:]).max(initial=0.0))
