"""Planar geometrically exact beam: arbitrary large rotation, quadratic elements, inertial frame."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from supple.errors import ModelError

Array = NDArray[np.float64]

# A node has x, y and the section's rotation; an element has three nodes and shares those at its ends.
NODE_SIZE = 3
ELEMENT_SIZE = 9
BANDWIDTH = ELEMENT_SIZE - 1


@dataclass(frozen=True, kw_only=True)
class PlanarBeam:
    """Straight uniform beam in a plane; every property positive and finite, any consistent units.

    Raises
    ------
    ModelError  a property that is not a positive finite number
    """

    length: float
    axial_stiffness: float
    shear_stiffness: float
    bending_stiffness: float
    mass_per_length: float
    rotary_inertia_per_length: float

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value > 0.0):
                raise ModelError(f"planar beam: {field.name} is {value}; give a positive finite number")


ROTATING_BEAM = PlanarBeam(
    length=10.0,
    axial_stiffness=2.8e7,
    shear_stiffness=1.0e7,
    bending_stiffness=1.4e4,
    mass_per_length=1.2,
    rotary_inertia_per_length=6.0e-4,
)
"""The flexible robot arm of [SimoVuQuoc1986], part II; [Wu2019] section 6.1 models it by shells."""


@dataclass(frozen=True)
class BeamElements:
    """A beam divided into equal three-node Simo-Reissner elements.

    With the section axes t1 = (cos theta, sin theta), t2 = (-sin theta, cos theta) and ' = d/ds:

        stretch eps = t1 . r' - 1        shear gamma = t2 . r'        curvature kappa = theta'
        U = 1/2 int (EA eps^2 + GA gamma^2 + EI kappa^2) ds
        T = 1/2 int (rho A |dr/dt|^2 + rho I (dtheta/dt)^2) ds

    Two Gauss points integrate U, one fewer than full integration, which avoids shear and membrane locking.
    In a plane the mass matrix is constant. Configurations are arrays (..., N, 3) of x, y, theta at the
    N = 2 n_elements + 1 nodes; forces and velocities have the same layout.

    Raises
    ------
    ModelError  fewer than one element
    Source: [SimoVuQuoc1986]
    """

    beam: PlanarBeam
    n_elements: int

    def __post_init__(self) -> None:
        if self.n_elements < 1:
            raise ModelError(f"planar beam: n_elements is {self.n_elements}; give at least one")

    @property
    def n_nodes(self) -> int:
        """Number N of nodes."""
        return 2 * self.n_elements + 1

    @property
    def element_length(self) -> float:
        """Length of one element along the undeformed beam."""
        return self.beam.length / self.n_elements

    @cached_property
    def arc_length(self) -> Array:
        """Position of the nodes along the undeformed beam (N,)."""
        return np.linspace(0.0, self.beam.length, self.n_nodes)

    @cached_property
    def element_nodes(self) -> NDArray[np.int64]:
        """Nodes of each element, from root to tip (E, 3)."""
        return 2 * np.arange(self.n_elements)[:, None] + np.arange(3)

    def straight(self, angle: float) -> Array:
        """Undeformed configuration (N, 3), rotated about its root at the origin."""
        s = self.arc_length
        return np.stack([s * math.cos(angle), s * math.sin(angle), np.full_like(s, angle)], axis=-1)

    def strain_energy(self, configuration: Array) -> Array:
        """Strain energy U of configurations (..., N, 3); shape (...)."""
        strain, _ = self._strain(configuration[..., self.element_nodes, :])
        return 0.5 * np.einsum("...egs,s->...", strain**2, self._section_stiffness) * self._point_weight

    def kinetic_energy(self, velocity: Array) -> Array:
        """Kinetic energy T of velocities (..., N, 3); shape (...)."""
        return 0.5 * np.einsum("...ni,...ni->...", velocity, self.momentum(velocity))

    def momentum(self, velocity: Array) -> Array:
        """Mass matrix times velocities (..., N, 3): linear and angular momentum of the nodes."""
        per_element = np.einsum("ab,...ebi->...eai", self._shape_mass, velocity[..., self.element_nodes, :])
        nodal = np.zeros(velocity.shape)
        # Odd nodes lie inside one element, even nodes join two: three sliced sums replace a scatter.
        nodal[..., 1::2, :] = per_element[..., 1, :]
        nodal[..., 0:-1:2, :] += per_element[..., 0, :]
        nodal[..., 2::2, :] += per_element[..., 2, :]
        return nodal * self._inertia_density

    def internal_force(self, configuration: Array) -> Array:
        """Gradient (3N,) of the strain energy of one configuration (N, 3)."""
        strain, section_axes = self._strain(configuration[self.element_nodes])
        return self._scatter(self._element_force(strain, section_axes))

    def residual_and_tangent(
        self, configuration: Array, acceleration: Array, mass_factor: float
    ) -> tuple[Array, Array, Array]:
        """Inertia plus internal force, internal force alone, and banded K_t + mass_factor M.

        Returns
        -------
        residual, internal force : (3N,)
        tangent : (2 BANDWIDTH + 1, 3N)   in the layout of scipy.linalg.solve_banded
        """
        strain, section_axes = self._strain(configuration[self.element_nodes])
        internal = self._scatter(self._element_force(strain, section_axes))
        residual = internal + self.momentum(acceleration).reshape(-1)
        curvature_of_energy = self._energy_hessian(strain, section_axes)
        elements = curvature_of_energy.reshape(self.n_elements, -1) @ self._congruence
        elements += mass_factor * self.element_mass.reshape(-1)
        return residual, internal, self.to_banded(elements)

    def banded_mass(self) -> Array:
        """Mass matrix in the banded layout of the tangent."""
        return self.to_banded(np.tile(self.element_mass.reshape(-1), (self.n_elements, 1)))

    def to_banded(self, element_matrices: Array) -> Array:
        """Assemble element matrices (E, 81) into the banded layout (2 BANDWIDTH + 1, 3N)."""
        size = (2 * BANDWIDTH + 1) * NODE_SIZE * self.n_nodes
        flat = np.bincount(self._banded_position, weights=element_matrices.reshape(-1), minlength=size)
        return flat.astype(float, copy=False).reshape(2 * BANDWIDTH + 1, -1)

    @cached_property
    def element_mass(self) -> Array:
        """Consistent mass matrix (9, 9) of one element."""
        return np.kron(self._shape_mass, np.diag(self._inertia_density)).astype(float, copy=False)

    @cached_property
    def _section_stiffness(self) -> Array:
        return np.array([self.beam.axial_stiffness, self.beam.shear_stiffness, self.beam.bending_stiffness])

    @cached_property
    def _inertia_density(self) -> Array:
        translation = self.beam.mass_per_length
        return np.array([translation, translation, self.beam.rotary_inertia_per_length])

    @cached_property
    def _shape_mass(self) -> Array:
        points, weights = leggauss(3)
        values, _ = _quadratic_shapes(points)
        return 0.5 * self.element_length * np.einsum("g,ga,gb->ab", weights, values, values)

    @property
    def _point_weight(self) -> float:
        return 0.5 * self.element_length

    @cached_property
    def _shapes(self) -> tuple[Array, Array]:
        """Values and arc-length derivatives of the shape functions at the two Gauss points, each (2, 3)."""
        points, _ = leggauss(2)
        values, slopes = _quadratic_shapes(points)
        return values, slopes * (2.0 / self.element_length)

    @cached_property
    def _gradient_operator(self) -> Array:
        """G (2, 4, 9): element degrees of freedom to (x', y', theta, theta') at the Gauss points."""
        values, slopes = self._shapes
        G = np.zeros((2, 4, 3, 3))
        G[:, 0, :, 0] = slopes
        G[:, 1, :, 1] = slopes
        G[:, 2, :, 2] = values
        G[:, 3, :, 2] = slopes
        return G.reshape(2, 4, ELEMENT_SIZE)

    @cached_property
    def _congruence(self) -> Array:
        """(32, 81): sum_g w G_g^T H_g G_g as one matrix product over the flattened H."""
        G = self._gradient_operator
        return self._point_weight * np.einsum("gia,gjb->gijab", G, G).reshape(32, -1)

    @cached_property
    def _freedoms(self) -> NDArray[np.int64]:
        nodes = self.element_nodes[:, :, None] * NODE_SIZE + np.arange(NODE_SIZE)
        return nodes.reshape(self.n_elements, ELEMENT_SIZE)

    @cached_property
    def _banded_position(self) -> NDArray[np.int64]:
        row, column = self._freedoms[:, :, None], self._freedoms[:, None, :]
        return ((BANDWIDTH + row - column) * (NODE_SIZE * self.n_nodes) + column).reshape(-1)

    def _strain(self, element_configuration: Array) -> tuple[Array, Array]:
        """Strains (..., E, 2, 3) and (cos theta, sin theta) (..., E, 2, 2) at the Gauss points."""
        values, slopes = self._shapes
        gradient = np.matmul(slopes, element_configuration)
        angle = np.matmul(element_configuration[..., 2], values.T)
        c, s = np.cos(angle), np.sin(angle)
        x_s, y_s = gradient[..., 0], gradient[..., 1]
        strain = np.stack([c * x_s + s * y_s - 1.0, c * y_s - s * x_s, gradient[..., 2]], axis=-1)
        return strain, np.stack([c, s], axis=-1)

    def _element_force(self, strain: Array, section_axes: Array) -> Array:
        c, s = section_axes[..., 0], section_axes[..., 1]
        N, Q, M = np.moveaxis(strain * self._section_stiffness, -1, 0)
        # d eps = t1 . dr' + gamma dtheta and d gamma = t2 . dr' - (1 + eps) dtheta.
        turning = N * strain[..., 1] - Q * (1.0 + strain[..., 0])
        by_gradient = np.stack([c * N - s * Q, s * N + c * Q, turning, M], axis=-1)
        operator = self._point_weight * self._gradient_operator.reshape(8, ELEMENT_SIZE)
        return by_gradient.reshape(self.n_elements, 8) @ operator

    def _energy_hessian(self, strain: Array, section_axes: Array) -> Array:
        """Second derivative (E, 2, 4, 4) of the energy density by (x', y', theta, theta')."""
        c, s = section_axes[..., 0], section_axes[..., 1]
        eps, gamma = strain[..., 0], strain[..., 1]
        EA, GA, EI = self._section_stiffness
        N, Q = EA * eps, GA * gamma
        H = np.zeros((*eps.shape, 4, 4))
        H[..., 0, 0] = EA * c**2 + GA * s**2
        H[..., 1, 1] = EA * s**2 + GA * c**2
        H[..., 0, 1] = H[..., 1, 0] = (EA - GA) * c * s
        # With theta: B^T D B, then N d2(eps) + Q d2(gamma), where dt1 = t2 dtheta and dt2 = -t1 dtheta.
        H[..., 0, 2] = H[..., 2, 0] = EA * c * gamma + GA * s * (1.0 + eps) - N * s - Q * c
        H[..., 1, 2] = H[..., 2, 1] = EA * s * gamma - GA * c * (1.0 + eps) + N * c - Q * s
        H[..., 2, 2] = EA * gamma**2 + GA * (1.0 + eps) ** 2 - N * (1.0 + eps) - Q * gamma
        H[..., 3, 3] = EI
        return H

    def _scatter(self, element_force: Array) -> Array:
        size = NODE_SIZE * self.n_nodes
        nodal = np.bincount(self._freedoms.reshape(-1), weights=element_force.reshape(-1), minlength=size)
        return nodal.astype(float, copy=False)


def _quadratic_shapes(points: Array) -> tuple[Array, Array]:
    """Three-node shape functions and their derivatives at points in [-1, 1], each (g, 3)."""
    values = np.stack(
        [0.5 * points * (points - 1.0), 1.0 - points**2, 0.5 * points * (points + 1.0)], axis=-1
    )
    slopes = np.stack([points - 0.5, -2.0 * points, points + 0.5], axis=-1)
    return values, slopes
