"""Inertia of the condensed motion z, which follows the coordinates of a reduced body, to leading order.

In addition to its columns a body moves by `z(g)`, quadratic in the coordinates: a bent beam shortens. To
second order in g, three moments of z about the frame, with the interfaces at rest, enter the kinetic energy,

    s = sum m z,     c = sum m x cross z,     J: the change of the inertia tensor,     each `g G_i g / 2`,

    T_z = v . (ds/dt + w x s) + w . dc/dt + w J w / 2.

In mean axes, and with columns that contain the static shapes of the interfaces, s and c vanish: z is
K-orthogonal to those shapes, whose interface forces balance inertia. The remaining term, `w J w / 2`, is
added to blocks of the inertia Gram matrix of the same form. A body without axial columns thus has its
centrifugal stiffening; energy and momenta are conserved, at no cost in the run.

In a nodal-fixed frame the columns can nearly cancel motions of the frame. Velocities of z are not small
compared with the remainder, and the mass matrix would become indefinite: in this frame the inertia of z is
omitted. The missing stiffness is computed, and a warning reports it.

Source: derived here; theory page on tensors.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from supple.body import FlexibleBody, MeanAxisFrame
from supple.body.rigid_motion import nodal_rigid_modes
from supple.reduction.tensors import number_of_coordinates, unpack_symmetric

if TYPE_CHECKING:
    from supple.reduction.reduced_body import ReducedBody

Array = NDArray[np.float64]

N_MOMENTS = 12
"""s and c (3 each), and J_ij, i <= j (6)."""
NEGLIGIBLE = 1e-3
"""Largest ratio of the moments s (times the body's size) and c to J that counts as zero."""
_FIRST, _SECOND = np.triu_indices(3)
_PLACE = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
_DIAGONAL = [0, 3, 5]


def condensed_moments(body: FlexibleBody, fields: Array, amplitudes: Array) -> Array:
    """Second derivatives of s, c and J_ij (i <= j) with respect to the coordinates, by pairs, (12, r(r+1)/2).

        s = Phi_t^T M z,     c = Phi_w0^T M z,
        J_ij = Phi_w0,i^T M (e_j x z) + Phi_w0,j^T M (e_i x z)

    Phi_t, Phi_w0: unit translations and rotations of the undeformed body. The kinetic energy of a rotation w
    thus changes by w J w / 2 to first order in z.

    body : FlexibleBody
    fields : (n_nodal, m);  amplitudes : (m, r(r+1)/2)     of a `CondensedMotion`
    """
    d, n_nodes = body.dofs_per_node, len(body.nodes)
    momenta = body.nodal_mass @ nodal_rigid_modes(body.nodes, d)
    # Dimensions: translation and rotation, three components each.
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


def condensed_gram(body: ReducedBody) -> Array:
    """The inertia Gram matrix (6 + 4r, 6 + 4r) of a reduced body, with its condensed motion.

    Two fields `g_k w_i` and `g_l w_j` are coupled by `w J w / 2`.
    """
    moments = _moments(body)
    if moments is None or not _keeps_definite(body, moments):
        return body.gram
    r = body.r
    gram, turned = np.array(body.gram), slice(6, 6 + 3 * r)
    J = unpack_symmetric(moments[6:], body.r)
    gram[turned, turned] += J[_PLACE].transpose(2, 0, 3, 1).reshape(3 * r, 3 * r) / 2
    return gram


def missing_centrifugal_stiffness(body: ReducedBody) -> Array:
    """Largest share of the stiffness missing per squared angular velocity about each body axis, (3,).

        max over g of  (- g J_ii g / 2) / (g K g),     zero where z has inertia

    The axes go through the frame's origin, which rests in a nodal-fixed frame.
    """
    moments = _moments(body)
    if moments is None or _keeps_definite(body, moments):
        return np.zeros(3)
    values, vectors = np.linalg.eigh(body.stiffness)
    unit = vectors / np.sqrt(values)
    about_axes = unpack_symmetric(moments[6:], body.r)[_DIAGONAL]
    return np.maximum([np.linalg.eigvalsh(-unit.T @ J @ unit / 2)[-1] for J in about_axes], 0.0)


def _moments(body: ReducedBody) -> Array | None:
    """Moments of the body's condensed motion; None for a linearised body."""
    return None if body.is_linear or body.condensed is None else body.condensed.moments


def _keeps_definite(body: ReducedBody, moments: Array) -> bool:
    """Whether z leaves the centre of mass and the mean orientation at rest."""
    if not isinstance(body.frame, MeanAxisFrame):
        return False
    size = float(np.linalg.norm(np.ptp(body.nodes, axis=0)))
    frame = max(np.abs(moments[:3]).max(initial=0.0) * size, np.abs(moments[3:6]).max(initial=0.0))
    return bool(frame <= NEGLIGIBLE * np.abs(moments[6:]).max(initial=0.0))
