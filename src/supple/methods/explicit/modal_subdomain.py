"""Modal sub-domain: a linear body with vibration modes on a free four-point frame."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar, Literal

import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.arguments import checked_arguments
from supple.body import FlexibleBody, LinearRayleighDamping, MeanAxisFrame, inertia_gram
from supple.body.damping import refuse_relative_damping
from supple.body.interface import interface_named
from supple.body.mass_properties import rigid_mass_properties
from supple.body.point_motion import FloatingForm
from supple.equations.checks.energy import body_balances
from supple.errors import ModelError
from supple.mesh import Mesh
from supple.methods.explicit.frame_model import FrameModel
from supple.methods.explicit.frame_moments import Moments, moments
from supple.methods.explicit.frame_points import FramePoints
from supple.methods.explicit.mass_fields import mass_fields
from supple.methods.explicit.node_set import NodeSet, node_sets
from supple.methods.explicit.spin_stiffness import CentrifugalStiffness
from supple.methods.explicit.step_limit import local_mass, true_limit
from supple.reduction import LinearBasisRecipe, ReducedBody, rayleigh_ritz

__all__ = ["ModalSubdomain", "modal_subdomain"]

LARGEST_RIGID_PART = 1e-8
"""Largest M-product of a mode with a rigid motion, both of unit M-norm; a larger one is an error."""


@dataclass(frozen=True, eq=False)
class ModalSubdomain(FloatingForm):
    """Modes of a free body on a four-point frame; built by `modal_subdomain`.

    body : FlexibleBody
    vectors : (n, k)        V^T M V = I, R^T M V = 0, V^T K V = diag(omega^2)
    frequencies : (k,)      rad/s, ascending
    mass_damping, stiffness_damping : alpha, 1/s, and beta, s, of the modes
    spin_stiffness : (6, k, k) of `CentrifugalStiffness`, or None
    yield_stress : stress, Pa, above which a run warns; None: the lowest yield stress of explicit parts of its
        material, if any
    Raises ModelError for vectors that contain rigid motion, because the step limit would be wrong, and for a
        yield stress that is not positive, or of a body of matrices.
    """

    body: FlexibleBody
    vectors: NDArray[np.float64] = field(repr=False)
    frequencies: NDArray[np.float64] = field(repr=False)
    mass_damping: float = 0.0
    stiffness_damping: float = 0.0
    spin_stiffness: NDArray[np.float64] | None = field(default=None, repr=False)
    yield_stress: float | None = None

    # No nonlinear terms in the equations of floating frames.
    cubic: ClassVar[None] = None
    damping_cubic: ClassVar[None] = None
    quartic_blocks: ClassVar[None] = None
    damping_quartic_blocks: ClassVar[None] = None
    condensed: ClassVar[None] = None

    def __post_init__(self) -> None:
        if self.yield_stress is not None and not self.yield_stress > 0:
            raise ModelError(
                f"the yield stress of part '{self.name}' must be positive, got {self.yield_stress}"
            )
        if self.yield_stress is not None and self.body.model is None:
            raise ModelError(
                f"part '{self.name}' has no elements, only matrices, so its stress is unknown: leave its "
                "yield stress out"
            )
        R, M = self.body.rigid_modes, self.body.mass
        shared = self.vectors.T @ (M @ R) / np.sqrt(np.einsum("ij,ij->j", R, M @ R))
        if (worst := float(np.abs(shared).max(initial=0.0))) > LARGEST_RIGID_PART:
            raise ModelError(
                f"mode {int(np.abs(shared).max(axis=1).argmax()) + 1} of body '{self.body.name}' contains "
                f"rigid motion (product {worst:.1e}, allowed {LARGEST_RIGID_PART:.0e}), which the frame "
                "already has: the step limit would be wrong. Make the modes M-orthogonal to rigid motion, "
                "as modal_subdomain does"
            )

    @property
    def name(self) -> str:
        """Name of the body."""
        return self.body.name

    kind: ClassVar[Literal["modal"]] = "modal"
    """The literal "modal"."""

    @property
    def n_modes(self) -> int:
        """Number of modes k."""
        return self.vectors.shape[1]

    @property
    def n_coordinates(self) -> int:
        """Number of modes k."""
        return self.n_modes

    @property
    def mass(self) -> float:
        """Total mass, kg."""
        return float(np.asarray(self.moments.S0).sum())

    @property
    def centre_of_mass(self) -> NDArray[np.float64]:
        """(3,) undeformed, in the mesh axes, m: the origin of the frame."""
        return self.points.origin

    @property
    def nodes(self) -> NDArray[np.float64]:
        """(N, 3) undeformed positions."""
        return self.body.nodes

    @property
    def mesh(self) -> Mesh:
        """Mesh of its elements; ModelError for a body of matrices."""
        if self.body.model is None:
            raise ModelError(
                f"part '{self.name}' has no mesh, only matrices: ties, contacts and loads need its elements"
            )
        return self.body.model.mesh

    @cached_property
    def interfaces(self) -> tuple[NodeSet, ...]:
        """The interfaces of its body, and the node sets of its mesh that have other names."""
        of_body = {
            each.name: NodeSet(
                self, each.name, each.node_ids, each.position, np.asarray(each.motion @ self.vectors)
            )
            for each in self.body.interfaces
        }
        sets = {} if self.body.model is None else dict(self.body.model.mesh.node_sets)
        return (*of_body.values(), *node_sets(self, {k: v for k, v in sets.items() if k not in of_body}))

    def interface(self, name: str) -> NodeSet:
        """Node set by name; an unknown name raises ModelError with the nearest name, or all names."""
        return interface_named(self.name, name, self.interfaces)

    @cached_property
    def nodal_basis(self) -> NDArray[np.float64]:
        """Nodal displacements (and rotations) per unit coordinate, (n_nodal, k)."""
        return np.asarray(self.body.expansion @ self.vectors)

    @property
    def displacement_basis(self) -> NDArray[np.float64]:
        """Nodal displacements per unit coordinate, (N, 3, k)."""
        return self.nodal_basis.reshape(len(self.nodes), self.dofs_per_node, -1)[:, :3]

    @property
    def dofs_per_node(self) -> int:
        """3 (solids) or 6 (shells)."""
        return self.body.dofs_per_node

    def expand(
        self, coordinates: ArrayLike, nodes: NDArray[np.intp] | slice = slice(None)
    ) -> NDArray[np.float64]:
        """Displacements (..., k, 3) of some nodes, or all, in the body's frame."""
        return np.einsum("nik,...k->...ni", self.displacement_basis[nodes], np.asarray(coordinates))

    def nodal_fields(
        self, coordinates: NDArray[np.float64], freedoms: NDArray[np.intp] | slice = slice(None)
    ) -> tuple[NDArray[np.float64], None]:
        """Displacements (n, t) of nodal freedoms for coordinates (t, k), and None: none is condensed."""
        return self.nodal_basis[freedoms] @ coordinates.T, None

    has_linear_strains: ClassVar[bool] = True
    """True: strains are linear in the coordinates."""

    @cached_property
    def gram(self) -> NDArray[np.float64]:
        """Inertia Gram matrix (6 + 4k, 6 + 4k) in the axes of the mesh, as for a `ReducedBody`."""
        return inertia_gram(self.body, self.vectors)

    @property
    def stiffness(self) -> NDArray[np.float64]:
        """(k, k) diag(omega^2)."""
        return np.diag(self.frequencies**2)

    @property
    def damping(self) -> NDArray[np.float64]:
        """(k, k) alpha I + beta diag(omega^2)."""
        return self.mass_damping * np.eye(self.n_modes) + self.stiffness_damping * self.stiffness

    @property
    def is_linear(self) -> bool:
        """True without centrifugal stiffness."""
        return self.spin_stiffness is None

    def lowest_frequency(self) -> float:
        """Lowest frequency of the free modes, rad/s; infinite without any."""
        return float(self.frequencies.min(initial=np.inf))

    rotation_limit: ClassVar[float] = 0.1
    """Limit of rotation relative to the frame, rad: foreshortening theta^2 / 2 is half a percent."""

    @property
    def rotation_rows(self) -> NDArray[np.float64] | None:
        """Rotation vectors at P points per modal coordinate, (3 P, k); None for a body of matrices."""
        operator = self.body.rotation_operator
        return None if operator is None else operator @ self.body.expansion @ self.vectors

    @cached_property
    def points(self) -> FramePoints:
        """Points at the centre of mass, with arms of the radius of gyration."""
        own = rigid_mass_properties(self.body.nodal_mass, self.body.nodes, self.body.dofs_per_node)
        return FramePoints(own.centre, float(np.sqrt(np.trace(own.inertia) / (2 * own.mass))))

    @cached_property
    def shapes(self) -> NDArray[np.float64]:
        """Local displacements of the nodes per modal coordinate, in units of the arm, (N, 3, k)."""
        return self.displacement_basis / self.points.arm

    @cached_property
    def moments(self) -> Moments:
        """Sums over its mass."""
        return moments(mass_fields(self.body, self.points, self.vectors))

    @property
    def step_limit(self) -> float:
        """Longest stable step of the undamped modes with their frame, s."""
        return true_limit(self.moments, self.points, np.diag(self.frequencies**2))

    def compiled(self) -> FrameModel:
        """Arrays of the time integration; ModelError for modes that are not mass-normalised."""
        M_V = local_mass(self.moments, self.points.arm)
        if self.n_modes and np.abs(M_V - np.eye(self.n_modes)).max() > 1e-8:
            raise ModelError(
                f"the modes of body '{self.name}' are not mass-normalised: use modal_subdomain, which "
                "normalises them"
            )
        return FrameModel(
            self.moments,
            jnp.diag(jnp.asarray(self.frequencies**2)),
            jnp.asarray(self.points.squared_lengths),
            jnp.asarray(self.mass_damping),
            jnp.asarray(self.stiffness_damping),
            None if self.spin_stiffness is None else jnp.asarray(self.spin_stiffness),
        )


@checked_arguments
def modal_subdomain(
    body: FlexibleBody,
    basis: LinearBasisRecipe,
    *,
    highest: float = float("inf"),
    damping: LinearRayleighDamping | None = None,
    stiffening: CentrifugalStiffness | None = None,
    yield_stress: float | None = None,
) -> ModalSubdomain:
    """A linear body as a modal sub-domain for explicit time integration.

        V^T M V = I,   R^T M V = 0,   V^T K V = diag(omega^2)

    The columns of any basis are made M-orthogonal to the six rigid motions and diagonalised. Modes with
    frequencies above `highest` are omitted, because the highest retained frequency limits the step. Such
    modes occur where the basis has constraint modes of many interface freedoms.

    body : FlexibleBody     only `stiffening` uses the quadratic strains of its elements
    basis : NormalModes(..), CraigBampton(..), ErrorControlled(..) or any other recipe
    highest : float         rad/s
    damping : LinearRayleighDamping(..)     of the modes; the frame is undamped
    stiffening : CentrifugalStiffness()     for bodies that rotate freely at more than about 3 % of their
        lowest frequency; None: the stiffness does not depend on the angular velocity
    yield_stress : float    stress, Pa, above which a run warns, because modes stay elastic; None: the lowest
        yield stress of the explicit parts of the same material
    Raises ModelError if no mode is below `highest`, or the body has modal coordinates or a damping matrix;
        and the errors of the recipe.
    Source: [Radioss]; docs/theory/explicit.md for the orthogonality.
    """
    refuse_relative_damping(damping, f"modal sub-domain '{body.name}'")
    if body.damping is not None:
        raise ModelError(
            f"modal sub-domain '{body.name}': a damping matrix is not supported; leave it out, and give "
            "LinearRayleighDamping"
        )
    if body.n_modal:
        raise ModelError(
            f"modal sub-domain '{body.name}': the mass distribution of a body condensed elsewhere (with "
            "modal coordinates) is unknown; give its elements, or join it to the explicit parts as a "
            "reduced body"
        )
    frame = MeanAxisFrame()
    linear = rayleigh_ritz(body, frame, basis.build(body, frame))
    kept = linear.frequencies <= highest
    if not kept.any():
        raise ModelError(
            f"no mode of body '{body.name}' is below {highest:g} rad/s; the lowest is at "
            f"{linear.frequencies[0]:g}: raise `highest`"
        )
    alpha, beta = (0.0, 0.0) if damping is None else (damping.alpha, damping.beta)
    vectors = linear.vectors[:, kept]
    # The sign of a mode is arbitrary; a fixed sign allows a resume in another process.
    signs = np.sign(vectors[np.abs(vectors).argmax(axis=0), np.arange(vectors.shape[1])])
    vectors = vectors * signs
    spun = None if stiffening is None else stiffening.matrices(body, vectors)
    return ModalSubdomain(body, vectors, linear.frequencies[kept], alpha, beta, spun, yield_stress)


body_balances.register(ModalSubdomain, body_balances.dispatch(ReducedBody))
