"""Common properties of solid and shell parts as bodies of a machine."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.arrays import FloatArray
from supple.body.floating_kinematics import checked_nodes
from supple.body.form_defaults import FormDefaults
from supple.body.interface import interface_named
from supple.body.point_motion import InterfaceMotion, NodeMotion
from supple.errors import ModelError
from supple.fem import FiniteElementModel, node_masses, refuse_attached
from supple.integrate import FramedMotion
from supple.integrate.motion import Motion
from supple.mesh import Mesh
from supple.methods.explicit.materials import Law
from supple.methods.explicit.motions import NodalMotion
from supple.methods.explicit.node_set import NodeSet, node_sets

SHEAR = 0.01
"""Largest relative difference, due to rounded constants, of a stated shear modulus from E / (2 (1 + nu))."""


def refuse_beside_elements(what: str, model: FiniteElementModel) -> None:
    """Raise ModelError unless all attachments of the model are masses without inertia at nodes."""
    refuse_attached(replace(model.attached, mass=None), what)
    node_masses(model)


def check_law(what: str, law: Law | None, densities: Iterable[float], deletion: float) -> None:
    """Raise ModelError for an invalid law, density or plastic strain of deletion.

    law : None: elastic
    """
    if not deletion > 0:
        raise ModelError(f"{what}: the plastic strain of deletion must be positive, got {deletion}")
    if np.isfinite(deletion) and (law is None or law.plastic_strain(law.initial((1, 1))) is None):
        raise ModelError(
            f"{what}: its law has no plastic strain, so deletion = {deletion:g} has no effect; give "
            "J2Plasticity(..), or leave deletion out"
        )
    if min(densities, default=1.0) <= 0:
        raise ModelError(
            f"{what}: an explicit part needs mass, and its density is 0; give its materials, and the "
            "material of its law, a density"
        )
    if law is None:
        return
    own = law.elastic
    implied = own.youngs_modulus / (2 * (1 + own.poissons_ratio))
    if abs(own.shear_modulus - implied) > SHEAR * implied:
        raise ModelError(
            f"{what}: its material states a shear modulus of {own.shear_modulus:.4g}, but laws are "
            f"isotropic, with E / (2 (1 + nu)) = {implied:.4g}; leave the shear modulus out"
        )


class ElementPart(FormDefaults):
    """`BodyForm` without a frame, for large rotations; its coordinates are the displacements of its nodes."""

    name: str
    model: FiniteElementModel

    @cached_property
    def masses(self) -> FloatArray:
        """(N,) lumped masses, kg."""
        raise NotImplementedError

    kind: ClassVar[Literal["explicit"]] = "explicit"
    """The literal "explicit"."""
    has_frame: ClassVar[bool] = False
    """False: the displacements of its nodes are not relative to a frame."""

    @property
    def mesh(self) -> Mesh:
        """Mesh of its elements."""
        return self.model.mesh

    @property
    def nodes(self) -> FloatArray:
        """(N, 3) undeformed positions."""
        return self.model.mesh.nodes

    @property
    def mass(self) -> float:
        """Total mass, kg."""
        return float(self.masses.sum())

    @property
    def centre_of_mass(self) -> FloatArray:
        """(3,) undeformed, in the mesh axes, m."""
        return self.masses @ self.nodes / self.mass

    @property
    def n_coordinates(self) -> int:
        """Number of nodal displacements, three per node."""
        return self.nodes.size

    @cached_property
    def interfaces(self) -> tuple[NodeSet, ...]:
        """The node sets of its mesh."""
        return node_sets(self, self.mesh.node_sets)

    def interface(self, name: str) -> NodeSet:
        """Node set by name; an unknown name raises ModelError with the nearest name, or all names."""
        return interface_named(self.name, name, self.interfaces)

    def expand(self, coordinates: ArrayLike, nodes: NDArray[np.intp] | slice = slice(None)) -> FloatArray:
        """Displacements (..., k, 3) of some or all nodes from the coordinates (..., 3 N)."""
        given = np.asarray(coordinates)
        return given.reshape(*given.shape[:-1], -1, 3)[..., nodes, :]

    def nodal_fields(
        self, coordinates: FloatArray, freedoms: NDArray[np.intp] | slice = slice(None)
    ) -> tuple[FloatArray, None]:
        """Displacements (n, t) of nodal freedoms for coordinates (t, 3 N), and None: none is condensed."""
        return coordinates.T[freedoms], None

    def positions(self, motion: Motion, nodes: ArrayLike | slice = slice(None)) -> FloatArray:
        """Positions (t, k, 3) in space of some nodes, or all."""
        own = nodes if isinstance(nodes, slice) else checked_nodes(nodes, len(self.nodes))
        return motion.of_type(NodalMotion).nodes[:, own]

    def node_motion(self, motion: Motion, nodes: ArrayLike) -> NodeMotion:
        """Positions, velocities and accelerations (t, k, 3) of some nodes in space."""
        own, moved = checked_nodes(nodes, len(self.nodes)), motion.of_type(NodalMotion)
        return NodeMotion(moved.nodes[:, own], moved.velocities[:, own], moved.accelerations[:, own])

    def interface_motion(self, motion: Motion, name: str) -> InterfaceMotion:
        """Mean motion (t, ...) of a node set in space, by `NodeSet.moving`."""
        own = self.interface(name)
        return own.moving(self.node_motion(motion, own.nodes))

    def motion_near(self, *_: FloatArray) -> FramedMotion:
        """Raise ModelError: the part has no frame about which a motion could be small."""
        raise ModelError(
            f"body '{self.name}' has explicit finite elements, which have no small motions about a frame: "
            "use a modal_subdomain or a reduced body"
        )

    is_linear: ClassVar[bool] = False
    """False: its strains are nonlinear in the displacements."""

    rotation_limit: ClassVar[float] = np.inf
    """Infinite: rotations are not limited."""

    def lowest_frequency(self) -> float:
        """Infinite: the frequency is not computed, because nothing depends on it."""
        return np.inf
