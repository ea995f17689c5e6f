"""An explicit system: sub-domains placed in space, tied, in contact, loaded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, get_args

import numpy as np

from supple.arguments import check_fields, check_instance, check_sequence
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

_SUBDOMAINS = (
    "a modal_subdomain, an explicit_subdomain or an explicit_shell; bodies in floating frames and intrinsic "
    "ones are simulated in a System"
)


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
        check_instance("Part, subdomain", self.subdomain, get_args(Subdomain), _SUBDOMAINS)
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

    Raises ModelError: no part, a name used twice, an end that is not there, a support of a modal part or of
        tied nodes, a force that cannot follow; ArgumentError: a body of another method.
    """

    used_with: ClassVar[str] = (
        "which simulate_explicit alone takes: statics, modes, batches and error estimates are of a System"
    )
    parts: Sequence[Part | Subdomain]
    ties: Sequence[Tie] = ()
    contacts: Sequence[Contact | SurfaceContact] = ()
    supports: Sequence[Support] = ()
    forces: Sequence[NodalForce] = ()
    gravity: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        check_sequence("ExplicitSystem, parts", self.parts, "a list of parts")
        placed = tuple(part if isinstance(part, Part) else Part(part) for part in self.parts)
        object.__setattr__(self, "parts", placed)
        for item, kinds in _ITEMS.items():
            check_sequence(f"ExplicitSystem, {item}", getattr(self, item), "a list")
            expected = " or ".join(kind.__name__ for kind in kinds)
            for number, each in enumerate(getattr(self, item)):
                check_instance(f"ExplicitSystem, {item}, number {number}", each, kinds, f"a {expected}")
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
            _check_support(self, support)
        for force in self.forces:
            if force.follows and not self.is_modal(force.nodes.body):
                raise ModelError(
                    f"force on '{force.nodes}': it follows the frame of a modal part, and "
                    f"'{force.nodes.body}' is explicit and has none; give it without `follows`, or on a "
                    "modal part"
                )
        for tie in self.ties:
            _check_tie(self, tie)

    def part(self, name: str) -> Part:
        """The part of that name."""
        for part in self.parts:
            assert isinstance(part, Part)
            if part.name == name:
                return part
        raise ModelError(
            f"there is no sub-domain '{name}'" + did_you_mean(name, [p.name for p in self.placed])
        )

    def is_modal(self, name: str) -> bool:
        """Whether the part of that name is modal."""
        return isinstance(self.part(name).subdomain, ModalSubdomain)

    @property
    def placed(self) -> tuple[Part, ...]:
        """The parts, all of them placed."""
        return tuple(part for part in self.parts if isinstance(part, Part))

    @property
    def modal_ties(self) -> tuple[Tie, ...]:
        """Ties of modal parts to each other."""
        return tuple(tie for tie in self.ties if self.is_modal(tie.nodes.body))

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


_ITEMS: Mapping[str, tuple[type, ...]] = {
    "ties": (Tie,),
    "contacts": (Contact, SurfaceContact),
    "supports": (Support,),
    "forces": (NodalForce,),
}
"""What an explicit system has lists of."""


_APART = 1e-9
"""Of the fastest point: by how much the velocities of two tied modal parts may differ at the start."""
_ROUNDED = 1e-6
"""The same of explicit nodes, whose velocity is that of the part that leads them."""


def _check_support(system: ExplicitSystem, support: Support) -> None:
    part = support.nodes.body
    if system.is_modal(part):
        raise ModelError(
            f"support of '{support.nodes}': '{part}' is modal, and flies free on its frame; hold nodes of an "
            "explicit part that is tied on it elsewhere"
        )
    most = 6 if isinstance(system.part(part).subdomain, ExplicitShell) else 3
    if not all(0 <= axis < most for axis in support.axes):
        raise ModelError(
            f"support of '{support.nodes}': axes {support.axes}; give 0 to {most - 1}, rotations of shells "
            "alone"
        )


def _check_tie(system: ExplicitSystem, tie: Tie) -> None:
    what = f"tie of '{tie.nodes}' on '{tie.on}'"
    if tie.on == tie.nodes.body:
        raise ModelError(f"tie of '{tie.nodes}': a part is not tied to itself, give another as `on`")
    modal, modal_on = system.is_modal(tie.nodes.body), system.is_modal(tie.on)
    if isinstance(tie.transfer, Mortar) and not modal_on:
        raise ModelError(
            f"{what}: a mortar needs a modal part to hang on; explicit parts are tied node to node"
        )
    if modal and not modal_on:
        raise ModelError(
            f"{what}: nodes of a modal sub-domain are tied on a modal one, and '{tie.on}' is explicit; tie "
            f"its nodes on '{tie.nodes.body}' instead"
        )
    first, second = system.part(tie.nodes.body), system.part(tie.on)
    x = first.nodes[system.node_numbers(tie.nodes)]
    one, two = first.velocities(x), second.velocities(x)
    fastest = max(np.linalg.norm(one, axis=1).max(), np.linalg.norm(two, axis=1).max())
    apart = float(np.linalg.norm(one - two, axis=1).max())
    if apart > (_APART if modal else _ROUNDED) * fastest:
        raise ModelError(
            f"{what}: at the start the two sides fly apart by {apart:.3g} m/s; tied parts start as one: give "
            "both the velocity and angular velocity of one rigid motion"
        )


def _check_stiffness(stiffness: float | None, fraction: float) -> None:
    if stiffness is not None and not stiffness > 0:
        raise ModelError(f"the stiffness of a contact must be positive, got {stiffness}")
    if not 0 < fraction <= 1:
        raise ModelError(f"the fraction of a contact must lie in (0, 1], got {fraction}")
