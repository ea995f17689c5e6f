"""What an averaging interface on a section that yields costs, once the section has turned against the frame.

The nodal forces that stand for a moment m, F_a = w_a (J^-1 m) x r_a, keep the directions that they have in
the undeformed body. Of a section turned by phi about the axis n of m, the part p m phi, p_a = - n x F_a(n),
is self-equilibrated and pulls the section out of shape: by d = phi m K^-1 p. The mean rotation, taken in the
same directions, sees d as well: the joint stands where sin phi + phi p.d is. With c = p K^-1 p and the
potential

    Pi = U(phi) + d K d / 2 - m (phi + phi p.d),

the joint turns by m c phi^2 too much, and the body feels a moment that is too large by m^2 c phi.

A beam of compliance C = L / E I under a force at its other end, to which the frame is fixed: m = 2 phi / C.
The two give 3 phi^2 c / C of its deflection each. A moment alone, m = phi / C, gives 2 phi^2 c / C of the
rotation.
Source: this project's own; theory page on interfaces.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.body.flexible_body import FlexibleBody
from supple.body.interface import BodyInterface

__all__ = ["DEFLECTION_ERROR", "section_softness"]

Array = NDArray[np.float64]

DEFLECTION_ERROR = 6.0
"""Error of the deflection of a beam under a force at its end, by phi^2 c / C."""


def section_softness(body: FlexibleBody, interface: BodyInterface) -> Array:
    """C / C (3,) of an averaging interface about the axes of the body; zeros of one that stays in shape.

    C : compliance of its rotation to the moment, the next interface held, or inertia balancing it
    """
    # Only interfaces that average displacements have the arcsine of a rotation.
    if body.is_linear or interface.cubic_turn <= 0:
        return np.zeros(3)
    others = [other for other in body.interfaces if other is not interface]
    held = others[0].motion if others else (body.mass @ body.rigid_modes).T
    rotation = interface.motion[3:]
    moments = rotation.T.toarray()
    forces = (body.expansion @ moments).reshape(len(body.nodes), body.dofs_per_node, 3)
    pulling = np.zeros(forces.shape)
    for axis, unit in enumerate(np.eye(3)):
        pulling[:, :3, axis] = -np.cross(unit, forces[:, :3, axis])
    pulling = body.expansion.T @ pulling.reshape(-1, 3)
    answers = body.constrained(held).solve(np.hstack([moments, pulling]))
    compliance = np.sum(moments * answers[:, :3], axis=0)
    return np.sum(pulling * answers[:, 3:], axis=0) / compliance
