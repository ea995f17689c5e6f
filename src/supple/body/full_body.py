"""A flexible body simulated with all its finite-element freedoms, as the reference for reduced bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_array, csr_array, vstack

from supple.arguments import check_fields
from supple.body.averaging_error import section_softness
from supple.body.damping import Damping
from supple.body.flexible_body import FlexibleBody
from supple.body.frame import Frame
from supple.body.interface import BodyInterface
from supple.body.mass_properties import rigid_mass_properties
from supple.body.point_motion import FloatingForm

__all__ = ["FullBody"]


@dataclass(frozen=True, eq=False)
class FullBody(FloatingForm):
    """A flexible body with all its coordinates; six Lagrange multipliers impose the conditions of its frame.

    body : FlexibleBody    with quadratic strains it is nonlinear; `body.linearized()` is linear
    frame : NodalFixedFrame | MeanAxisFrame
    damping : RayleighDamping(...), LinearRayleighDamping(...), ModalDamping(ratios, n_modes) or None
    """

    body: FlexibleBody
    frame: Frame
    damping: Damping | None = None

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def name(self) -> str:
        """Name of the body."""
        return self.body.name

    kind: ClassVar[Literal["full"]] = "full"
    """The name of this form, "full"."""

    @property
    def mass(self) -> float:
        """Mass of the body, kg: r^T M r, where r is the unit translation along x."""
        along_x = self.body.rigid_modes[:, 0]
        return float(along_x @ (self.body.mass @ along_x))

    @property
    def centre_of_mass(self) -> np.ndarray:
        """Centre of mass (3,), undeformed, in the body's frame, m."""
        return rigid_mass_properties(self.body.nodal_mass, self.body.nodes, self.body.dofs_per_node).centre

    @property
    def n_coordinates(self) -> int:
        """Number of coordinates of the flexible body."""
        return self.body.n

    @property
    def nodes(self) -> np.ndarray:
        """Undeformed positions (N, 3) of the nodes, m."""
        return self.body.nodes

    @property
    def interfaces(self) -> tuple[BodyInterface, ...]:
        """The body's interfaces."""
        return self.body.interfaces

    def interface(self, name: str) -> BodyInterface:
        """The interface of that name; the ModelError for an unknown name lists the nearest name, or all."""
        return self.body.interface(name)

    uses_interface_motions: ClassVar[bool] = True
    """Equations of joints and forces contain six motions per interface, not all coordinates."""

    @property
    def interface_motions(self) -> csr_array:
        """Displacement and rotation of each of the p interfaces per unit coordinate, csr (6 p, n)."""
        motions = [interface.motion for interface in self.interfaces]
        return csr_array(vstack(motions)) if motions else csr_array((0, self.n_coordinates))

    def expand(self, coordinates: ArrayLike, nodes: NDArray[np.intp] | slice = slice(None)) -> np.ndarray:
        """Displacements (..., k, 3) of all or some nodes for coordinates (..., n), in the body's frame."""
        nodal = np.asarray(coordinates) @ self.body.expansion.T
        shape = (*nodal.shape[:-1], len(self.nodes), self.body.dofs_per_node)
        return nodal.reshape(shape)[..., nodes, :3]

    @property
    def dofs_per_node(self) -> int:
        """Number of freedoms of a node: 3, or 6 with rotations."""
        return self.body.dofs_per_node

    def nodal_fields(
        self, coordinates: np.ndarray, freedoms: NDArray[np.intp] | slice = slice(None)
    ) -> tuple[np.ndarray, None]:
        """All or some nodal freedoms (n_nodal, t) for coordinates (t, n); None, as no motion is condensed."""
        return self.body.expansion.tocsr()[freedoms] @ coordinates.T, None

    @property
    def coordinate_size(self) -> float:
        """sqrt(N) for N nodes: approximate norm of the coordinates for a unit displacement of all nodes."""
        return float(np.sqrt(len(self.nodes)))

    def section_softness(self, interface: str) -> np.ndarray:
        """Softness c / C (3,) of the section at an averaging interface, see `averaging_error`.

        Zeros for other interfaces.
        """
        return section_softness(self.body, self.interface(interface))

    @property
    def is_linear(self) -> bool:
        """Whether the internal force is K q, without nonlinear terms."""
        return self.body.is_linear

    def lowest_frequency(self) -> float:
        """Lowest frequency of the undeformed body fixed in its frame, rad/s."""
        constraint = self.frame.constraint(self.body)
        return float(self.body.lowest_frequencies(1, constraint)[0])

    @property
    def rotation_limit(self) -> float:
        """Largest rotation relative to the frame for which the kinematics are valid, rad."""
        return self.body.rotation_limit

    @property
    def rotation_rows(self) -> csc_array | None:
        """Rotation vectors at P nodes or cell centres per unit coordinate, (3 P, n); None if unknown."""
        operator = self.body.rotation_operator
        return None if operator is None else operator @ self.body.expansion
