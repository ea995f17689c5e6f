"""Protocol of a body in a machine, common to rigid, full, reduced and intrinsic forms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_array

from supple.body.floating_kinematics import Deforming
from supple.body.interface import Interface
from supple.body.point_motion import InterfaceMotion, NodeMotion
from supple.body.sections import Sections
from supple.fem import FiniteElementModel
from supple.integrate.motion import FramedMotion, Motion

__all__ = ["BodyForm"]


class BodyForm(Deforming, Protocol):
    """A body in a machine. Code that uses these members does not depend on the form of the body.

    The argument `motion` is the motion of this body in a solution; a motion of another form of body raises
    ModelError.
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
    def interfaces(self) -> Sequence[Interface]:
        """Interfaces for joints and loads, in the given order."""
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
        """The motion at displacements p = (A^T dR, psi, dq) from a pose (R, A) and coordinates q.

        dR is the displacement of the frame's origin, psi the rotation vector of the frame in its own axes.
        Raises ModelError for a form without a frame.
        displacement : p (t, 6 + r)
        rates : p' (t, 6 + r)     taken as velocities: exact at p = 0, so that p must be small
        """
        ...

    def interface_motion(self, motion: Motion, name: str) -> InterfaceMotion:
        """Pose, velocities and acceleration of an interface in space at t times, as needed by joints."""
        ...

    @property
    def uses_interface_motions(self) -> bool:
        """Whether joints and forces use the motions of the body's interfaces instead of its coordinates."""
        ...

    @property
    def has_frame(self) -> bool:
        """Whether the deformation is relative to a frame that moves with the body."""
        ...

    @property
    def dofs_per_node(self) -> int:
        """Number of freedoms of a node: 3, or 6 with rotations."""
        ...

    def nodal_fields(
        self, coordinates: np.ndarray, freedoms: NDArray[np.intp] | slice = ..., /
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """Values (n, t) of all or some nodal freedoms for coordinates (t, r), as input of strains.

        The second array (n, t) is the condensed part of the motion, which is not in the first and enters only
        linear strains; None without condensation.
        """
        ...

    @property
    def has_linear_strains(self) -> bool:
        """Whether strains are linear in the nodal displacements."""
        ...

    @property
    def has_stress_modes(self) -> bool:
        """Whether the stress is computed as a quadratic polynomial of the coordinates (`stress_modes`)."""
        ...

    def sections(self, model: FiniteElementModel | None, /) -> Sections:
        """Force and moment across sections of the body, from the elements of `model` if the form needs them.

        Raises ModelError for a form without section forces, or for `model` None where the form needs it.
        """
        ...

    def section_softness(self, interface: str, /) -> np.ndarray:
        """Softness c / C (3,) of the section at an averaging interface (`averaging_error`); else zeros."""
        ...

    @property
    def lumping_error(self) -> float | None:
        """Relative error of deflections under inertia because stations carry the mass; None if unknown."""
        ...

    @property
    def missing_centrifugal_stiffness(self) -> np.ndarray:
        """Largest fraction of the stiffness that is missing per squared angular velocity, (3,), (rad/s)^-2.

        One value for each body axis; nonzero only where a statically condensed motion has no inertia.
        """
        ...

    @property
    def coordinate_size(self) -> float:
        """Approximate norm of the coordinates (r,) for a unit displacement of every node."""
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
        """Largest rotation of material relative to the frame for which the kinematics are valid, rad."""
        ...

    @property
    def rotation_rows(self) -> np.ndarray | csc_array | None:
        """Rotation vectors at P points per unit coordinate, (3 P, r), dense or sparse; None if unknown."""
        ...
