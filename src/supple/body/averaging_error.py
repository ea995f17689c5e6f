"""Error of an averaging interface on a deformable section that has rotated relative to the frame.

The nodal forces that represent a moment m, F_a = w_a (J^-1 m) x r_a, keep their directions in the undeformed
body. On a section rotated by phi about the axis n of m, these forces include a self-equilibrated part
m phi p, p_a = - n x F_a(n), which deforms the section by d = phi m K^-1 p with the body's stiffness K. The
mean rotation is weighted with F_a(n), too, and depends on d: the rotation of the joint is sin phi + phi p.d.
With c = p K^-1 p, the strain energy U(phi) without d, and the potential

    Pi = U(phi) + d K d / 2 - m (phi + phi p.d),

the rotation of the joint is too large by m c phi^2, and the moment on the body is too large by m^2 c phi.

Example: a beam of rotational compliance C = L / E I has the averaging interface at one end, and a force and
the body's frame at the other. Then m = 2 phi / C, and each of the two errors changes the relative deflection
by 3 phi^2 c / C. Under a moment alone, m = phi / C, the relative error of the rotation is 2 phi^2 c / C.
Source: derived here; theory page on interfaces.
"""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray
from supple.body.flexible_body import FlexibleBody
from supple.body.interface import BodyInterface, moves_rigidly_with

DEFLECTION_ERROR = 6.0
"""Relative error of the deflection of a beam under a force at its end, per phi^2 c / C."""


def section_softness(body: FlexibleBody, interface: BodyInterface) -> FloatArray:
    """Softness c / C (3,) of an averaging interface for moments about the axes of the body.

    Zeros for other interfaces, and in a linear body.
    C : rotation of the interface per moment on it. The body's first interface that does not move with it is
        fixed; without one, inertia balances the moment
    """
    # cubic_turn > 0 only for interfaces that average displacements, whose rotation freedom is sin(phi).
    if body.is_linear or interface.cubic_turn <= 0:
        return np.zeros(3)
    others = [other for other in body.interfaces if not moves_rigidly_with(other, interface)]
    held = others[0].motion if others else (body.mass @ body.rigid_modes).T
    rotation = interface.motion[3:]
    moments = rotation.T.toarray()
    forces = (body.expansion @ moments).reshape(len(body.nodes), body.dofs_per_node, 3)
    pulling = np.zeros(forces.shape)
    for axis, unit in enumerate(np.eye(3)):
        pulling[:, :3, axis] = -np.cross(unit, forces[:, :3, axis])
    pulling = body.expansion.T @ pulling.reshape(-1, 3)
    responses = body.constrained(held).solve(np.hstack([moments, pulling]))
    compliance = np.sum(moments * responses[:, :3], axis=0)
    return np.sum(pulling * responses[:, 3:], axis=0) / compliance
