"""The 61.5 m blade of [Wu2019] section 6.2, with a public definition: body, wind loads, machine.

[Wu2019] gives the size of the mesh, the damping, the step and the tolerance; thickness, material and wind are
in a figure that cannot be read. Here the blade is that of the NREL 5 MW turbine with a constant thickness
that gives the turbine's blade mass and first flap frequency. The loads are those of a blade-element
computation in a turbulent wind of 12 m/s. They are prescribed: computed once at the rated rotor speed, in
axes that rotate with the root.

Axes: x downwind (flap), y towards the trailing edge, z along the span; the rotor rotates about x.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from supple.aero import (
    CosineRamp,
    NodalForces,
    Operation,
    PowerLawShear,
    Wind,
    golden_phases,
    kaimal_series,
    prescribed_forces,
    random_phases,
)
from supple.body import (
    FlexibleBody,
    FullBody,
    RayleighDamping,
    RigidInterface,
    flexible_body,
    rayleigh_from_ratios,
)
from supple.fem import GREEN_LAGRANGE, HomogeneousSection, Isotropic, ShellKinematics, shell_model
from supple.importers import NREL5MW_WEBS, WU2019_GRID, nrel5mw_rotor, nrel5mw_stations
from supple.importers.turbine.nrel5mw import HUB_HEIGHT, HUB_RADIUS
from supple.integrate import Solution
from supple.machine import (
    GROUND,
    At,
    DeadForce,
    Placed,
    PrescribedRotation,
    System,
    Table,
    Turning,
)
from supple.machine.laws.spin_up import SpinUp
from supple.mesh import BladeGrid, Mesh, loft_blade
from supple.quantities import displacement_from_axes, node_positions
from supple.reduction import ReducedBody
from supple_benchmarks.compared_models import ROOT, turned_axes

__all__ = [
    "CASES",
    "PAPER_SPEED",
    "RATED",
    "Blade",
    "BladeCase",
    "TipMotion",
    "blade_damping",
    "root_clamped_frequencies",
    "tip_motion",
]

Array = NDArray[np.float64]

BODY = "blade"

SECTION = HomogeneousSection(Isotropic(61.13e9, 0.3, 1474.9), 0.02)
"""Gives a mass of 17 740 kg, and a first frequency of 0.675 Hz within 0.7 %. The frequency of a thin wall
depends on E / rho only."""
DAMPING_RATIO = 0.02
RATED_SPEED = 1.267
"""rad/s, 12.1 rpm; the speed for which the loads are computed."""
OPERATION = Operation(angular_speed=RATED_SPEED, pitch=float(np.radians(3.4)))
MEAN_WIND = 12.0
SHEAR = PowerLawShear(hub_height=HUB_HEIGHT)
COARSE_GRID = BladeGrid(
    nose_panel=2, cap=1, aft_panel=2, web_depth=1, root_segments=1, web_segments=20, tip_segments=1
)
LOAD_STEP = 0.02
"""s, between the rows of the load table; the shortest period of the wind is 2 s."""
AXIS = (1.0, 0.0, 0.0)
_MEAN_OVER = 100.0
"""s, period of the lowest harmonic of the wind: the mean load is averaged over it."""


@dataclass(frozen=True)
class BladeCase:
    """A rotor speed, rad/s. The loads are those of the rated speed in every case.

    At 8 rad/s the tip speed would be Mach 1.5, where blade-element theory does not apply: that case tests
    stiffening.
    """

    name: str
    speed: float
    start: float = 10.0
    """s, rise time of the rotor speed and of the loads"""

    @property
    def spin(self) -> SpinUp:
        """Angle of the root over time, from rest."""
        return SpinUp(self.speed, self.start)


RATED = BladeCase("rated", RATED_SPEED)
PAPER_SPEED = BladeCase("paper speed", 8.0, start=20.0)
"""With a rise time of 10 s instead of 20 s the blade bends 1.4 m edgewise and its skin buckles."""
CASES = (RATED, PAPER_SPEED)


@dataclass(frozen=True)
class Blade:
    """The blade on a grid. Its root is a rigid interface whose virtual node lies on the rotor's axis."""

    grid: BladeGrid = WU2019_GRID

    @cached_property
    def mesh(self) -> Mesh:
        """Triangles of skin and webs."""
        return loft_blade(nrel5mw_stations(), NREL5MW_WEBS, self.grid)

    def body(self, kinematics: ShellKinematics = GREEN_LAGRANGE) -> FlexibleBody:
        """The flexible blade."""
        model = shell_model(self.mesh, SECTION, kinematics=kinematics)
        return flexible_body(BODY, model, [RigidInterface(ROOT, "root", position=(0.0, 0.0, -HUB_RADIUS))])

    @cached_property
    def leading_edge(self) -> NDArray[np.int64]:
        """Nodes that carry the loads, from root to tip."""
        nodes = np.asarray(self.mesh.nodes_of("leading_edge"))
        return nodes[np.argsort(self.mesh.nodes[nodes, 2])]

    def mean_wind(self, case: BladeCase) -> Array:
        """Mean wind load on the nodes of the leading edge, N, in the root's axes, (k, 3)."""
        after = round(case.start / LOAD_STEP)
        return self.loads(case, _MEAN_OVER).forces[after:].mean(axis=0)

    def steady_load(self, body: FlexibleBody, case: BladeCase) -> Array:
        """Mean wind load and centrifugal load.

        Returns
        -------
        array (n_nodal, 2)      wind, centrifugal
        """
        wind = np.zeros((len(body.nodes), body.dofs_per_node))
        wind[self.leading_edge, :3] = self.mean_wind(case)
        outwards = np.zeros_like(wind)
        outwards[:, 1] = body.nodes[:, 1]
        outwards[:, 2] = body.nodes[:, 2] + HUB_RADIUS
        centrifugal = case.speed**2 * (body.nodal_mass @ outwards.ravel())
        return np.column_stack([wind.ravel(), centrifugal])

    def loads(self, case: BladeCase, duration: float, *, seed: int | None = None) -> NodalForces:
        """Loads on the leading edge, N, in the root's axes; the seed determines the phases of the turbulence.

        Longitudinal Kaimal turbulence as 50 harmonics of 0.01 Hz, sigma = 1.2 m/s, L = 340.2 m.
        """
        phase = golden_phases(50) if seed is None else random_phases(50, seed=seed)
        turbulence = kaimal_series(
            mean_speed=MEAN_WIND, deviation=1.2, length_scale=340.2, frequency_step=0.01, phase=phase
        )
        return prescribed_forces(
            nrel5mw_rotor(),
            OPERATION,
            Wind(mean_speed=MEAN_WIND, shear=SHEAR, turbulence=turbulence),
            span=self.mesh.nodes[self.leading_edge, 2],
            hub_radius=HUB_RADIUS,
            times=np.arange(round(duration / LOAD_STEP) + 1) * LOAD_STEP,
            ramp=CosineRamp(case.start),
        )

    def system(self, body: FullBody | ReducedBody, case: BladeCase, loads: NodalForces) -> System:
        """The blade driven about the rotor's axis under its loads; without gravity, as in the definition."""
        shaft = PrescribedRotation(
            name="shaft", first=GROUND, second=At(BODY, ROOT), axis=AXIS, angle=case.spin
        )
        force = DeadForce(
            body=BODY,
            at=self.leading_edge,
            force=Turning(Table(loads.times, loads.forces), AXIS, case.spin),
        )
        return System(bodies=(Placed(body),), joints=(shaft,), loads=(force,))


def root_clamped_frequencies(body: FlexibleBody, n: int = 5) -> Array:
    """The n lowest angular frequencies of the blade clamped at its root, rad/s."""
    modes = body.lowest_modes(n, body.interface(ROOT).motion.toarray())
    return np.sqrt(modes.values)


def blade_damping(frequencies: Array) -> RayleighDamping:
    """Damping with a ratio of two per cent at the first two of the given angular frequencies, rad/s."""
    return rayleigh_from_ratios(DAMPING_RATIO, float(frequencies[0]), float(frequencies[1]))


@dataclass(frozen=True)
class TipMotion:
    """Mean displacement of the tip section in axes that rotate with the root: m, (t,) each."""

    times: Array
    flap: Array
    edge: Array
    span: Array

    @property
    def amplitude(self) -> float:
        """Largest distance of the tip from its position on the undeformed blade."""
        return float(np.sqrt(self.flap**2 + self.edge**2 + self.span**2).max())


def tip_motion(blade: Blade, case: BladeCase, body: FullBody | ReducedBody, solution: Solution) -> TipMotion:
    """Motion of the tip relative to the root."""
    tip = blade.mesh.nodes_of("tip")
    positions = node_positions(body, solution.bodies[BODY], tip).mean(axis=1)
    rest = body.nodes[tip].mean(axis=0) + np.array([0.0, 0.0, HUB_RADIUS])
    axis = [0.0, 0.0, -HUB_RADIUS]
    seen = displacement_from_axes(positions, axis, turned_axes(AXIS, case.spin(solution.times)), rest)
    return TipMotion(solution.times, *seen.T)
