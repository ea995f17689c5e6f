"""Supports and contacts of explicit parts: rigid obstacles, and surfaces of other parts."""

from __future__ import annotations

from dataclasses import dataclass

from supple.arguments import check_fields
from supple.errors import ModelError
from supple.machine.ends import At
from supple.machine.obstacles import Obstacle

__all__ = ["Contact", "Support", "SurfaceContact"]


@dataclass(frozen=True)
class Contact:
    """Penalty contact of nodes with a rigid obstacle: force = stiffness * depth at each node.

    nodes : At(part, node set)
    obstacle : RigidPlane(..), RigidCylinder(..) or RigidSphere(..); an obstacle with a mass moves freely, and
        belongs to one contact
    stiffness : N/m per node; default `fraction * m omega_max^2`, with the mass m of the node and the highest
        frequency omega_max, rad/s, of all finite-element parts
    fraction : in (0, 1]; the default stiffness divides the stable time step by at most sqrt(1 + fraction);
        a free obstacle lighter than `nodes` reduces the step further: give only nodes that can touch it
    Raises ModelError for a stiffness that is not positive, or a fraction outside (0, 1].
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
    """Penalty contact of nodes with the faces of another part: force = stiffness * depth at each node.

    nodes : At(part, node set)
    surface : At(part, node set)    outer faces with all corners in the set, on the coarser or
        stiffer part; a node touches a shell from the side on which the node starts
    stiffness : N/m per node; default `fraction * m omega_max^2` of the node, with omega_max as in `Contact`,
        or less where a node of `surface` permits less
    fraction : in (0, 1]; the default stiffness divides the stable time step by at most sqrt(1 + 2 fraction)
    Raises ModelError for both node sets on one part, a stiffness that is not positive, or a fraction outside
    (0, 1].
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
                f"contact of '{self.nodes}' with '{self.surface}': both belong to one part; contact of a "
                "part with itself is not supported; split the part in two"
            )


@dataclass(frozen=True)
class Support:
    """Nodes of a finite-element part that are fixed along some axes.

    nodes : At(part, node set);   axes : fixed directions, 0 to 2 for x, y, z; for shells also 3 to 5, the
        rotations about x, y, z
    """

    nodes: At
    axes: tuple[int, ...] = (0, 1, 2)

    def __post_init__(self) -> None:
        check_fields(self)


def _check_stiffness(stiffness: float | None, fraction: float) -> None:
    if stiffness is not None and not stiffness > 0:
        raise ModelError(f"the stiffness of a contact must be positive, got {stiffness}")
    if not 0 < fraction <= 1:
        raise ModelError(f"the fraction of a contact must lie in (0, 1], got {fraction}")
