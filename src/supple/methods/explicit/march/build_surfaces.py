"""Arrays of contacts between parts: points of modal surfaces, stiffness, step limits.

The points of a modal part, on either side of a contact, become massless explicit nodes tied to it. The frame
determines their positions, as for all tied nodes, and their forces act on the frame.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.errors import ModelError
from supple.machine import SurfaceContact, System
from supple.mesh.outer_faces import is_shell, outer_triangles
from supple.methods.explicit.march.touching_surface import (
    TouchingSurface,
    corner_stiffness,
    located,
    touching_surface,
)
from supple.methods.explicit.modal_frame import ModalFrame
from supple.methods.explicit.start_motion import undeformed


@dataclass(frozen=True, eq=False)
class TiedNodes:
    """Explicit nodes (n,), each tied to nodes `corners` (n, c) of a modal part with weights (n, c)."""

    part: str
    nodes: IntArray
    corners: IntArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class MarchNodes:
    """Nodes of the model.

    numbers : node numbers of each explicit part;   x : (N, 3) at the start;   mass : (N,) kg
    skins : points of modal parts in contact;   tied : all nodes tied to frames
    short : step limit of the explicit nodes, s;   pressed : (N,) stiffness of obstacles at each, N/m
    """

    numbers: Mapping[str, IntArray]
    x: FloatArray
    mass: FloatArray
    skins: Sequence[TiedNodes]
    tied: Sequence[TiedNodes]
    short: float
    pressed: FloatArray


def modal_skins(system: System, first: int) -> list[TiedNodes]:
    """The points of each modal part in contacts with other parts, numbered from `first` on."""
    skins = []
    ends = [end for each in system.surface_contacts for end in (each.nodes, each.surface)]
    for body in (placed.body for placed in system.bodies):
        own = [system.node_numbers(end) for end in ends if end.body == body.name]
        if own and body.kind == "modal":
            corners = np.unique(np.concatenate(own)).astype(int)
            n = len(corners)
            skins.append(TiedNodes(body.name, first + np.arange(n), corners[:, None], np.ones((n, 1))))
            first += n
    return skins


def touching_surfaces(
    system: System, given: MarchNodes, frames: Mapping[str, ModalFrame]
) -> tuple[tuple[TouchingSurface, ...], float, dict[str, FloatArray]]:
    """Contacts between parts, and their effect on the step limits with all of them closed.

    Returns the surfaces; the largest stiffness of surfaces plus that of obstacles over mass of explicit nodes
    without ties, 1/s^2; and for each frame the stiffness (6 + k, 6 + k) of the penalties on nodes tied to it.
    """
    x, mass, tied, pressed = given.x, given.mass, given.tied, given.pressed
    number = dict(given.numbers)
    for skin in given.skins:
        number[skin.part] = np.full(len(system.placed(skin.part).body.nodes), -1)
        number[skin.part][skin.corners[:, 0]] = skin.nodes
    bears = _bearing(tied, frames, mass, given.short)
    on_nodes = np.zeros(len(x))
    surfaces = []
    for contact in system.surface_contacts:
        nodes = number[contact.nodes.body][system.node_numbers(contact.nodes)]
        mesh = system.mesh_of(contact.surface.body)
        faces = outer_triangles(mesh, system.node_numbers(contact.surface))
        if not len(faces):
            raise ModelError(
                f"contact with '{contact.surface}': no outer face has all its corners in this node set; "
                "name the nodes of a surface"
            )
        corners = number[contact.surface.body][faces]
        stiffness = _stiffness(contact, bears, nodes, corners, x)
        whole = undeformed(system.placed(contact.nodes.body))
        centre = whole.mean(axis=0) if is_shell(mesh) else None
        surface = touching_surface(nodes, stiffness, corners, x, centre)
        _check_outside(contact, surface, x)
        surfaces.append(surface)
        np.add.at(on_nodes, nodes, stiffness)
        for node, bound in corner_stiffness(x[nodes], stiffness, corners, x).items():
            on_nodes[node] += bound
    # Factor 2: (a - b)^2 <= 2 a^2 + 2 b^2.
    on_nodes *= 2.0
    tied_here = np.zeros(len(x), dtype=bool)
    penalties: dict[str, FloatArray] = {}
    for each in tied:
        tied_here[each.nodes] = True
        # (sum w u)^2 <= sum |w| sum |w| u^2; weights of a mortar have both signs.
        shares = np.abs(each.weights)
        spread = (
            (on_nodes + pressed)[each.nodes][:, None] * shares.sum(axis=1, keepdims=True) * shares
        ).ravel()
        if spread.any():
            own = frames[each.part].penalty_stiffness(each.corners.ravel(), spread)
            penalties[each.part] = penalties[each.part] + own if each.part in penalties else own
    free = ~tied_here & (mass > 0)
    rate = sum(float((each[free] / mass[free]).max(initial=0.0)) for each in (on_nodes, pressed))
    return tuple(surfaces), rate, penalties


def _bearing(
    tied: Sequence[TiedNodes], frames: Mapping[str, ModalFrame], mass: FloatArray, short: float
) -> FloatArray:
    """Stiffness (N,) for which each node alone would vibrate at the step limit, N/m."""
    bears = mass * (2 / short) ** 2
    for each in tied:
        own = frames[each.part].stiffness_at(each.corners.ravel(), 1.0).reshape(each.corners.shape)
        bears[each.nodes] = own.min(axis=1)
    return bears


def _stiffness(
    contact: SurfaceContact, bears: FloatArray, nodes: IntArray, corners: IntArray, x: FloatArray
) -> FloatArray:
    if contact.stiffness is not None:
        return np.full(len(nodes), contact.stiffness)
    shares = corner_stiffness(x[nodes], np.ones(len(nodes)), corners, x)
    weakest = min(bears[node] / share for node, share in shares.items())
    return contact.fraction * np.minimum(bears[nodes], weakest)


def _check_outside(contact: SurfaceContact, surface: TouchingSurface, x: FloatArray) -> None:
    gap = np.asarray(located(surface, x.T).gap)
    size = float(np.linalg.norm(np.ptp(x[np.asarray(surface.corners).ravel()], axis=0)))
    inside = (gap < -1e-6 * size) & (gap > -float(surface.reach))
    if inside.any():
        worst = int(np.where(inside, gap, 0.0).argmin())
        point = np.array2string(x[np.asarray(surface.nodes)[worst]], precision=6)
        raise ModelError(
            f"contact of '{contact.nodes}' with '{contact.surface}': the node at {point} starts "
            f"{-gap[worst]:.3g} inside the surface; move the parts apart"
        )
