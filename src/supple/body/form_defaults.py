"""Default members of the body forms."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from supple.body.sections import Sections
from supple.errors import ModelError
from supple.fem import FiniteElementModel
from supple.integrate.motion import FramedMotion, Motion

__all__ = ["FormDefaults"]

Array = NDArray[np.float64]


class _Form(Protocol):
    """Members on which the defaults depend."""

    @property
    def mass(self) -> float:
        """Mass of the body, kg."""
        ...

    @property
    def is_linear(self) -> bool:
        """Whether the internal force is proportional to the deformation."""
        ...

    def expand(self, coordinates: Array, nodes: NDArray[np.intp] | slice = ..., /) -> Array:
        """Displacements (..., k, 3) of some nodes or all by coordinates (..., r)."""
        ...


class FormDefaults:
    """Members of `BodyForm` that are the same in most forms."""

    @property
    def uses_interface_motions(self) -> bool:
        """False: its coordinates are unknowns of the machine's equations."""
        return False

    @property
    def has_frame(self) -> bool:
        """True: its deformation is measured in a frame that moves with it."""
        return True

    @property
    def dofs_per_node(self) -> int:
        """Three displacements."""
        return 3

    @property
    def has_linear_strains(self: _Form) -> bool:
        """Whether strains are linear in the nodal displacements, as in a linear body."""
        return self.is_linear

    @property
    def has_stress_modes(self) -> bool:
        """False: stress is recovered from displacements."""
        return False

    @property
    def coordinate_size(self: _Form) -> float:
        """sqrt(kg): the norm of mass-orthonormal coordinates (r,) when all nodes move by one."""
        return float(np.sqrt(self.mass))

    @property
    def rotation_rows(self) -> Any:
        """None: no rotation relative to a frame is checked."""
        return None

    @property
    def missing_centrifugal_stiffness(self) -> Array:
        """Zeros (3,)."""
        return np.zeros(3)

    def expand_rates(
        self: _Form, _coordinates: Array, rates: Array, nodes: NDArray[np.intp] | slice = slice(None), /
    ) -> Array:
        """Displacement rates (..., k, 3), for displacements that are linear in the coordinates."""
        return self.expand(rates, nodes)

    def node_rotations(self: Any, motion: Motion) -> Array:
        """(t, N, 3, 3) rotation of the frame, times that of the node's rotation vector, if it has one."""
        own = motion.of_type(FramedMotion)
        n_times, n_nodes = len(own.coordinates), len(self.nodes)
        of_frame = np.broadcast_to(own.rotation[:, None], (n_times, n_nodes, 3, 3))
        if self.dofs_per_node < 6:
            return of_frame
        moved, condensed = self.nodal_fields(own.coordinates)
        fields = (moved if condensed is None else moved + condensed).T.reshape(-1, 6)
        local = Rotation.from_rotvec(fields[:, 3:]).as_matrix()
        return of_frame @ local.reshape(n_times, n_nodes, 3, 3)

    def sections(self: Any, _model: FiniteElementModel | None, /) -> Sections:
        """ModelError, as the form has no section forces."""
        raise ModelError(
            f"body '{self.name}' is {self.kind}, which has no section forces; read the force of a joint, or "
            "split the body there"
        )

    def section_softness(self, _interface: str, /) -> Array:
        """Zeros (3,)."""
        return np.zeros(3)
