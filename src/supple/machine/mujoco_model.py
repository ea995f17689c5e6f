"""Import of machines from URDF and MJCF by MuJoCo: bodies, joints, limits, springs, dampers, ground.

A joint's angle or slide is relative to the configuration of the machine in the file (qpos0).
Source: E. Todorov, T. Erez, Y. Tassa, MuJoCo: a physics engine for model-based control, IROS 2012; the fields
of mjModel in MuJoCo's API reference.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
from scipy.spatial.transform import Rotation

from supple.arguments import checked_arguments
from supple.arrays import FloatArray
from supple.body import BodyForm, RigidBody
from supple.errors import ImportFormatError, ModelError
from supple.machine.ends import GROUND, At
from supple.machine.forces.bushing import Bushing
from supple.machine.forces.penalty import Penalty
from supple.machine.forces.stops import AngleStop, SlideStop
from supple.machine.forces.torsion_spring_damper import TorsionSpringDamper
from supple.machine.joints.ball import Ball
from supple.machine.joints.cylindrical import Cylindrical
from supple.machine.joints.fixed import Fixed
from supple.machine.joints.joint import Joint
from supple.machine.joints.prismatic import Prismatic
from supple.machine.joints.revolute import Revolute
from supple.machine.joints.universal import Universal
from supple.machine.system import Load, Placed, System

__all__ = ["MUJOCO_SUFFIXES", "features_not_read", "read_mujoco"]

MUJOCO_SUFFIXES = (".urdf", ".xml")

_FREE, _BALL, _SLIDE, _HINGE = 0, 1, 2, 3
_CONNECT, _WELD = 0, 1
_DISABLED = 1 | 2 | 8 | 32 | 64 | 128
"""Flags that disable constraints, connections, limits, springs, dampers and gravity"""
_NONLINEAR = ("jnt_stiffnesspoly", "dof_dampingpoly", "jnt_springyield")
"""Fields that older versions of MuJoCo do not have"""
_PARALLEL = 1e-6
_TURNED = 1e-3
"""Largest difference of rotations at which a weld counts as closed, as for joints at the start of a run."""
_PLACE = 1e-6
"""Largest distance of an interface from its joint, relative to the largest coordinate of the joints."""


class _Ends(TypedDict):
    first: At
    second: At


@dataclass(frozen=True, eq=False)
class _Group:
    """Welded bodies merged into one, in the frame of the first body.

    `centre` is the centre of mass, `inertia` the inertia about it, `points` the interfaces; `position` and
    `rotation` of the frame are global.
    """

    name: str
    position: FloatArray
    rotation: FloatArray
    mass: float
    centre: FloatArray
    inertia: FloatArray
    points: dict[str, FloatArray] = field(default_factory=dict)

    def local(self, point: FloatArray) -> FloatArray:
        """Coordinates (3,) of a global point in the frame of the group."""
        return self.rotation.T @ (point - self.position)


@checked_arguments
def read_mujoco(
    source: str | Path,
    *,
    bodies: Mapping[str, BodyForm] | None = None,
    leave_out: Collection[str] = (),
) -> System:
    """The machine of a URDF or MJCF file (.urdf, .xml), or of a text in these formats.

    Bodies are rigid; welded ones are merged. Hinges, slides and balls become joints of the same name, on
    interfaces of the same name. A slide and a hinge along one axis become a cylindrical joint, two
    perpendicular hinges at one point a universal joint. The constraints connect and weld become ball and
    fixed joints. Bodies of motion capture (mocap) belong to the ground. Limits become stops with the
    stiffness of MuJoCo. Stiffness and damping of joints become springs and dampers; those of balls and free
    joints become a bushing and a torsion damper about each axis.
    Shapes of bodies are not read, so the machine has no contacts.

    Parameters
    ----------
    bodies : replacements of rigid bodies by name, such as a ReducedBody, in the axes of the file's body; each
        joint needs an interface of its name at its position
    leave_out : features of the file to omit: "actuators", "tendons", "friction", "armature", "equality"
        (constraints other than connect and weld), "gravcomp" (gravity compensation of bodies), "fluid"
        (density and viscosity around the bodies), "flex" (deformable objects), "flags" (that disable gravity,
        springs, dampers, limits or constraints), "limits" (of joint motions), "nonlinear" (terms of higher
        order in the stiffness and damping of joints, and yield of springs)
    Raises
    ------
    ImportFormatError   mujoco missing (install `supple[mujoco]`); a file that MuJoCo rejects
    ModelError          joints without an equivalent in `supple`; features that are not read and not in
                        `leave_out`; names in `leave_out` of no feature; replacements of bodies that are not
                        in the file, or whose interfaces are not at its joints
    """
    model, data = _compiled(source)
    reader = _Reader(model, data, limits="limits" not in leave_out)
    _check_left_out(reader, set(leave_out))
    for body in range(1, model.nbody):
        reader.connect(body)
    reader.close_loops()
    groups = reader.groups.values()
    placed = [_placed(group, (bodies or {}).get(group.name)) for group in groups]
    unknown = sorted(set(bodies or {}) - {group.name for group in groups})
    if unknown:
        known = ", ".join(f"'{group.name}'" for group in groups)
        raise ModelError(f"{reader.name}: no body '{unknown[0]}' to replace; the machine has {known}")
    gravity = np.array(model.opt.gravity)
    return System(bodies=placed, joints=reader.joints, loads=reader.loads, gravity=gravity)


def _compiled(source: str | Path) -> tuple[Any, Any]:
    try:
        mujoco: Any = import_module("mujoco")
    except ImportError as error:
        raise ImportFormatError(
            "URDF and MJCF files are read by the library mujoco; pip install 'supple[mujoco]', or build the "
            "machine in Python"
        ) from error
    is_text = isinstance(source, str) and source.lstrip().startswith("<")
    if not is_text and not Path(source).is_file():
        raise ImportFormatError(f"{source}: no such file; check its name and folder")
    try:
        made = (
            mujoco.MjModel.from_xml_string(source) if is_text else mujoco.MjModel.from_xml_path(str(source))
        )
    except ValueError as error:
        raise ImportFormatError(f"{'the text' if is_text else source}: MuJoCo rejects it: {error}") from error
    data = mujoco.MjData(made)
    mujoco.mj_kinematics(made, data)
    return made, data


def features_not_read(source: str | Path) -> tuple[str, ...]:
    """The features of a file that `leave_out` of `read_mujoco` must name."""
    return tuple(name for name, (n, _) in _features(_compiled(source)[0]).items() if n)


def _features(model: Any) -> dict[str, tuple[int, str]]:
    """Number of occurrences in the file and remedy, by name of the feature."""
    others = int(np.sum((model.eq_type != _CONNECT) & (model.eq_type != _WELD)))
    return {
        "actuators": (int(model.nu), "give the machine motors or controllers"),
        "tendons": (int(model.ntendon), "write them as springs"),
        "friction": (
            int(np.sum(model.dof_frictionloss > 0)),
            "add RevoluteFriction or PrismaticFriction (hinge-friction, slide-friction in a case file)",
        ),
        "nonlinear": (
            sum(int(np.count_nonzero(getattr(model, name, 0))) for name in _NONLINEAR),
            "write these stiffnesses and dampings of joints as TabledTorque or TabledForce",
        ),
        "armature": (
            int(np.sum(model.dof_armature > 0)),
            "of a joint to the ground, add it to the inertia of the body; of others, add a rotor and a Gear",
        ),
        "equality": (others, "write it as gears or joints"),
        "gravcomp": (int(np.sum(model.body_gravcomp != 0)), "write it as a load on the body"),
        "fluid": (int(model.opt.density > 0 or model.opt.viscosity > 0), "write its drag as loads"),
        "flex": (int(model.nflex), "give its body as a finite element mesh"),
        "flags": (
            int(model.opt.disableflags & _DISABLED).bit_count(),
            "remove them, and the forces that they disable, from the file",
        ),
    }


def _check_left_out(reader: _Reader, allowed: set[str]) -> None:
    there = _features(reader.model)
    known = [*there, "limits"]
    if unknown := sorted(allowed - {*known}):
        raise ModelError(
            f"{reader.name}: leave_out has no feature '{unknown[0]}'; there are: {', '.join(known)}"
        )
    missed = [(name, n, remedy) for name, (n, remedy) in there.items() if n and name not in allowed]
    if missed:
        listed = "; ".join(f"{name} ({n}): {remedy}" for name, n, remedy in missed)
        names = ", ".join(f'"{name}"' for name, _, _ in missed)
        raise ModelError(
            f"{reader.name}: features that affect the motion are not read: {listed}; or leave_out=[{names}]"
        )


class _Reader:
    """The compiled model, in the configuration of the file, and the joints and loads read so far.

    limits : whether limits of joints become stops
    """

    def __init__(self, model: Any, data: Any, *, limits: bool) -> None:
        self.model, self.data, self.limits = model, data, limits
        self.joints: list[Joint] = []
        self.loads: list[Load] = []
        self.name = bytes(model.names).split(b"\0")[0].decode() or "the machine"
        # Bodies of motion capture stand still unless a program moves them.
        weldid = np.array(model.body_weldid)
        self.weldid = np.where(model.body_mocapid[weldid] >= 0, 0, weldid)

    def label(self, addresses: Sequence[int], number: int, else_: str) -> str:
        """The name of an object in the file; `else_` for an unnamed object."""
        found = bytes(self.model.names)[addresses[number] :].split(b"\0")[0].decode()
        return found or else_

    def body_name(self, body: int) -> str:
        """The name of a body; a name with its number for an unnamed body."""
        return self.label(self.model.name_bodyadr, body, f"body_{body}")

    @cached_property
    def groups(self) -> dict[int, _Group]:
        """Groups of welded bodies, by the number of their first body, without bodies welded to the ground."""
        model, data = self.model, self.data
        result = {}
        for first in np.unique(self.weldid[1:]).tolist():
            if first == 0:
                continue
            members = np.flatnonzero(self.weldid == first)
            masses, centres = model.body_mass[members], data.xipos[members]
            turns = data.ximat[members].reshape(-1, 3, 3)
            mass = float(masses.sum())
            centre = masses @ centres / mass
            arms = centres - centre
            about = turns @ (model.body_inertia[members][:, :, None] * turns.swapaxes(1, 2))
            steiner = masses[:, None, None] * (
                np.einsum("ki,ki->k", arms, arms)[:, None, None] * np.eye(3)
                - arms[:, :, None] * arms[:, None]
            )
            axes = data.xmat[first].reshape(3, 3)
            place = np.array(data.xpos[first])
            name = self.body_name(first)
            inertia = axes.T @ (about + steiner).sum(axis=0) @ axes
            result[first] = _Group(
                name, place, np.array(axes), mass, axes.T @ (centre - place), 0.5 * (inertia + inertia.T)
            )
        return result

    def end(self, body: int, name: str, point: FloatArray) -> At:
        """Add an interface to a body and return its end; the ground for a body welded to the ground."""
        group = self.groups.get(int(self.weldid[body]))
        if group is None:
            return GROUND
        group.points[name] = group.local(point)
        return At(group.name, name)

    def connect(self, body: int) -> None:
        """Append the joint between a body and its parent, and the springs, dampers and stops of the joint."""
        model, data = self.model, self.data
        own = list(range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]))
        kinds = [int(model.jnt_type[j]) for j in own]
        forces = model.jnt_stiffness[own].any() or model.dof_damping[model.jnt_dofadr[own]].any()
        if not kinds or (kinds == [_FREE] and not forces):
            return
        name = self.label(model.name_jntadr, own[0], f"{self.body_name(body)}_joint")
        anchors, axes = data.xanchor[own], data.xaxis[own]
        first, second = (self.end(end, name, anchors[0]) for end in (model.body_parentid[body], body))
        ends: _Ends = {"first": first, "second": second}
        joint: Joint | None = None
        axis = tuple(axes[0].tolist())
        parallel = len(own) == 2 and np.linalg.norm(np.cross(axes[0], axes[1])) < _PARALLEL
        across = len(own) == 2 and abs(axes[0] @ axes[1]) < _PARALLEL
        together = len(own) == 2 and np.linalg.norm(np.cross(anchors[1] - anchors[0], axes[1])) < _PARALLEL
        if kinds == [_HINGE]:
            joint = Revolute(**ends, axis=axis, name=name)
        elif kinds == [_SLIDE]:
            joint = Prismatic(**ends, axis=axis, name=name)
        elif kinds == [_BALL]:
            joint = Ball(**ends, name=name)
        elif sorted(kinds) == [_SLIDE, _HINGE] and parallel and together:
            joint = Cylindrical(**ends, axis=axis, name=name)
        elif kinds == [_HINGE, _HINGE] and across and np.allclose(anchors[0], anchors[1]):
            joint = Universal(**ends, first_axis=axis, second_axis=tuple(axes[1].tolist()), name=name)
        elif kinds != [_FREE]:
            words = {_FREE: "free", _BALL: "ball", _SLIDE: "slide", _HINGE: "hinge"}
            raise ModelError(
                f"{self.name}: body '{self.body_name(body)}' has the joints "
                f"{' and '.join(words[kind] for kind in kinds)}, which no single joint combines; put a body "
                "of small mass between them"
            )
        self.joints += [] if joint is None else [joint]
        for j in own:
            self.loads += self._in_joint(j, ends, is_universal=isinstance(joint, Universal))

    def _in_joint(self, j: int, ends: _Ends, *, is_universal: bool) -> list[Load]:
        """Spring, damper and stop of a joint; ModelError for those that are not read."""
        model = self.model
        kind, dof = int(model.jnt_type[j]), int(model.jnt_dofadr[j])
        axis = tuple(self.data.xaxis[j].tolist())
        k, c = (float(np.ravel(values)[0]) for values in (model.jnt_stiffness[j], model.dof_damping[dof]))
        start = float(model.qpos0[model.jnt_qposadr[j]])
        rest = float(model.qpos_spring[model.jnt_qposadr[j]]) - start
        found: list[Load] = []
        is_limited = bool(model.jnt_limited[j]) and self.limits
        if (is_universal or kind == _BALL) and is_limited:
            raise ModelError(
                f"{self.name}: the limits of ball and universal joints are not read; omit them by "
                'leave_out=["limits"]'
            )
        if is_universal and (k or c):
            raise ModelError(
                f"{self.name}: springs and dampers in universal joints are not read; put a body of "
                "small mass between the two hinges"
            )
        if kind in (_BALL, _FREE) and (k or c):
            along = float(kind == _FREE)
            stiffness, damping = [along * k] * 3 + [k] * 3, [along * c] * 3 + [0.0] * 3
            found.append(Bushing(**ends, stiffness=stiffness, damping=damping))
            # A bushing damps the rate of the rotation vector, MuJoCo the angular velocity.
            axes = np.eye(3).tolist() if c else []
            found += [TorsionSpringDamper(**ends, axis=tuple(each), damping=c) for each in axes]
        elif kind == _HINGE and (k or c):
            if k and abs(rest) >= np.pi and not is_limited:
                raise ModelError(
                    f"{self.name}: the spring of joint '{self.label(model.name_jntadr, j, str(j))}' has no "
                    f"moment at {rest:.4g} rad from the position in the file; without limits, this must "
                    "be within half a revolution: change springref or ref, or limit the joint"
                )
            found.append(TorsionSpringDamper(**ends, axis=axis, stiffness=k, damping=c, rest_angle=rest))
        elif kind == _SLIDE and (k or c):
            stiffness, damping = (0, 0, k, 0, 0, 0), (0, 0, c, 0, 0, 0)
            offset = (0.0, 0.0, rest)
            found.append(Bushing(**ends, axis=axis, offset=offset, stiffness=stiffness, damping=damping))
        if is_limited:
            lower, upper = (float(value) - start for value in model.jnt_range[j])
            if kind == _HINGE and not -np.pi < lower <= upper < np.pi:
                raise ModelError(
                    f"{self.name}: joint '{self.label(model.name_jntadr, j, str(j))}' is limited to "
                    f"{lower:.4g} .. {upper:.4g} rad from its position in the file; stops must be within "
                    'half a revolution: omit the limits by leave_out=["limits"], or change the position'
                )
            stop = AngleStop if kind == _HINGE else SlideStop
            found.append(stop(**ends, axis=axis, lower=lower, upper=upper, penalty=self._penalty(j, dof)))
        return found

    def _penalty(self, j: int, dof: int) -> Penalty:
        """Penalty of a limit with MuJoCo's stiffness `k = I / (tau zeta)^2`.

        I is the effective inertia, tau the time constant and zeta the damping ratio in `solref`.
        """
        time, ratio = (float(value) for value in self.model.jnt_solref[j])
        inertia = 1 / max(float(self.model.dof_invweight0[dof]), np.finfo(float).tiny)
        rate = 1 / (time * ratio) ** 2 if time > 0 else -time  # negative numbers are stiffness and damping
        return Penalty(stiffness=inertia * rate)

    def close_loops(self) -> None:
        """Append joints for the active connect and weld constraints of the file."""
        model, data = self.model, self.data
        for number in range(model.neq):
            kind = int(model.eq_type[number])
            if kind not in (_CONNECT, _WELD) or not model.eq_active0[number]:
                continue
            bodies = [int(model.eq_obj1id[number]), int(model.eq_obj2id[number])]
            if int(model.eq_objtype[number]) == 6:  # sites
                sites, bodies = bodies, [int(model.site_bodyid[site]) for site in bodies]
                points = [np.array(data.site_xpos[site]) for site in sites]
                axes, held = data.site_xmat[sites], np.eye(3)
            else:
                axes, held, local = data.xmat[bodies], np.eye(3), model.eq_data[number]
                if local[6:10].any():  # rotation at which a weld holds the second body relative to the first
                    held = Rotation.from_quat(local[[7, 8, 9, 6]]).as_matrix()
                at = (local[:3], local[3:6]) if kind == _CONNECT else (local[3:6], local[:3])
                points = [
                    data.xpos[body] + data.xmat[body].reshape(3, 3) @ place
                    for body, place in zip(bodies, at, strict=True)
                ]
            name = self.label(model.name_eqadr, number, f"loop_{number + 1}")
            if any(joint.name == name for joint in self.joints):  # MuJoCo's names differ within one kind only
                name = f"{name}_loop"
            apart = held - axes[0].reshape(3, 3).T @ axes[1].reshape(3, 3)
            if kind == _WELD and np.abs(apart).max() > _TURNED:
                raise ModelError(
                    f"{self.name}: the weld '{name}' holds its bodies at another relative rotation than that "
                    "in the file (relpose, or the axes of its sites): place the bodies at this rotation"
                )
            if len({int(self.weldid[body]) for body in bodies}) == 1:  # within the ground or a welded group
                continue
            ends = [self.end(body, name, point) for body, point in zip(bodies, points, strict=True)]
            first, second = ends if ends[1] != GROUND else ends[::-1]
            self.joints.append((Ball if kind == _CONNECT else Fixed)(first=first, second=second, name=name))


def _placed(group: _Group, other: BodyForm | None) -> Placed:
    """The rigid body of a group, or its replacement; ModelError for a replacement that does not fit."""
    rigid = RigidBody(group.name, group.mass, group.centre, group.inertia, group.points)
    form = rigid if other is None else other
    if other is not None:
        if other.name != group.name:
            raise ModelError(
                f"body '{other.name}' replaces '{group.name}': give it the same name, which the joints use"
            )
        size = max(float(np.abs(list(group.points.values())).max(initial=0.0)), np.finfo(float).tiny)
        for name, point in group.points.items():
            off = float(np.linalg.norm(other.interface(name).position - point))
            if off > _PLACE * size:
                raise ModelError(
                    f"body '{group.name}': its interface '{name}' is {off:.3g} away from the joint, which is "
                    f"at {point.tolist()} in the axes of the file's body; move the mesh, or the interface"
                )
    return Placed(form, position=group.position, rotation=group.rotation)
