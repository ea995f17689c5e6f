"""Default members of the body forms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.spatial.transform import Rotation

from supple.arrays import FloatArray
from supple.body.sections import Sections
from supple.errors import ModelError
from supple.fem import FiniteElementModel
from supple.integrate.motion import FramedMotion, Motion

if TYPE_CHECKING:
    from supple.body.body_form import BodyForm


class FormDefaults:
    """Members of `BodyForm` that most forms have in common."""

    uses_interface_motions: ClassVar[bool] = False
    """False: the body's coordinates are unknowns of the machine's equations."""
    lumping_error: ClassVar[float | None] = 0.0
    """Zero: the mass is that of the elements."""
    has_frame: ClassVar[bool] = True
    """True: the deformation is relative to a frame that moves with the body."""

    @property
    def dofs_per_node(self) -> int:
        """3: the displacements of a node."""
        return 3

    @property
    def has_linear_strains(self: BodyForm) -> bool:
        """Whether strains are linear in the nodal displacements, as in a linear body."""
        return self.is_linear

    @property
    def has_stress_modes(self) -> bool:
        """False: stress is recovered from displacements."""
        return False

    @property
    def coordinate_size(self: BodyForm) -> float:
        """sqrt(mass): the norm of mass-orthonormal coordinates (r,) for a unit displacement of all nodes."""
        return float(np.sqrt(self.mass))

    @property
    def rotation_rows(self) -> FloatArray | csc_array | None:
        """None: the rotation relative to the frame is not checked."""
        return None

    @property
    def missing_centrifugal_stiffness(self) -> FloatArray:
        """Zeros (3,): no centrifugal stiffness is missing."""
        return np.zeros(3)

    def expand_rates(
        self: Any,
        _coordinates: FloatArray,
        rates: FloatArray,
        nodes: NDArray[np.intp] | slice = slice(None),
        /,
    ) -> FloatArray:
        """Displacement rates (..., k, 3) for displacements linear in the coordinates: expand(rates)."""
        return self.expand(rates, nodes)

    def node_rotations(self: BodyForm, motion: Motion) -> FloatArray:
        """Rotations (t, N, 3, 3) of the frame, times those of the nodal rotation vectors, if nodes have them.

        Raises ModelError for a motion without a frame.
        """
        own = motion.of_type(FramedMotion)
        n_times, n_nodes = len(own.coordinates), len(self.nodes)
        of_frame = np.broadcast_to(own.rotation[:, None], (n_times, n_nodes, 3, 3))
        if self.dofs_per_node < 6:
            return of_frame
        moved, condensed = self.nodal_fields(own.coordinates)
        fields = (moved if condensed is None else moved + condensed).T.reshape(-1, 6)
        local = Rotation.from_rotvec(fields[:, 3:]).as_matrix()
        return of_frame @ local.reshape(n_times, n_nodes, 3, 3)

    def sections(self: BodyForm, _model: FiniteElementModel | None, /) -> Sections:
        """Raise ModelError, as this form of body has no section forces."""
        raise ModelError(
            f"body '{self.name}' is {self.kind}, which has no section forces; read the force of a joint, or "
            "split the body there"
        )

    def section_softness(self, _interface: str, /) -> FloatArray:
        """Zeros (3,): sections at interfaces have no softness."""
        return np.zeros(3)
