"""Support of an intrinsic body's root by the joints of a machine: fixed, free, or prescribed motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from supple.errors import ModelError
from supple.machine import (
    GROUND,
    Ball,
    Cylindrical,
    Fixed,
    Joint,
    JointFriction,
    Placed,
    PrescribedRotation,
    PrescribedTranslation,
    Prismatic,
    Revolute,
    System,
)
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody, body_of
from supple.methods.intrinsic.line_system import RootDrive
from supple.methods.intrinsic.root_support import BALL, CLAMPED, FREE, RootSupport

SAME = 1e-9
"""Largest difference of the projections on free twists for which two supports are equal."""


class SupportedRoot(NamedTuple):
    """The joint that supports a root, if any, and its prescribed motion, if any."""

    joint: Joint | None
    drive: RootDrive | None


def is_joined(system: System) -> bool:
    """Whether `JoinedEngine` must integrate the machine.

    True for bodies of other kinds, joints between bodies or at a body with a free root, controllers, and
    friction that depends on a joint force. False if every body is an intrinsic one whose root is free or
    supported by the ground.
    """
    if system.controllers or any(isinstance(load, JointFriction) for load in system.loads):
        return True
    for placed in system.bodies:
        if not isinstance(placed.body, IntrinsicBody):
            return True
        joints = joints_of(system, placed.body.name)
        if joints and placed.body.support.free.shape[1] == 6:
            return True
    return any(GROUND not in (joint.first, joint.second) for joint in system.joints)


def joints_of(system: System, body: str) -> list[Joint]:
    """The joints with an end on a body."""
    return [joint for joint in system.joints if body in (joint.first.body, joint.second.body)]


def supported_root(system: System, placed: Placed) -> SupportedRoot:
    """Support of the root of a body; ModelError for joints that intrinsic bodies do not support.

    An intrinsic body supports one joint, between its root and the ground. Its modes must have been computed
    for the support by this joint.
    """
    body = body_of(placed)
    joints = joints_of(system, body.name)
    if len(joints) > 1:
        raise ModelError(
            f"intrinsic body '{body.name}' has {len(joints)} joints ("
            + ", ".join(f"'{joint.name}'" for joint in joints)
            + "), but its modes belong to a supported root: place released(body), for joints at any station"
        )
    joint = joints[0] if joints else None
    support, drive = (FREE, None) if joint is None else _support(placed, joint)
    own, needed = (each @ np.linalg.pinv(each) for each in (body.support.free, support.free))
    if np.abs(own - needed).max() > SAME:
        root = "without a joint" if joint is None else f"with joint '{joint.name}'"
        raise ModelError(
            f"intrinsic body '{body.name}': in its modes the root has {_freedom(body.support)}, but {root} "
            f"it has {_freedom(support)}: condense the body with the support of the joint (CLAMPED, FREE, "
            "BALL, hinged(axis), sliding(axis)), or place released(body), which supports any joint"
        )
    return SupportedRoot(joint, drive)


def _freedom(support: RootSupport) -> str:
    k = support.free.shape[1]
    return "no freedom" if k == 0 else f"{k} of its 6 freedoms"


def _support(placed: Placed, joint: Joint) -> tuple[RootSupport, RootDrive | None]:
    body = body_of(placed)
    own = joint.first if joint.second == GROUND else joint.second
    where = f"intrinsic body '{body.name}', joint '{joint.name}'"
    station = body.interface(own.interface)
    if station.number != 0:
        raise ModelError(
            f"{where}: it acts on station {station.number} ('{own.interface}'), but the modes belong to a "
            "supported root: place released(body), which supports joints at any station"
        )
    axis = placed.assembly.rotation.T @ joint.initial_axes[:, 2]
    turn, shift = np.concatenate([np.zeros(3), axis]), np.concatenate([axis, np.zeros(3)])
    free: RootSupport | None = None
    match joint:
        case PrescribedRotation():
            return CLAMPED, _drive(placed, joint, turn, own)
        case PrescribedTranslation():
            return CLAMPED, _drive(placed, joint, shift, own)
        case Fixed():
            free = CLAMPED
        case Ball():
            free = BALL
        case Revolute():
            free = RootSupport(turn[:, None])
        case Prismatic():
            free = RootSupport(shift[:, None])
        case Cylindrical():
            free = RootSupport(np.column_stack([shift, turn]))
    if free is None:
        raise ModelError(
            f"{where}: a {type(joint).__name__} joint has free directions not fixed in the root's axes; "
            "place released(body), which supports any joint"
        )
    return free, None


def _drive(placed: Placed, joint: Joint, screw: np.ndarray, own: object) -> RootDrive:
    # The second end moves relative to the first: a body at the first end moves the other way.
    sign = 1.0 if own == joint.second else -1.0
    position, rotation = placed.assembly
    root = position + rotation @ body_of(placed).line.tree.points[0]
    assert joint.law is not None
    return RootDrive(sign * screw, joint.law, rotation, root)
