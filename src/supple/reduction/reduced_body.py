"""The reduced body: the data of a simulation in r coordinates, and the expansion to the full body."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.algebra import ReadOnlyArrays
from supple.body.interface import interface_named
from supple.body.mass_properties import centre_of_gram
from supple.body.point_motion import FloatingForm
from supple.errors import ModelError
from supple.reduction.condensed_inertia import missing_centrifugal_stiffness
from supple.reduction.condensed_motion import CondensedMotion
from supple.reduction.pair_blocks import PairBlocks, pair_blocks
from supple.reduction.reduction_report import ReductionReport
from supple.reduction.tensors import InternalForceTensors
from supple.summary import Summarized, Summary, place_text

if TYPE_CHECKING:
    from supple.body import Frame, FullBody

__all__ = ["ReducedBody", "ReducedInterface"]

# Allowed deviation of a tensor from symmetry in all indices, relative to its largest entry.
LARGEST_ASYMMETRY = 1e-8


@dataclass(frozen=True, eq=False)
class ReducedInterface(ReadOnlyArrays):
    """An interface of the reduced body: its motion (u, theta) is motion @ gamma, exactly; z does not move it.

    name : str
    position : (3,) array      in the body's frame, undeformed
    motion : (6, r) array      rows ux uy uz rx ry rz
    cubic_turn : float         as in BodyInterface
    tied_nodes : (k,) array    as in BodyInterface
    softness : (3,) array      of an averaging interface, see `section_softness`; zeros otherwise
    """

    name: str
    position: np.ndarray
    motion: np.ndarray
    cubic_turn: float = 0.0
    tied_nodes: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    softness: np.ndarray = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True, eq=False, repr=False)
class ReducedBody(FloatingForm, Summarized, ReadOnlyArrays):
    """A flexible body in r coordinates gamma, amplitudes of M-orthonormal columns V (V^T M V = I, D V = 0).

        u_nodal = nodal_basis @ gamma + z(gamma),   z: condensed motion, quadratic in gamma
        f(gamma) = (K + A3/2 + A4/3) gamma,   A3 = unpack(cubic @ gamma),  A4 = unpack(quartic @ m2)

    with m2 the products gamma_j gamma_k, j <= k, in the order of numpy.triu_indices(r).

    name : str
    frame : the floating frame (NodalFixedFrame | MeanAxisFrame) in which gamma is measured
    gram : (6+4r, 6+4r)         inertia Gram matrix of [Phi_t | Phi_w0 | Phi_1 .. Phi_r | V]: `inertia_gram`
    stiffness : (r, r)          V^T K V
    cubic : (n2, r)             or None, if the tensors are linear
    quartic : (n2, n2)          or None, n2 = r(r+1)/2
    damping : (r, r)            damping matrix of the undeformed body
    damping_cubic : (n2, r)     or None; increase of the damping with deformation, for strain-rate damping:
    damping_quartic : (n2, n2)  D = damping + unpack(damping_cubic @ gamma) + unpack(damping_quartic @ m2)
    interfaces : ReducedInterface, one per virtual node
    nodes : (N, 3)              undeformed positions
    nodal_basis : (n_nodal, r)  nodal displacements (and rotations) per unit gamma
    rotation_basis : (P, 3, r)  rotation vectors at P points per unit gamma, or None when unknown
    rotation_limit : float      rad; rotation relative to the frame up to which the kinematics are valid
    frequencies : (r,)          rad/s, ascending, of the reduced body fixed in its frame
    report : ReductionReport
    condensed : motion z outside the columns, condensed into the quartic tensor; None if none is condensed
    padding : int               padding coordinates that a run adds, see `padded`; not stored in files
    full : FullBody | None      reference to the full body before reduction; not stored in files and not
           passed to other processes
    elastic_elsewhere : bool    the nonlinear elastic force is computed from the elements, not the tensors;
           not stored in files
    Raises ModelError when shapes disagree, a value is not finite, only one of a cubic and a quartic tensor is
        given, or one of them is not symmetric in all indices, so that its force has no potential.
    """

    name: str
    frame: Frame
    gram: np.ndarray
    stiffness: np.ndarray
    cubic: np.ndarray | None
    quartic: np.ndarray | None
    damping: np.ndarray
    interfaces: tuple[ReducedInterface, ...]
    nodes: np.ndarray
    nodal_basis: np.ndarray
    rotation_basis: np.ndarray | None
    rotation_limit: float
    frequencies: np.ndarray
    report: ReductionReport
    damping_cubic: np.ndarray | None = None
    damping_quartic: np.ndarray | None = None
    condensed: CondensedMotion | None = None
    padding: int = 0
    elastic_elsewhere: bool = False
    full: FullBody | None = None

    def summary(self) -> Summary:
        """Coordinates, basis, mass, lowest frequencies and their proven accuracy, and interfaces."""
        kind = "linear" if self.is_linear else "nonlinear"
        lowest = ", ".join(f"{value:.4g}" for value in self.frequencies[:6] / (2 * np.pi))
        rows = [
            ("coordinates", f"{self.r} of {len(self.nodal_basis)} freedoms, {kind}; {self.frame}"),
            ("basis", str(self.report)),
            ("mass", f"{self.mass:g}"),
            ("lowest frequencies of its basis", f"{lowest} cycles per unit of time, in its frame"),
        ]
        if self.report.certificate is not None:
            rows.append(("eigenvalues", str(self.report.certificate)))
        size = float(abs(self.nodes).max())
        rows += [(f"interface {one.name}", f"at {place_text(one.position, size)}") for one in self.interfaces]
        return Summary(f"ReducedBody '{self.name}', {self.r} coordinates, {kind}, {self.frame}", rows)

    def __getstate__(self) -> dict[str, Any]:
        return vars(self) | {"full": None}

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_shapes(self)
        _check_potential(self)

    kind: ClassVar[Literal["reduced"]] = "reduced"
    """The name of this form, "reduced"."""

    @property
    def mass(self) -> float:
        """Mass of the body, kg."""
        return float(self.gram[0, 0])

    @property
    def centre_of_mass(self) -> np.ndarray:
        """Centre of mass (3,), undeformed, in the body's frame, m."""
        return centre_of_gram(self.gram)

    @property
    def r(self) -> int:
        """Number of reduced coordinates, by the symbol of the equations."""
        return self.stiffness.shape[0]

    @property
    def n_coordinates(self) -> int:
        """Number of reduced coordinates."""
        return self.r

    @property
    def is_linear(self) -> bool:
        """True when the elastic force is K gamma alone."""
        return self.cubic is None and not self.elastic_elsewhere

    @property
    def dofs_per_node(self) -> int:
        """3 (solids) or 6 (shells)."""
        return self.nodal_basis.shape[0] // len(self.nodes)

    @property
    def displacement_basis(self) -> np.ndarray:
        """Nodal displacements per unit gamma, (N, 3, r)."""
        return self.nodal_basis.reshape(len(self.nodes), self.dofs_per_node, self.r)[:, :3]

    @cached_property
    def tensors(self) -> InternalForceTensors:
        """The internal force as a polynomial of gamma, in NumPy."""
        return InternalForceTensors(self.stiffness, self.cubic, self.quartic)

    @cached_property
    def quartic_blocks(self) -> np.ndarray | PairBlocks | None:
        """The quartic tensor as its nonzero blocks, or whole if few blocks are zero; None without tensors."""
        return None if self.quartic is None else pair_blocks(self.quartic)

    @cached_property
    def damping_quartic_blocks(self) -> np.ndarray | PairBlocks | None:
        """The quartic tensor of the damping, in the form of `quartic_blocks`; None without."""
        return None if self.damping_quartic is None else pair_blocks(self.damping_quartic)

    def interface(self, name: str) -> ReducedInterface:
        """The interface of that name; if there is none, ModelError with the nearest names, or all."""
        return interface_named(self.name, name, self.interfaces)

    def expand(self, gamma: ArrayLike, nodes: NDArray[np.intp] | slice = slice(None)) -> np.ndarray:
        """Displacements V gamma + z(gamma), (..., k, 3), of k nodes, by default all, in the body's frame."""
        moved = _combine(self.displacement_basis[nodes], gamma)
        if self.condensed is not None:
            moved += self._condensed_fields(nodes, self.condensed.amplitudes_at(gamma))
        return moved

    def expand_rates(
        self, gamma: ArrayLike, rates: ArrayLike, nodes: NDArray[np.intp] | slice = slice(None)
    ) -> np.ndarray:
        """Displacement rates (..., k, 3) of k nodes at coordinates gamma and their rates (..., r)."""
        moved = _combine(self.displacement_basis[nodes], rates)
        if self.condensed is not None and np.any(gamma):
            moved += self._condensed_fields(nodes, self.condensed.amplitude_rates(gamma, rates))
        return moved

    def _condensed_fields(self, nodes: NDArray[np.intp] | slice, amplitudes: np.ndarray) -> np.ndarray:
        assert self.condensed is not None
        known = self.condensed.fields
        fields = known.reshape(len(self.nodes), self.dofs_per_node, known.shape[-1])
        return _combine(fields[nodes, :3], amplitudes)

    def nodal_fields(
        self, gamma: np.ndarray, freedoms: NDArray[np.intp] | slice = slice(None)
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """V gamma and z(gamma), (k, t) each, at k freedoms, for gamma (t, r); None if z is not condensed."""
        moved = self.nodal_basis[freedoms] @ gamma.T
        if self.condensed is None:
            return moved, None
        return moved, self.condensed.fields[freedoms] @ self.condensed.amplitudes_at(gamma).T

    @property
    def has_stress_modes(self) -> bool:
        """Whether the tensors contain all elastic forces: `elastic_elsewhere` is False."""
        return not self.elastic_elsewhere

    def section_softness(self, interface: str) -> np.ndarray:
        """Softness c / C (3,) of an averaging interface, see `averaging_error`; zeros for any other."""
        return self.interface(interface).softness

    @property
    def missing_centrifugal_stiffness(self) -> np.ndarray:
        """Missing centrifugal stiffness relative to the stiffness, (3,), s^2; see `condensed_inertia`."""
        return missing_centrifugal_stiffness(self)

    def lowest_frequency(self) -> float:
        """Lowest frequency of the undeformed body fixed in its frame, rad/s."""
        return float(np.min(self.frequencies, initial=np.inf))

    @property
    def rotation_rows(self) -> np.ndarray | None:
        """Rotation vectors at P points per unit gamma, (3 P, r); None if unknown."""
        return None if self.rotation_basis is None else self.rotation_basis.reshape(-1, self.r)

    def rotations(self, gamma: ArrayLike) -> np.ndarray:
        """Rotation vectors (..., P, 3) relative to the frame; ModelError if the body has none."""
        if self.rotation_basis is None:
            raise ModelError(
                f"body '{self.name}' has no rotations: "
                "it was imported without rotational freedoms or elements; import it with them"
            )
        return _combine(self.rotation_basis, gamma)


def _combine(fields: np.ndarray, gamma: ArrayLike) -> np.ndarray:
    """Sum of fields (P, 3, r) times coordinates (..., r): (..., P, 3)."""
    gamma = np.asarray(gamma)
    n_points, _, r = fields.shape
    return (gamma @ fields.reshape(3 * n_points, r).T).reshape(*gamma.shape[:-1], n_points, 3)


def _check_shapes(body: ReducedBody) -> None:
    r = body.stiffness.shape[0]
    n2 = r * (r + 1) // 2
    expected = {
        "gram": (6 + 4 * r, 6 + 4 * r),
        "stiffness": (r, r),
        "damping": (r, r),
        "frequencies": (r,),
        "nodal_basis": (body.nodal_basis.shape[0], r),
    }
    for of_what in ("", "damping_"):
        cubic, quartic = (getattr(body, of_what + name) is not None for name in ("cubic", "quartic"))
        if cubic != quartic:
            raise ModelError(
                f"reduced body '{body.name}': give both {of_what}cubic and {of_what}quartic tensors, or "
                "neither"
            )
        if cubic:
            expected |= {f"{of_what}cubic": (n2, r), f"{of_what}quartic": (n2, n2)}
    if body.condensed is not None and body.condensed.shape != (body.nodal_basis.shape[0], n2):
        raise ModelError(
            f"reduced body '{body.name}': condensed motion of shape {body.condensed.shape}, "
            f"but {r} coordinates need {(body.nodal_basis.shape[0], n2)}"
        )
    if body.condensed is not None and body.condensed.moments is not None:
        moments = body.condensed.moments
        if moments.shape != (12, n2) or not np.isfinite(moments).all():
            raise ModelError(
                f"reduced body '{body.name}': moments of its condensed motion of shape {moments.shape}, "
                f"but {r} coordinates need {(12, n2)} finite numbers"
            )
    for name, shape in expected.items():
        array = getattr(body, name)
        if array.shape != shape:
            raise ModelError(
                f"reduced body '{body.name}': {name} has shape {array.shape}, "
                f"but {r} coordinates need {shape}"
            )
        if not np.isfinite(array).all():
            raise ModelError(f"reduced body '{body.name}': {name} contains NaN or infinity")
    for interface in body.interfaces:
        if interface.motion.shape != (6, r):
            raise ModelError(
                f"reduced body '{body.name}': motion of interface '{interface.name}' has shape "
                f"{interface.motion.shape}, but {r} coordinates need {(6, r)}"
            )


def _check_potential(body: ReducedBody) -> None:
    if body.cubic is None or body.quartic is None:
        return
    # Not the cached property `tensors`: validation must not add attributes to the body.
    symmetric = InternalForceTensors(body.stiffness, body.cubic, body.quartic).symmetrized()
    for name in ("cubic", "quartic"):
        own, other = getattr(body, name), getattr(symmetric, name)
        error = np.max(np.abs(own - other), initial=0.0)
        if error > LARGEST_ASYMMETRY * np.max(np.abs(own), initial=0.0):
            raise ModelError(
                f"reduced body '{body.name}': its {name} tensor deviates from symmetry in all indices by "
                f"{error:.1e}, so that its force has no potential: use "
                "InternalForceTensors(stiffness, cubic, quartic).symmetrized()"
            )
