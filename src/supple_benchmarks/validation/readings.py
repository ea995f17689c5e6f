"""Sensors, split bodies, masses of curved cells, and a bar with an imported singular mass matrix."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from supple.algebra import lowest_modes
from supple.body import (
    FullBody,
    NodalFixedFrame,
    RigidBody,
    RigidInterface,
    flexible_body,
    mesh_mass_properties,
    superelement,
)
from supple.fem import CellMass, HomogeneousSection, Isotropic, shell_model, solid_model
from supple.fem.mass import nodal_mass_matrix
from supple.fem.solid_element import SolidElement, solid_mass
from supple.integrate import FixedStep, Run
from supple.machine import (
    GROUND,
    At,
    BaseAcceleration,
    Fixed,
    Placed,
    Prismatic,
    Scaled,
    Sine,
    SpringDamper,
    System,
    split_body,
)
from supple.mesh import AlongAxis, CellType, Mesh, block, cylinder, strip
from supple.mesh.quadrature import four_point_tetrahedron
from supple.quantities import AccelerationSensor, Component, Mean, Place, StressSensor, read_sensors
from supple.simulation import equilibrium, simulate
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase, largest_difference

__all__ = ["CASES"]

# Poisson's ratio zero: a strip with an end clamped across its whole width deforms as a beam.
STEEL = Isotropic(2.1e11, 0.0, 7850.0)


def stress_over_a_set() -> Sequence[Comparison]:
    """Stress of a cantilever strip under its own weight, at nodes at 1/4 and 3/4 of its length."""
    length, height, gravity = 1.0, 0.01, 9.81
    model = shell_model(strip(length, 0.1, 24, 2), HomogeneousSection(STEEL, height))
    body = flexible_body("strip", model, (RigidInterface("root", "root"),))
    system = System(
        (Placed(FullBody(body, NodalFixedFrame("root"))),),
        (Fixed(first=GROUND, second=At("strip", "root")),),
        gravity=np.array([0.0, 0.0, -gravity]),
    )
    x = model.mesh.nodes[:, 0]
    rows = np.flatnonzero(np.isclose(x, 0.25) | np.isclose(x, 0.75))
    sensors = [
        StressSensor("largest", "strip", model, rows, Component("xx")),
        StressSensor("mean", "strip", model, rows, Component("xx"), Mean()),
    ]
    largest, mean = read_sensors(sensors, system, equilibrium(system).solution)

    def fibre(place: float) -> float:
        return STEEL.density * height * gravity * (length - place) ** 2 / 2 * 6 / height**2

    source = "closed form: M c / I of a cantilever under its own weight"
    middle = (fibre(0.25) + fibre(0.75)) / 2
    return [
        Comparison(
            "largest stress of the set, upper side, Pa", largest.values[0, 2], fibre(0.25), source, 5e-3
        ),
        Comparison(
            "position of the largest stress, m",
            float(np.asarray(largest.points)[0, 2, 0]),
            0.25,
            source,
            1e-12,
        ),
        Comparison("mean stress of the set, Pa", mean.values[0, 2], middle, source, 5e-3),
    ]


def accelerometer_on_a_shaken_base() -> Sequence[Comparison]:
    """Acceleration in space of a mass on a spring, whose base is shaken harmonically from rest."""
    mass, stiffness, size, rate = 2.0, 800.0, 3.0, 13.0
    block_ = RigidBody("block", mass, np.zeros(3), np.eye(3), {"eye": np.zeros(3)})
    spring = SpringDamper(
        first=At("block", "eye"), second=GROUND, anchor=(0.0, 0.0, 1.0), stiffness=stiffness, rest_length=1.0
    )
    guide = Prismatic(first=GROUND, second=At("block", "eye"), axis=(0.0, 0.0, 1.0))
    shaken = BaseAcceleration(acceleration=Scaled((0.0, 0.0, size), Sine(1.0, rate / (2 * np.pi))))
    system = System((Placed(block_),), (guide,), (spring, shaken))
    solution = simulate(system, Run(0.5, 0.005, FixedStep(0.0005)))
    times, own = solution.times, np.sqrt(stiffness / mass)
    relative = -size / (own**2 - rate**2) * (np.sin(rate * times) - rate / own * np.sin(own * times))
    (found,) = read_sensors([AccelerationSensor("a", Place("block", "eye"))], system, solution)
    source = "closed form: x'' in space = - w^2 x, x relative to the table"
    return [
        largest_difference(
            "acceleration in space, m/s2", found.values[:, 2], -(own**2) * relative, source, 5e-3
        )
    ]


def split_strip() -> Sequence[Comparison]:
    """A strip of 15 rows of cells in two and in four parts: no row of nodes lies at an exact cut."""
    length, height = 1.0, 5e-3
    model = shell_model(strip(length, 0.05, 15, 2), HomogeneousSection(STEEL, height))
    speed = np.sqrt(STEEL.youngs_modulus * height**2 / 12 / STEEL.density)
    exact = 4.730040745**2 / length**2 * speed
    source = "closed form: first bending frequency of a free beam"
    return [
        Comparison(
            f"first free frequency, {parts} parts, rad/s",
            float(split_body("strip", model, AlongAxis(parts, (1, 0, 0))).frequencies(1)[0]),
            exact,
            source,
            1e-2,
        )
        for parts in (2, 4)
    ]


def curved_cells() -> Sequence[Comparison]:
    """Masses of a cylinder (8 hexahedra around) and a quarter of a ring (4), of ten-node tetrahedra."""
    radius, length = 0.5, 2.0
    bar = mesh_mass_properties(solid_model(cylinder(radius, length, 2, 1, 4, CellType.TETRA10), STEEL))
    mass = STEEL.density * np.pi * radius**2 * length
    inner, outer, height = 1.0, 2.0, 0.5
    ring = mesh_mass_properties(solid_model(_quarter_of_a_ring(inner, outer, height), STEEL))
    weight = STEEL.density * height * np.pi / 4 * (outer**2 - inner**2)
    centre = 4 / (3 * np.pi) * (outer**3 - inner**3) / (outer**2 - inner**2)
    source = "closed form: cylinder, and sector of a ring"
    return [
        Comparison("mass of a cylinder, kg", bar.mass, mass, source, 3e-3),
        Comparison(
            "inertia of the cylinder about its axis, kg m2",
            bar.inertia[0, 0],
            mass * radius**2 / 2,
            source,
            5e-3,
        ),
        Comparison("mass of a quarter of a ring, kg", ring.mass, weight, source, 1e-3),
        Comparison("centre of the quarter of a ring, m", ring.centre[0], centre, source, 1e-3),
    ]


def singular_mass() -> Sequence[Comparison]:
    """A free bar of ten-node tetrahedra; the mass matrix of four points, as in CalculiX, is singular."""
    length = 1.0
    mesh = block(length, 0.1, 0.1, 4, 1, 1, CellType.TETRA10)
    cells = mesh.cells[CellType.TETRA10]
    rule = four_point_tetrahedron()
    of_cells = solid_mass(SolidElement(CellType.TETRA10, rule, rule), mesh.nodes[cells], STEEL.density)
    mass = nodal_mass_matrix((CellMass(cells, of_cells),), mesh.n_nodes, 3)
    bar = superelement("bar", mesh.nodes, solid_model(mesh, STEEL).stiffness, mass, dofs_per_node=3)
    modes = lowest_modes(bar.stiffness, bar.mass, 20)
    along = np.abs((bar.expansion @ modes.vectors).reshape(mesh.n_nodes, 3, -1)).sum(axis=0)
    axial = np.flatnonzero((along[0] > 5 * along[1:].max(axis=0)) & (modes.values > 1.0))
    exact = np.pi / length * np.sqrt(STEEL.youngs_modulus / STEEL.density)
    source = "closed form: first axial frequency of a free bar"
    return [
        Comparison(
            "first axial frequency, rad/s", float(np.sqrt(modes.values[axial[0]])), exact, source, 2e-3
        )
    ]


def _quarter_of_a_ring(inner: float, outer: float, height: float) -> Mesh:
    """A quarter of a ring about z: 2 x 4 x 1 hexahedra (radial, around, axial), each of six tetrahedra."""
    straight = block(outer - inner, 1.0, height, 2, 4, 1, CellType.TETRA10)
    x, y, z = (straight.nodes - straight.nodes.min(axis=0)).T
    angle = 0.5 * np.pi * y
    places = np.column_stack([(inner + x) * np.cos(angle), (inner + x) * np.sin(angle), z])
    return Mesh(places, straight.cells)


CASES = (
    ValidationCase("stress over a node set", stress_over_a_set),
    ValidationCase("accelerometer on a shaken base", accelerometer_on_a_shaken_base),
    ValidationCase("strip split between rows of nodes", split_strip),
    ValidationCase("mass of curved cells", curved_cells),
    ValidationCase("singular mass of an imported bar", singular_mass),
)
