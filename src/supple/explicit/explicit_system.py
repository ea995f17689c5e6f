"""An explicit system: sub-domains placed in space, tied, in contact, loaded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from supple.arguments import check_fields
from supple.errors import ModelError, did_you_mean
from supple.explicit.collocated import Collocated
from supple.explicit.continuity import EveryNode, MeanMotion
from supple.explicit.explicit_shell import ExplicitShell
from supple.explicit.explicit_subdomain import ExplicitSubdomain
from supple.explicit.modal_subdomain import ModalSubdomain
from supple.explicit.mortar import Mortar
from supple.explicit.obstacles import Obstacle
from supple.machine import At
from supple.machine.placement import rotation_matrix, space_vector
from supple.mesh import Mesh

__all__ = ["Contact", "ExplicitSystem", "NodalForce", "Part", "Support", "SurfaceContact", "Tie"]

Subdomain = ModalSubdomain | ExplicitSubdomain | ExplicitShell


@dataclass(frozen=True, eq=False)
class Part:
    """A sub-domain as it stands and moves at first, as a rigid body.

    position : (3,) of the mesh origin;   rotation : (3,) vector, rad, or (3, 3)
    velocity : (3,) of the mesh origin;   angular_velocity : (3,) in space, rad/s
    """

    subdomain: Subdomain
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    rotation: np.ndarray = field(default_factory=lambda: np.zeros(3))
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    angular_velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        for name in ("position", "velocity", "angular_velocity"):
            object.__setattr__(self, name, space_vector(f"{name} of part '{self.name}'", getattr(self, name)))
        object.__setattr__(
            self, "rotation", rotation_matrix(f"rotation of part '{self.name}'", self.rotation)
        )

    @property
    def name(self) -> str:
        """Name of the sub-domain."""
        return self.subdomain.name

    @property
    def mesh(self) -> Mesh:
        """Of its elements."""
        body = self.subdomain
        model = body.body.model if isinstance(body, ModalSubdomain) else body.model
        if model is None:
            raise ModelError(
                f"part '{self.name}' has no mesh, only matrices: it cannot be tied, hit or loaded"
            )
        return model.mesh

    @property
    def nodes(self) -> np.ndarray:
        """(N, 3) in space at the start."""
        body = self.subdomain
        own = body.body.nodes if isinstance(body, ModalSubdomain) else body.nodes
        return self.position + own @ self.rotation.T

    def velocities(self, points: np.ndarray) -> np.ndarray:
        """(n, 3) at the start, of points (n, 3) in space that move with it."""
        return self.velocity + np.cross(self.angular_velocity, points - self.position)


@dataclass(frozen=True)
class Tie:
    """Nodes that move with another part.

    nodes : At(sub-domain, node set)
    on : str    the part they are tied to: an explicit one, whose nodes they must meet, or a modal one, on
                whose material they hang wherever they lie on its cells. Nodes of a modal sub-domain are tied
                on a modal one only
    within : float      of the size of the set: how far from the part nodes may lie
    transfer : Collocated() or Mortar()     how nodes follow a modal part where the meshes do not match
    continuity : MeanMotion() or EveryNode(..)      what two modal sub-domains have in common there; explicit
                nodes hang position for position
    """

    nodes: At
    on: str
    within: float = 1e-6
    transfer: Collocated | Mortar = field(default_factory=Collocated)
    continuity: MeanMotion | EveryNode = field(default_factory=MeanMotion)

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True)
class Contact:
    """Nodes that must not enter a rigid obstacle, by penalty: force = stiffness * depth, at each node.

    nodes : At(part, node set)
    obstacle : RigidPlane(..), RigidCylinder(..) or RigidSphere(..)
    stiffness : N/m a node; where left out, `fraction` of what the node's mass bears at the step limit
    fraction : of m omega_max^2; it shortens the step by sqrt(1 + fraction)
    """

    nodes: At
    obstacle: Obstacle
    stiffness: float | None = None
    fraction: float = 0.2

    def __post_init__(self) -> None:
        check_fields(self)
        _check_stiffness(self.stiffness, self.fraction)


@dataclass(frozen=True)
class SurfaceContact:
    """Nodes of a part that must not enter the faces of another, by penalty: stiffness * depth at each.

    nodes : At(part, node set)
    surface : At(part, node set)    the outer faces all of whose corners are in the set; give the coarser,
        or stiffer, side
    stiffness : N/m a node; where left out, `fraction` of what the lightest node of either side bears at the
        step limit
    fraction : of m omega_max^2; it shortens the step by no more than sqrt(1 + 2 fraction)
    """

    nodes: At
    surface: At
    stiffness: float | None = None
    fraction: float = 0.2

    def __post_init__(self) -> None:
        check_fields(self)
        _check_stiffness(self.stiffness, self.fraction)
        if self.nodes.body == self.surface.body:
            raise ModelError(
                f"contact of '{self.nodes}' with '{self.surface}': both are of one part; a part does not "
                "touch itself here, make two parts of it"
            )


@dataclass(frozen=True)
class Support:
    """Nodes of an explicit sub-domain that are held.

    nodes : At(sub-domain, node set);   axes : which of x, y, z are held, 0 to 2; of shells also rotations
        about them, 3 to 5
    """

    nodes: At
    axes: tuple[int, ...] = (0, 1, 2)


@dataclass(frozen=True)
class NodalForce:
    """A force shared equally by the nodes of a set, N; it keeps its direction, or turns with a modal frame.

    nodes : At(part, node set);   force : (3,);   law : factor over time, 1 where left out
    follows : whether it turns with the frame; of modal parts only
    """

    nodes: At
    force: tuple[float, float, float]
    law: Any = 1.0
    follows: bool = False


@dataclass(frozen=True, eq=False)
class ExplicitSystem:
    """Sub-domains in space with what ties, holds, hits and loads them; checked when built.

    Raises ModelError: no part, a name used twice, an end that is not there.
    """

    parts: Sequence[Part | Subdomain]
    ties: Sequence[Tie] = ()
    contacts: Sequence[Contact | SurfaceContact] = ()
    supports: Sequence[Support] = ()
    forces: Sequence[NodalForce] = ()
    gravity: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        placed = tuple(part if isinstance(part, Part) else Part(part) for part in self.parts)
        object.__setattr__(self, "parts", placed)
        for item in ("ties", "contacts", "supports", "forces"):
            object.__setattr__(self, item, tuple(getattr(self, item)))
        object.__setattr__(self, "gravity", space_vector("gravity", self.gravity))
        names = [part.name for part in placed]
        if not names:
            raise ModelError("an explicit system needs at least one sub-domain")
        if len(set(names)) < len(names):
            raise ModelError(f"sub-domains need names of their own; there are {', '.join(names)}")
        for end in [each.nodes for each in (*self.ties, *self.contacts, *self.supports, *self.forces)]:
            self.node_numbers(end)
        for contact in self.surface_contacts:
            self.node_numbers(contact.surface)
        for support in self.supports:
            most = 6 if isinstance(self.part(support.nodes.body).subdomain, ExplicitShell) else 3
            if not all(0 <= axis < most for axis in support.axes):
                raise ModelError(
                    f"support of '{support.nodes}': axes {support.axes}; give 0 to {most - 1}, rotations of "
                    "shells alone"
                )
        for tie in self.ties:
            if tie.on == tie.nodes.body:
                raise ModelError(f"tie of '{tie.nodes}': a part is not tied to itself, give another as `on`")
            modal_on = isinstance(self.part(tie.on).subdomain, ModalSubdomain)
            if isinstance(tie.transfer, Mortar) and not modal_on:
                raise ModelError(
                    f"tie of '{tie.nodes}' on '{tie.on}': a mortar needs a modal part to hang on; explicit "
                    "parts are tied node to node"
                )
            modal = isinstance(self.part(tie.nodes.body).subdomain, ModalSubdomain)
            if modal and not modal_on:
                raise ModelError(
                    f"tie of '{tie.nodes}' on '{tie.on}': nodes of a modal sub-domain are tied on a modal "
                    f"one, and '{tie.on}' is explicit; tie its nodes on '{tie.nodes.body}' instead"
                )

    def part(self, name: str) -> Part:
        """The part of that name."""
        for part in self.parts:
            assert isinstance(part, Part)
            if part.name == name:
                return part
        raise ModelError(
            f"there is no sub-domain '{name}'" + did_you_mean(name, [p.name for p in self.placed])
        )

    @property
    def placed(self) -> tuple[Part, ...]:
        """The parts, all of them placed."""
        return tuple(part for part in self.parts if isinstance(part, Part))

    @property
    def modal_ties(self) -> tuple[Tie, ...]:
        """Ties of modal parts to each other."""
        return tuple(t for t in self.ties if isinstance(self.part(t.nodes.body).subdomain, ModalSubdomain))

    @property
    def rigid_contacts(self) -> tuple[Contact, ...]:
        """With rigid obstacles, in the order of these in results."""
        return tuple(contact for contact in self.contacts if isinstance(contact, Contact))

    @property
    def surface_contacts(self) -> tuple[SurfaceContact, ...]:
        """Between parts."""
        return tuple(contact for contact in self.contacts if isinstance(contact, SurfaceContact))

    def node_numbers(self, end: At) -> np.ndarray:
        """Of a node set, within its part."""
        sets = self.part(end.body).mesh.node_sets
        if end.interface not in sets:
            raise ModelError(
                f"sub-domain '{end.body}' has no node set '{end.interface}'"
                + did_you_mean(end.interface, list(sets))
            )
        return np.asarray(sets[end.interface])


def _check_stiffness(stiffness: float | None, fraction: float) -> None:
    if stiffness is not None and not stiffness > 0:
        raise ModelError(f"the stiffness of a contact must be positive, got {stiffness}")
    if not 0 < fraction <= 1:
        raise ModelError(f"the fraction of a contact must lie in (0, 1], got {fraction}")
