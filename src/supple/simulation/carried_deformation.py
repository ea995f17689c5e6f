"""Transfer of a body's deformation from one form or basis to another by its mass matrix.

If the new form has another kind of frame, the pose of this frame is computed first: its six conditions hold
for the unchanged shape in space. The coordinates x relative to this frame are then projected on the columns V
of a reduced body,

    gamma = V^T M ( x - z(gamma) ),       V^T M V = 1,

where M is the mass matrix and z the condensed motion outside the columns. Finally the interfaces are moved to
their positions by the smallest motion in the mass norm, as far as the columns allow: joints stay closed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from supple.arrays import FloatArray
from supple.body import BodyForm, FlexibleBody, Frame, FullBody, MeanAxisFrame
from supple.errors import ModelError
from supple.methods.explicit import ModalSubdomain
from supple.reduction import ReducedBody
from supple.simulation.stored_basis import coordinates_of_nodes, stored_basis

SAME_PLACE = 1e-6
"""Largest distance between nodes of two meshes that count as equal, relative to the size of the body."""
MOST_ROUNDS, CONVERGED = 30, 1e-14
"""Largest number of iterations, and the relative change below which iterations stop."""
SMALLEST_MOTION = 1e-3
"""Singular values of the columns' interface motions, relative to the largest; smaller ones are omitted."""


class Deformation(NamedTuple):
    """Nodal freedoms (n_nodal,) in the body's frame, and their rates."""

    nodal: FloatArray
    rates: FloatArray


class PlacedFrame(NamedTuple):
    """Pose and velocities of a floating frame, as in `Placed`."""

    position: FloatArray
    rotation: FloatArray
    velocity: FloatArray
    angular_velocity: FloatArray


@dataclass(frozen=True)
class ProjectionLoss:
    """The part of a deformation outside the columns of a body, in the mass norm.

    rms : float         RMS displacement of this part, weighted by mass, unit of length
    relative : float    norm of this part, relative to the norm of the whole deformation
    rate : float        norm of the rates outside the columns, relative to the norm of all rates
    gap : float         largest displacement of an interface due to the loss, unit of length; joints close it
        by rigid motion of the body
    """

    rms: float
    relative: float
    rate: float
    gap: float


class TransferredDeformation(NamedTuple):
    """State of a body in its new form."""

    frame: PlacedFrame
    coordinates: FloatArray
    rates: FloatArray
    loss: ProjectionLoss


def deformation_of(body: BodyForm, coordinates: FloatArray, rates: FloatArray) -> Deformation:
    """Deformation at coordinates (r,) and rates (r,), including the condensed motion."""
    linear, beside = body.nodal_fields(coordinates[None])
    moving, _ = body.nodal_fields(rates[None])
    if beside is None:
        return Deformation(linear[:, 0], moving[:, 0])
    return Deformation((linear + beside)[:, 0], moving[:, 0] + _following_rates(body, coordinates, rates))


def carried_deformation(
    then: BodyForm, state: PlacedFrame, deformation: Deformation, now: BodyForm, nodes: FloatArray
) -> TransferredDeformation:
    """The state of a body in another form or basis.

    Parameters
    ----------
    then, now : ReducedBody | FullBody | ModalSubdomain     form of the body in the motion, and its new form
    state, deformation : frame and nodal freedoms in the motion, in the units of `now`
    nodes : (N, 3)      nodes of `then` in the units of `now`

    Raises ModelError for bodies with different meshes, for a reduced body without a known full body, and for
    a condensed model with modal coordinates.
    """
    _check_same_mesh(now, nodes)
    body = _flexible(now)
    coordinates_of = coordinates_of_nodes(body)
    if _frame(then) != _frame(now) or now.kind == "full":
        state, deformation = _seen_from(body, _frame(now), state, deformation, coordinates_of)
    x, dx = (coordinates_of(each) for each in deformation)
    match now:
        case ReducedBody() if now.full is not None:
            vectors = stored_basis(now.full, now).vectors
        case ModalSubdomain():
            vectors = now.vectors
        case _:
            return TransferredDeformation(state, x, dx, ProjectionLoss(0.0, 0.0, 0.0, 0.0))
    weighted = (body.mass @ vectors).T
    back, ends, wanted = _interfaces(now, body)

    def on_columns(
        whole: FloatArray, beside: Callable[[FloatArray], FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        """Coordinates, and the remainder (n,) outside the columns and the condensed motion."""
        gamma, following = np.zeros(vectors.shape[1]), np.zeros_like(whole)
        for _ in range(MOST_ROUNDS):
            before, gamma = gamma, weighted @ (whole - following)
            gamma = gamma + back @ (wanted @ whole - ends @ gamma)
            following = coordinates_of(beside(gamma))
            if np.linalg.norm(gamma - before) <= CONVERGED * np.linalg.norm(gamma):
                break
        return gamma, whole - vectors @ gamma - following

    def follows(gamma: FloatArray) -> FloatArray:
        beside = now.nodal_fields(gamma[None])[1]
        return np.zeros(body.n_nodal) if beside is None else beside[:, 0]

    gamma, lost = on_columns(x, follows)
    rates, lost_rate = on_columns(dx, lambda rate: _following_rates(now, gamma, rate))
    gaps = (ends @ gamma - wanted @ x).reshape(-1, 6)[:, :3]
    return TransferredDeformation(
        state,
        gamma,
        rates,
        ProjectionLoss(
            rms=_norm(body, lost) / _norm(body, body.rigid_modes[:, 0]),  # by the root of the mass
            relative=_norm(body, lost) / (_norm(body, x) or 1.0),
            rate=_norm(body, lost_rate) / (_norm(body, dx) or 1.0),
            gap=float(np.linalg.norm(gaps, axis=1).max(initial=0.0)),
        ),
    )


def _interfaces(now: BodyForm, body: FlexibleBody) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Smallest coordinates (r, 6 p) for unit motions of p interfaces, and motions per unit coordinate.

    These are the motions of the interfaces per reduced coordinate (6 p, r) and per full coordinate (6 p, n).
    """
    ends = [each for each in body.interfaces if each.name in {own.name for own in now.interfaces}]
    if not ends:
        return np.zeros((now.n_coordinates, 0)), np.zeros((0, now.n_coordinates)), np.zeros((0, body.n))
    motions = (now.interface(each.name).motion for each in ends)
    moved = np.vstack([each if isinstance(each, np.ndarray) else each.toarray() for each in motions])
    wanted = np.vstack([each.motion.toarray() for each in ends])
    # Rotations are multiplied by the size of the body, so that they have the unit of length.
    scale = np.tile(np.repeat([1.0, float(np.ptp(body.nodes, axis=0).max())], 3), len(ends))
    back = np.linalg.pinv(scale[:, None] * moved, rcond=SMALLEST_MOTION) * scale
    return back, moved, wanted


def _following_rates(body: BodyForm, coordinates: FloatArray, rates: FloatArray) -> FloatArray:
    """Rates (n_nodal,) of the condensed motion `z = b(q, q)`: `2 b(q, dq/dt)`, by polarisation."""
    size, speed = np.linalg.norm(coordinates), np.linalg.norm(rates)
    if not (size and speed):
        return np.zeros(len(body.nodes) * body.dofs_per_node)
    unit = rates * (size / speed)
    beside = body.nodal_fields(np.array([coordinates + unit, coordinates, unit]))[1]
    if beside is None:
        return np.zeros(len(body.nodes) * body.dofs_per_node)
    return (beside[:, 0] - beside[:, 1] - beside[:, 2]) * (speed / size)


def _seen_from(
    body: FlexibleBody,
    frame: Frame,
    state: PlacedFrame,
    deformation: Deformation,
    coordinates_of: Callable[[FloatArray], FloatArray],
) -> tuple[PlacedFrame, Deformation]:
    """The same shape and motion in space, relative to a frame with conditions `D x = 0`, `D dx/dt = 0`."""
    conditions = frame.constraint(body)
    rigid = np.linalg.solve(conditions @ body.rigid_modes, conditions)

    def missed(nodal: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Translation and rotation of the frame after which a field satisfies the conditions, frame axes."""
        motion = rigid @ coordinates_of(nodal)
        return motion[:3], motion[3:]

    position, rotation = state.position, state.rotation
    size = float(np.ptp(body.nodes, axis=0).max())
    for _ in range(MOST_ROUNDS):
        nodal = _nodal(body, state, deformation.nodal, position, rotation)
        moved, turned = missed(nodal)
        position = position + rotation @ moved
        rotation = rotation @ Rotation.from_rotvec(turned).as_matrix()
        if max(np.abs(moved).max(), size * np.abs(turned).max()) <= CONVERGED * size:
            break
    nodal = _nodal(body, state, deformation.nodal, position, rotation)
    velocity, spin = state.velocity, rotation.T @ state.rotation @ state.angular_velocity
    for _ in range(MOST_ROUNDS):
        found = PlacedFrame(position, rotation, velocity, spin)
        rates = _nodal_rates(body, state, deformation, found, nodal)
        moved, turned = missed(rates)
        velocity, spin = velocity + rotation @ moved, spin + turned
        if np.abs(moved).max() + size * np.abs(turned).max() <= CONVERGED * np.abs(rates).max(initial=0.0):
            break
    found = PlacedFrame(position, rotation, velocity, spin)
    return found, Deformation(nodal, _nodal_rates(body, state, deformation, found, nodal))


def _nodal(
    body: FlexibleBody, state: PlacedFrame, nodal: FloatArray, position: FloatArray, rotation: FloatArray
) -> FloatArray:
    """Nodal freedoms (n_nodal,) of the same shape relative to another frame."""
    fields = nodal.reshape(-1, body.dofs_per_node)
    between = rotation.T @ state.rotation
    moved = (body.nodes + fields[:, :3]) @ between.T + rotation.T @ (state.position - position) - body.nodes
    if body.dofs_per_node == 3:
        return moved.ravel()
    turned = Rotation.from_matrix(between) * Rotation.from_rotvec(fields[:, 3:])
    return np.hstack([moved, turned.as_rotvec()]).ravel()


def _nodal_rates(
    body: FlexibleBody, state: PlacedFrame, deformation: Deformation, found: PlacedFrame, nodal: FloatArray
) -> FloatArray:
    """Rates (n_nodal,) of the same motion relative to another frame."""
    fields, rates = (each.reshape(-1, body.dofs_per_node) for each in deformation)
    between = found.rotation.T @ state.rotation
    own = np.cross(state.angular_velocity, body.nodes + fields[:, :3]) + rates[:, :3]
    there = body.nodes + nodal.reshape(fields.shape)[:, :3]
    moved = (
        own @ between.T
        + found.rotation.T @ (state.velocity - found.velocity)
        - np.cross(found.angular_velocity, there)
    )
    if body.dofs_per_node == 3:
        return moved.ravel()
    turned = (state.angular_velocity + rates[:, 3:]) @ between.T - found.angular_velocity
    return np.hstack([moved, turned]).ravel()


def _check_same_mesh(now: BodyForm, nodes: FloatArray) -> None:
    size = float(np.ptp(now.nodes, axis=0).max())
    if nodes.shape != now.nodes.shape:
        why = f"{len(nodes)} nodes in the motion, {len(now.nodes)} in the body"
    elif (apart := float(np.linalg.norm(nodes - now.nodes, axis=1).max(initial=0.0))) > SAME_PLACE * size:
        why = f"nodes of the motion are up to {apart:.3g} from its own"
    else:
        return
    raise ModelError(
        f"body '{now.name}' starts from a motion of another mesh ({why}); fields are transferred from node "
        "to node only: give it the mesh of the motion"
    )


def _frame(form: BodyForm) -> Frame:
    """The frame of a form; MeanAxisFrame for explicit parts, whose modes are without rigid motion."""
    return getattr(form, "frame", MeanAxisFrame())


def _flexible(now: BodyForm) -> FlexibleBody:
    match now:
        case ReducedBody() if now.full is None:
            raise ModelError(
                f"body '{now.name}' was read as reduced, without the mass matrix for a projection on its "
                "basis: reduce it here, or continue with the reduced body of the motion"
            )
        case ReducedBody() if now.full is not None:
            body = now.full.body
        case FullBody() | ModalSubdomain():
            body = now.body
        case _:
            raise ModelError(
                f"body '{now.name}' is {now.kind}: no deformation can be transferred to it; keep the form of "
                "the motion"
            )
    if body.n_modal:
        raise ModelError(
            f"body '{now.name}' is a condensed model, whose nodes do not show its modal coordinates: "
            "continue with the basis of the motion"
        )
    return body


def _norm(body: FlexibleBody, field: FloatArray) -> float:
    return float(np.sqrt(max(field @ (body.mass @ field), 0.0)))
