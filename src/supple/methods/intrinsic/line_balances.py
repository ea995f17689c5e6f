"""Energies and momenta of an intrinsic body over time."""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray
from supple.equations.checks.energy import Balances, body_balances
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.methods.intrinsic.lumped_inertia import first_moments
from supple.methods.intrinsic.station_motion import driven_twists

__all__ = ["line_balances"]


@body_balances.register
def line_balances(body: IntrinsicBody, motion: IntrinsicMotion, gravity: FloatArray) -> Balances:
    """Energies and momenta (t, ...) of a line whose stations move with twists x_1 and momenta p = M x_1:

        T = p.x_1 / 2,   U = q_2.q_2 / 2,   P = sum R_i p_v,i,   L = sum r_i x R_i p_v,i + R_i p_w,i

    The potential is -g.sum(m_i r_i + R_i s_i) with the masses m_i and first moments s_i of the stations.
    Source: [Wang2015] (12)-(14): the modes are orthogonal by mass and flexibility.
    """
    n = body.line.n
    rotations, positions = body.places(motion)
    twists = driven_twists(body.model, body.line.tree.points[0], motion)
    momenta = (twists.reshape(-1, 6 * n) @ body.line.mass).reshape(twists.shape)
    linear, own = (np.einsum("tnij,tnj->tni", rotations, part) for part in np.split(momenta, 2, axis=-1))
    q2 = body.forces_of(motion.coordinates)
    masses = body.line.translating
    # A station's block is [m 1; s x], and s x is skew-symmetric.
    centres = np.einsum("nij,tnj->ti", masses[:, :3], positions)
    centres += np.einsum("tnij,nj->ti", rotations, first_moments(masses))
    return Balances(
        kinetic=0.5 * np.einsum("tni,tni->t", momenta, twists),
        strain=0.5 * np.einsum("te,te->t", q2, q2),
        potential=-centres @ gravity,
        momentum=linear.sum(axis=1),
        angular_momentum=(own + np.cross(positions, linear)).sum(axis=1),
    )
