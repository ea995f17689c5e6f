"""Forces and moments that the joints of a system carry."""

from __future__ import annotations

import numpy as np

from supple.integrate import JOINT_AXES, Solution
from supple.machine import Joint, System

__all__ = ["joint_loads", "joint_meanings"]


def joint_loads(system: System, solution: Solution) -> dict[str, dict[str, np.ndarray]]:
    """Loads on the second end of each joint, along the joint axes that turn with its first end.

    Returns
    -------
    by joint, then "force" (t, 3) and "moment" (t, 3) at the second end's point, in the units of the model; of
    a joint that holds no direction, or no turn, there is no such entry
    """
    return {
        joint.name: {
            what: solution.joint_forces[joint.name][:, part]
            for what, part, is_held in (
                ("force", slice(0, 3), any(_holds_a_place(joint))),
                ("moment", slice(3, 6), not all(_holds_a_place(joint))),
            )
            if is_held
        }
        for joint in system.joints
    }


def joint_meanings(system: System) -> dict[str, dict[str, str]]:
    """By joint: the end that its forces act on, and the axes that they are along, in words."""
    return {joint.name: {"acts on": str(joint.second), "axes": JOINT_AXES} for joint in system.joints}


def _holds_a_place(joint: Joint) -> list[bool]:
    return [row.startswith("position") for row in joint.rows]
