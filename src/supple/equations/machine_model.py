"""A system as arrays, the input of the compiled equations of motion.

Every class here is a JAX pytree. Velocities of all bodies form one vector. Per body it contains the velocity
`dR/dt` of the frame's origin (global), the frame's angular velocity `omega` (body components) and the rates
`dg/dt`. Equal bodies, joints and forces are grouped, as arrays with a leading axis.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray
from supple.equations.floating_inertia import InertiaArrays
from supple.equations.places import Places, over
from supple.machine import TimeLaw
from supple.machine.laws.constant import Constant
from supple.machine.pose import Wrench
from supple.reduction.pair_blocks import PairBlocks

if TYPE_CHECKING:
    from supple.equations.nodal_load import PreparedLoad

STATIC = {"static": True}
"""Marks a field that belongs to the structure of a compiled program, not to its data."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class BodyGroup:
    """k rigid (r = 0) or reduced bodies of one size."""

    members: tuple[int, ...] = field(metadata=STATIC)
    """Numbers of the bodies in the system"""
    velocities: Places = field(metadata=STATIC)
    """6 + r each"""
    coordinates: Places = field(metadata=STATIC)
    gram: AnyArray
    """(k, 6 + 4r, 6 + 4r)"""
    inertia: InertiaArrays
    """The Gram matrix, rearranged for the equations of motion."""
    stiffness: AnyArray
    """(k, r, r)"""
    cubic: AnyArray | None
    """(k, n2, r) with n2 = r (r + 1) / 2, or (1, n2, r) for equal bodies; None for linear bodies"""
    quartic: AnyArray | PairBlocks | None
    """(k, n2, n2), or (1, n2, n2) for equal bodies, or `PairBlocks` of these; None for linear bodies"""
    damping: AnyArray
    """(k, r, r), undeformed"""
    damping_cubic: AnyArray | None
    """As in `ReducedBody`, for deformed bodies; None without strain-rate damping."""
    damping_quartic: AnyArray | PairBlocks | None
    coordinate_scale: AnyArray
    """(k,) size of a coordinate that moves the body by the system's length: `length sqrt(mass)`."""

    @property
    def r(self) -> int:
        """Number of deformation coordinates of each body."""
        return self.coordinates.size

    def of(self, per_body: AnyArray) -> AnyArray:
        """The rows of an array (nb, ...) for the group, (k, ...)."""
        first, last = self.members[0], self.members[-1]
        if self.members == tuple(range(first, last + 1)):
            return per_body[first : last + 1]
        return per_body[np.array(self.members)]


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Ends:
    """The k ends on one side of a group of joints or forces: markers of equal bodies, or of the ground."""

    bodies: tuple[int, ...] = field(metadata=STATIC)
    """Numbers of the bodies; all -1 for the ground"""
    velocities: Places | None = field(metadata=STATIC)
    """6 + r each; None for the ground"""
    coordinates: Places | None = field(metadata=STATIC)
    motion: AnyArray
    """(k, 6, r): displacement and rotation of the interface from the coordinates of its body"""
    cubic_turn: AnyArray
    """(k,): `c` of the interface's rotation vector, `theta (1 + c theta.theta)`"""
    offset: AnyArray
    """(k, 3)"""
    axes: AnyArray
    """(k, 3, 3)"""

    @property
    def on_ground(self) -> bool:
        """Whether these ends are fixed."""
        return self.velocities is None


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class JointGroup:
    """k joints of one kind between bodies of the same sizes."""

    constraint: Callable[..., jax.Array] = field(metadata=STATIC)
    rows: Places = field(metadata=STATIC)
    """Numbers of the constraint equations, with the redundant ones"""
    of_positions: tuple[bool, ...] = field(metadata=STATIC)
    """Whether each equation of a joint is a length; the others are angles"""
    law: TimeLaw | None
    """Law with a leading axis on all its numbers, or None"""
    first: Ends
    second: Ends


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class ForceGroup:
    """k forces of one kind between markers of bodies of the same sizes."""

    wrenches: Callable[..., tuple[Wrench, Wrench]] = field(metadata=STATIC)
    law: TimeLaw | None
    parameters: tuple[AnyArray, ...]
    first: Ends
    second: Ends
    reaction: Places | None = field(default=None, metadata=STATIC)
    """Constraint equations whose multipliers take the place of a law (`JointFriction`); else None"""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class NodalLoadArrays:
    """A load on nodes of a reduced body, or at an interface of any body."""

    body: int = field(metadata=STATIC)
    velocities: Places = field(metadata=STATIC)
    coordinates: Places = field(metadata=STATIC)
    load: PreparedLoad
    """`PreparedLoad`, which gives forces and their derivatives from the positions of the nodes"""
    positions: AnyArray
    """(k, 3) rest positions"""
    basis: AnyArray
    """(k, 3, r) displacements per coordinate"""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Reader:
    """A named reading of a controller: the relative motion of two ends, or the motion of the first."""

    name: str = field(metadata=STATIC)
    of_joint: bool = field(metadata=STATIC)
    first: Ends
    second: Ends
    near: AnyArray
    """As in `JointReading`"""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Actuator:
    """A named force element driven by a controller."""

    name: str = field(metadata=STATIC)
    shape: tuple[int, ...] = field(metadata=STATIC)
    """Shape of the output"""
    force: ForceGroup
    """The element, as a group of one"""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class ControlLaw:
    """A controller."""

    name: str = field(metadata=STATIC)
    outputs: Callable[..., Mapping[str, AnyArray]] | None = field(metadata=STATIC)
    """None for a sampled controller, whose outputs are held constant"""
    rates: Callable[..., AnyArray] | None = field(metadata=STATIC)
    readers: tuple[Reader, ...]
    actuators: tuple[Actuator, ...]
    initial: AnyArray
    """(k,) states at the start"""

    @property
    def driven_ends(self) -> list[Ends]:
        """Both ends of every element that the controller drives."""
        return [end for each in self.actuators for end in (each.force.first, each.force.second)]

    @property
    def seen_ends(self) -> list[Ends]:
        """The ends of all readings, two each, then those of the driven elements."""
        return [end for each in self.readers for end in (each.first, each.second)] + self.driven_ends

    @property
    def bodies(self) -> tuple[int, ...]:
        """Numbers of the bodies with a reading or a driven element, without the ground."""
        return tuple(sorted({end.bodies[0] for end in self.seen_ends if not end.on_ground}))


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Model:
    """The whole system."""

    groups: tuple[BodyGroup, ...]
    """The bodies whose inertia is in the compiled equations; that of a full body is not"""
    joints: tuple[JointGroup, ...]
    forces: tuple[ForceGroup, ...]
    nodal_loads: tuple[NodalLoadArrays, ...]
    gravity: AnyArray
    base_accelerations: tuple[TimeLaw, ...]
    """Laws with values (3,)"""
    length: AnyArray
    """Size of the system, the scale of translations."""
    mass: AnyArray
    """Mass of the system, the scale that balances multipliers against accelerations."""
    sizes: tuple[int, ...] = field(metadata=STATIC)
    """Number of coordinates of every body"""
    n_equations: int = field(metadata=STATIC)
    """Number of constraint equations, redundant ones included"""
    active: tuple[int, ...] = field(metadata=STATIC)
    """The constraint equations in use: all but the redundant ones."""
    controllers: tuple[ControlLaw, ...] = ()

    @property
    def slices(self) -> tuple[slice, ...]:
        """Positions of each body's velocities in the common vector."""
        return adjacent_slices([6 + r for r in self.sizes])

    @property
    def coordinate_slices(self) -> tuple[slice, ...]:
        """Positions of each body's coordinates in their common vector."""
        return adjacent_slices(self.sizes)

    @property
    def frames(self) -> Places:
        """Velocities of the bodies' frames."""
        return Places(tuple(part.start for part in self.slices), 6)

    @property
    def deforming_slices(self) -> tuple[slice, ...]:
        """Velocities of the deformable bodies."""
        return tuple(part for part in self.slices if part.stop > part.start + 6)

    @property
    def n_velocities(self) -> int:
        """Length of the common velocity vector."""
        return sum(6 + r for r in self.sizes)

    def as_lengths(self, residual: AnyArray) -> AnyArray:
        """Residuals (m,) of the equations in use as lengths: in small machines, angles times the length.

        In a machine smaller than the unit of length, the rounding error of an angle exceeds that of a length.
        """
        angles = np.zeros(self.n_equations, dtype=bool)
        for group in self.joints:
            angles[group.rows.index] = ~np.array(group.of_positions, dtype=bool)
        of: Any = np if isinstance(residual, np.ndarray) else jnp
        return residual * of.where(angles[list(self.active)], of.minimum(self.length, 1.0), 1.0)

    @property
    def reads_reactions(self) -> bool:
        """Whether forces depend on joint multipliers."""
        return any(group.reaction is not None for group in self.forces)

    @property
    def joints_alone(self) -> Model:
        """The data of constraint equations only; their program is the same for other bodies and loads."""
        return self._without_loads(groups=())

    @property
    def bodies_alone(self) -> Model:
        """The data of the mass matrix only."""
        return self._without_loads(joints=(), n_equations=0, active=())

    def _without_loads(self, **others: Any) -> Model:
        return replace(self, forces=(), nodal_loads=(), base_accelerations=(), controllers=(), **others)

    def gravity_at(self, time: AnyArray) -> AnyArray:
        """Gravity in the frame of an accelerated base, (3,)."""
        return self.gravity - sum(law(time) for law in self.base_accelerations)

    def loads_at(self, time: AnyArray) -> Model:
        """The model with the values of its loads at a time as constant laws, without tables of the loads."""

        def held(group: ForceGroup) -> ForceGroup:
            if group.law is None:
                return group
            return replace(group, law=Constant(over(lambda law: jnp.asarray(law(time)), group.law)))

        return replace(
            self,
            forces=tuple(held(group) for group in self.forces),
            nodal_loads=tuple(
                replace(each, load=replace(each.load, law=Constant(jnp.asarray(each.load.law(time)))))
                for each in self.nodal_loads
            ),
            base_accelerations=tuple(Constant(jnp.asarray(law(time))) for law in self.base_accelerations),
        )


def adjacent_slices(sizes: Sequence[int]) -> tuple[slice, ...]:
    """Slices of the given sizes, one after the other."""
    ends = np.cumsum([0, *sizes])
    return tuple(slice(int(a), int(b)) for a, b in pairwise(ends))
