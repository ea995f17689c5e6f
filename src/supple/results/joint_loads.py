"""Forces and moments that the joints of a system carry."""

from __future__ import annotations

import numpy as np

from supple.integrate import Solution
from supple.machine import System


def joint_loads(system: System, solution: Solution) -> dict[str, dict[str, np.ndarray]]:
    """Loads on the second end of each joint, in the joint's axes on the first end.

    Returns
    -------
    by joint, then "force" (t, k) in N and "moment" (t, k) in N m; k directions are held, and a joint that
    holds none has no such entry
    """
    loads: dict[str, dict[str, np.ndarray]] = {}
    for joint in system.joints:
        # Multipliers act on the first end; the second one receives their opposite.
        acting = -solution.joint_forces[joint.name]
        forces = np.array([row.startswith("position") for row in joint.rows])
        parts = {"force": acting[:, forces], "moment": acting[:, ~forces]}
        loads[joint.name] = {what: part for what, part in parts.items() if part.shape[1]}
    return loads
