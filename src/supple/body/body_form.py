"""What every form of a body offers a machine: rigid, full, reduced, and those to come."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.body.interface import Interface
from supple.body.point_motion import InterfaceMotion, NodeMotion
from supple.body.sections import Sections
from supple.fem import FiniteElementModel
from supple.integrate.motion import FramedMotion, Motion

__all__ = ["BodyForm"]


class BodyForm(Protocol):
    """A body as a machine holds it. Code that uses these members does not depend on the form of the body.

    A motion is that of this body in a solution; ModelError for one of another type.
    """

    @property
    def kind(self) -> str:
        """The form in a word, for reports."""
        ...

    @property
    def name(self) -> str:
        """Name of the body."""
        ...

    @property
    def mass(self) -> float:
        """Of the whole body, kg."""
        ...

    @property
    def centre_of_mass(self) -> np.ndarray:
        """(3,) undeformed, in the body's frame, m."""
        ...

    @property
    def n_coordinates(self) -> int:
        """Number of deformation coordinates; none of a rigid body."""
        ...

    @property
    def nodes(self) -> np.ndarray:
        """Undeformed positions (N, 3) in the body's frame, m; of a rigid body those of its interfaces."""
        ...

    @property
    def interfaces(self) -> Sequence[Interface]:
        """Where joints and loads act, in the order given."""
        ...

    def interface(self, name: str) -> Interface:
        """The interface of that name; ModelError names the nearest, or those there are."""
        ...

    def expand(self, coordinates: np.ndarray, nodes: NDArray[np.intp] | slice = ..., /) -> np.ndarray:
        """Displacements (..., k, 3) of some nodes or all by coordinates (..., r), in the body's frame.

        At most quadratic in the coordinates.
        """
        ...

    def expand_rates(
        self, coordinates: np.ndarray, rates: np.ndarray, nodes: NDArray[np.intp] | slice = ..., /
    ) -> np.ndarray:
        """Their rates (..., k, 3) at coordinates and rates (..., r); linear in the rates."""
        ...

    def positions(self, motion: Motion, nodes: ArrayLike | slice = slice(None)) -> NDArray[np.float64]:
        """Positions (t, k, 3) in space of some nodes, or all: the only way from a motion to space.

        Raises ModelError for a node number outside the body.
        """
        ...

    def node_rotations(self, motion: Motion) -> NDArray[np.float64]:
        """Rotation matrices (t, N, 3, 3) of the material at all nodes, from rest to space."""
        ...

    def node_motion(self, motion: Motion, nodes: ArrayLike) -> NodeMotion:
        """Positions, velocities and accelerations (t, k, 3) of some nodes in space."""
        ...

    def motion_near(
        self,
        position: np.ndarray,
        rotation: np.ndarray,
        coordinates: np.ndarray,
        displacement: np.ndarray,
        rates: np.ndarray,
        /,
    ) -> FramedMotion:
        """The motion of small motions p = (A^T dR, psi, dq) about a pose and coordinates.

        ModelError of a form without a frame.
        displacement : p (t, 6 + r)
        rates : p' (t, 6 + r)     as at p = 0
        """
        ...

    def interface_motion(self, motion: Motion, name: str) -> InterfaceMotion:
        """Pose, velocities and acceleration (t, ...) of an interface in space: all that joints see of it."""
        ...

    @property
    def is_seen_by_interfaces(self) -> bool:
        """Whether joints and forces see it by the motions of its interfaces, not by its coordinates."""
        ...

    @property
    def has_frame(self) -> bool:
        """Whether its deformation is measured in a frame that moves with it."""
        ...

    @property
    def dofs_per_node(self) -> int:
        """Freedoms of a node: 3, or 6 with rotations."""
        ...

    def nodal_fields(
        self, coordinates: np.ndarray, freedoms: NDArray[np.intp] | slice = ..., /
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """Nodal freedoms (n, t) of coordinates (t, r), from which strains follow; some freedoms, or all.

        Second, the condensed part, of which linear strains alone follow; None where nothing is condensed.
        """
        ...

    @property
    def has_linear_strains(self) -> bool:
        """Whether strains are linear in the nodal displacements."""
        ...

    @property
    def has_stress_modes(self) -> bool:
        """Whether its stress is a quadratic polynomial of its coordinates (`stress_modes`)."""
        ...

    def sections(self, model: FiniteElementModel | None, /) -> Sections:
        """Its sections, by its elements where these carry the forces; ModelError of a form that has none."""
        ...

    def section_softness(self, interface: str, /) -> np.ndarray:
        """Softness c / C (3,) of the section of an averaging interface; zeros of any other."""
        ...

    @property
    def missing_centrifugal_stiffness(self) -> np.ndarray:
        """Share of the stiffness lacking per squared spin about each axis, (3,), (rad/s)^-2."""
        ...

    @property
    def coordinate_size(self) -> float:
        """Norm of the coordinates (r,) when every node moves by one."""
        ...

    @property
    def is_linear(self) -> bool:
        """Whether the internal force is proportional to the deformation, without geometric stiffness."""
        ...

    def lowest_frequency(self) -> float:
        """Of the undeformed body fixed in its frame, rad/s; infinite where nothing deforms."""
        ...

    @property
    def rotation_limit(self) -> float:
        """Largest rotation of material against the frame that the kinematics describe, rad."""
        ...

    @property
    def rotation_rows(self) -> np.ndarray | None:
        """Rotation vectors at P points per unit coordinate, (3 P, r), dense or sparse; None if unknown."""
        ...
