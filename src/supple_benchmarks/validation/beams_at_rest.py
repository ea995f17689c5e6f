"""Equilibria of beams with large bending: each beam is a chain of eight full bodies with floating frames."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ellipe, ellipk

from supple.errors import ValidityWarning
from supple.fem import BeamSection, Isotropic
from supple.machine import DeadForce, DeadTorque, FollowerForce, System
from supple.machine.system import Load
from supple.simulation import equilibrium
from supple_benchmarks.lines import points_along_x
from supple_benchmarks.references.rod import Rod
from supple_benchmarks.validation.beam_chain import BeamChain, beam_chain, rectangle
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase

__all__ = ["CASES"]

Array = NDArray[np.float64]

NONE = (0.0, 0.0, 0.0)


def _loads(
    chain: BeamChain, force: ArrayLike = NONE, torque: ArrayLike = NONE, following: ArrayLike = NONE
) -> Sequence[Load]:
    """Tip loads of all three kinds in every case, zero by default: one compiled program serves all cases."""
    return (
        DeadForce(body=chain.tip.body, at="tip", force=force),
        DeadTorque(first=chain.tip, torque=torque),
        FollowerForce(first=chain.tip, force=following),
    )


def _rested_tip(nodes: ArrayLike, section: BeamSection, **loads: ArrayLike) -> Array:
    """Position (3,) of the tip of a clamped beam along nodes, in equilibrium under tip loads."""
    chain = beam_chain(nodes, section, n_bodies=8)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)  # bodies bend by more than 0.5 rad: this is measured
        rest = equilibrium(System(chain.bodies, chain.joints, _loads(chain, **loads)))
    return rest.system.bodies[-1].positions()[-1]


def bend_of_45_degrees() -> Sequence[Comparison]:
    """A clamped 45 degree arc of radius 100, section 1 x 1, under a tip force of 600 normal to its plane."""
    radius, force = 100.0, np.array([0.0, 0.0, 600.0])
    arc = np.linspace(0, np.pi / 4, 17)
    nodes = radius * np.column_stack([np.sin(arc), 1 - np.cos(arc), 0 * arc])
    material = Isotropic(1e7, 0.0, 1.0)
    tip = _rested_tip(nodes, rectangle(material, 1.0, 1.0, 1 / 6, orientation=(0, 0, 1)), force=force)
    stiffness = np.array([1e7, 5e6 * 5 / 6, 5e6 * 5 / 6, 5e6 / 6, 1e7 / 12, 1e7 / 12])
    exact, _ = Rod(radius * np.pi / 4, stiffness, (0, 0, 1 / radius)).tip(force)
    published = (
        "J. C. Simo, L. Vu-Quoc, Comput. Methods Appl. Mech. Engrg. 58 (1986) 79-116: eight linear elements"
    )
    moved = float(np.linalg.norm(exact - nodes[-1]))
    return (
        Comparison("tip x, m", tip[0], 47.23, published, 3e-3, scale=moved),
        Comparison("tip y, m", tip[1], 15.79, published, 3e-3, scale=moved),
        Comparison("tip z, m", tip[2], 53.37, published, 3e-3, scale=moved),
        Comparison(
            "distance of the tip from the exact rod's, m",
            float(np.linalg.norm(tip - exact)),
            0.0,
            "geometrically exact rod, by shooting",
            1e-3,
            scale=moved,
        ),
    )


THIN = Isotropic(1e7, 0.0, 1.0)
LENGTH = 10.0
BENDING = 1e7 * 0.1**3 / 12
"""E I of a strip 0.1 thick and 1 wide"""


def _strip() -> BeamSection:
    return rectangle(THIN, 1.0, 0.1, 0.1**3 / 3, orientation=(0, 1, 0))


def roll_up() -> Sequence[Comparison]:
    """A tip moment 2 pi E I / L bends a cantilever to a full circle, half of that moment to a half circle."""
    nodes, whole = points_along_x(LENGTH, 16), 2 * np.pi * BENDING / LENGTH
    source = "a circle of radius E I / M"
    half = _rested_tip(nodes, _strip(), torque=(0, -whole / 2, 0))
    full = _rested_tip(nodes, _strip(), torque=(0, -whole, 0))
    return (
        Comparison("height of the tip at half a circle, m", half[2], 2 * LENGTH / np.pi, source, 3e-3),
        Comparison(
            "distance of the tip from the root at a whole one, m",
            float(np.linalg.norm(full)),
            0.0,
            source,
            1e-6,
            scale=LENGTH,
        ),
    )


def elastica() -> Sequence[Comparison]:
    """A cantilever under a transverse dead force at its tip, P L^2 / E I = 10."""
    tip = _rested_tip(points_along_x(LENGTH, 24), _strip(), force=(0, 0, 10 * BENDING / LENGTH**2)) / LENGTH
    source = "K. Mattiasson, Int. J. Numer. Methods Eng. 17 (1981) 145-153, table 1 (elliptic integrals)"
    return (
        Comparison("shortening of the tip / L", 1 - tip[0], 0.55500, source, 2e-3),
        Comparison("deflection of the tip / L", tip[2], 0.81061, source, 2e-3),
    )


def buckled_column() -> Sequence[Comparison]:
    """A clamped column under P = 1.152 times Euler's load P_E: its tip rotates by 60 degrees.

    A lateral tip force bends the column before it buckles, and is then removed.

    P / P_E = (2 K / pi)^2,  x / L = 2 E / K - 1,  z / L = 2 k / K,  k = sin(30 degrees)

    x, z : position of the tip;  K, E : complete elliptic integrals of modulus k
    """
    k = np.sin(np.pi / 6)
    K, E = ellipk(k**2), ellipe(k**2)
    push = K**2 * BENDING / LENGTH**2
    chain = beam_chain(points_along_x(LENGTH, 24), _strip(), n_bodies=8)
    bent = equilibrium(System(chain.bodies, chain.joints, _loads(chain, (-push, 0, push / 2)))).system
    rest = equilibrium(replace(bent, loads=_loads(chain, (-push, 0, 0)))).system
    tip = rest.bodies[-1].positions()[-1] / LENGTH
    source = "S. P. Timoshenko, J. M. Gere, Theory of Elastic Stability (1961), section 2.7"
    return (
        Comparison("height of the tip / L", tip[0], 2 * E / K - 1, source, 5e-3),
        Comparison("deflection of the tip / L", tip[2], 2 * k / K, source, 5e-3),
    )


def follower_force() -> Sequence[Comparison]:
    """A cantilever under a tip force that stays normal to the beam's axis, P L^2 / E I = 8."""
    force = 8 * BENDING / LENGTH**2
    tip = _rested_tip(points_along_x(LENGTH, 24), _strip(), following=(0, 0, force))
    shear = 5e6 * 0.1 * 5 / 6
    exact, _ = Rod(LENGTH, (1e6, shear, shear, 5e6 * 0.1**3 / 3, BENDING, 1e7 * 0.1 / 12)).tip_followed(
        (0, 0, force)
    )
    return (
        Comparison(
            "distance of the tip from the exact rod's, m",
            float(np.linalg.norm(tip - exact)),
            0.0,
            "geometrically exact rod, integrated from its tip",
            2e-3,
            scale=LENGTH,
        ),
    )


def princeton() -> Sequence[Comparison]:
    """The Princeton beam: aluminium, 20 inches long, with a tip force of 3 lb at 45 degrees to y and z."""
    length, height, thickness = 0.508, 12.377e-3, 3.2024e-3
    material = Isotropic(71.7e9, 0.31, 2810.0)
    shear = material.youngs_modulus / 2 / (1 + 0.31)
    torsion = height * thickness**3 / 3 * (1 - 0.63 * thickness / height)
    force = 13.345 * np.array([0, 1, 1]) / np.sqrt(2)
    tip = _rested_tip(
        points_along_x(length, 16), rectangle(material, height, thickness, torsion), force=force
    )
    area = height * thickness
    stiffness = np.array(
        [
            71.7e9 * area,
            shear * area * 5 / 6,
            shear * area * 5 / 6,
            shear * torsion,
            71.7e9 * height * thickness**3 / 12,
            71.7e9 * thickness * height**3 / 12,
        ]
    )
    exact, _ = Rod(length, stiffness).tip(force)
    source = "data: O. A. Bauchau et al., Multibody Syst. Dyn. 37 (2016) 29-48; exact rod, by shooting"
    return (
        Comparison("deflection along the thickness, m", tip[2], exact[2], source, 2e-3),
        Comparison("deflection along the height, m", tip[1], exact[1], source, 3e-3),
    )


CASES = (
    ValidationCase("45 degree bend", bend_of_45_degrees),
    ValidationCase("roll-up of a cantilever", roll_up, quick=False),
    ValidationCase("elastica", elastica),
    ValidationCase("buckled column", buckled_column, quick=False),
    ValidationCase("follower force on a cantilever", follower_force, quick=False),
    ValidationCase("Princeton beam", princeton),
)
