"""Protocol of a body in a machine, common to rigid, full, reduced and intrinsic forms."""

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
    """A body in a machine. Code that uses these members does not depend on the form of the body.

    `motion` is the motion of this body in a solution; any other type raises ModelError.
    """

    @property
    def kind(self) -> str:
        """Name of the form, for reports."""
        ...

    @property
    def name(self) -> str:
        """Name of the body."""
        ...

    @property
    def mass(self) -> float:
        """Mass of the body, kg."""
        ...

    @property
    def centre_of_mass(self) -> np.ndarray:
        """Centre of mass (3,), undeformed, in the body's frame, m."""
        ...

    @property
    def n_coordinates(self) -> int:
        """Number of deformation coordinates; zero for a rigid body."""
        ...

    @property
    def nodes(self) -> np.ndarray:
        """Undeformed positions (N, 3) in the body's frame, m; for a rigid body those of its interfaces."""
        ...

    @property
    def interfaces(self) -> Sequence[Interface]:
        """Interfaces for joints and loads, in the given order."""
        ...

    def interface(self, name: str) -> Interface:
        """The interface of that name; ModelError lists the nearest names, or all."""
        ...

    def expand(self, coordinates: np.ndarray, nodes: NDArray[np.intp] | slice = ..., /) -> np.ndarray:
        """Displacements (..., k, 3) of all or some nodes for coordinates (..., r), in the body's frame.

        At most quadratic in the coordinates.
        """
        ...

    def expand_rates(
        self, coordinates: np.ndarray, rates: np.ndarray, nodes: NDArray[np.intp] | slice = ..., /
    ) -> np.ndarray:
        """Displacement rates (..., k, 3) at coordinates and rates (..., r); linear in the rates."""
        ...

    def positions(self, motion: Motion, nodes: ArrayLike | slice = slice(None)) -> NDArray[np.float64]:
        """Positions (t, k, 3) of all or some nodes in space.

        Raises ModelError for a node number outside the body.
        """
        ...

    def node_rotations(self, motion: Motion) -> NDArray[np.float64]:
        """Rotation matrices (t, N, 3, 3) of the material at all nodes, from the undeformed body to space."""
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
        """The motion at small displacements p = (A^T dR, psi, dq) from a pose and coordinates.

        Raises ModelError for a form without a frame.
        displacement : p (t, 6 + r)
        rates : p' (t, 6 + r)     converted to velocities at p = 0
        """
        ...

    def interface_motion(self, motion: Motion, name: str) -> InterfaceMotion:
        """Pose, velocities and acceleration (t, ...) of an interface in space: the input of joints."""
        ...

    @property
    def uses_interface_motions(self) -> bool:
        """Whether joints and forces use the motions of its interfaces instead of its coordinates."""
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
        """All or some nodal freedoms (n, t) for coordinates (t, r); strains follow from them.

        The second array is the condensed part, which enters only linear strains; None without condensation.
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
        """Its sections, cut through the elements of `model` if these carry the forces.

        Raises ModelError for a form without sections.
        """
        ...

    def section_softness(self, interface: str, /) -> np.ndarray:
        """Softness c / C (3,) of the section of an averaging interface; zeros for any other."""
        ...

    @property
    def missing_centrifugal_stiffness(self) -> np.ndarray:
        """Fraction of stiffness missing per squared angular velocity about each axis, (3,), (rad/s)^-2."""
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
        """Lowest frequency of the undeformed body fixed in its frame, rad/s; infinite for a rigid body."""
        ...

    @property
    def rotation_limit(self) -> float:
        """Largest rotation of material relative to the frame for which the kinematics hold, rad."""
        ...

    @property
    def rotation_rows(self) -> np.ndarray | None:
        """Rotation vectors at P points per unit coordinate, (3 P, r), dense or sparse; None if unknown."""
        ...
