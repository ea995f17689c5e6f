"""Beams from tables of 6 x 6 section matrices, as lines and as elements: coupling, large bending."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from supple.body import RigidInterface, flexible_body, section_beams
from supple.importers import SectionTable, twisted_axes
from supple.machine import DeadForce
from supple.methods.intrinsic import CLAMPED, intrinsic_body, section_line
from supple_benchmarks.lines import tip_at_rest
from supple_benchmarks.references.section_beam import SectionAt, bent_tip, clamped_frequencies
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase, compared

__all__ = ["CASES"]

LENGTH = 10.0
BOX = np.array(
    [
        [88.56e3, 0, 0, 0, 0, 0],
        [0, 38.78e3, 0, 0, 0, 0],
        [0, 0, 1368.17e3, 0, 0, 0],
        [0, 0, 0, 59.12e3, -0.37e3, 17.61e3],
        [0, 0, 0, -0.37e3, 141.47e3, -0.351e3],
        [0, 0, 0, 17.61e3, -0.351e3, 16.96e3],
    ]
)
"""Stiffness of a composite box with bending-twist coupling, lb and lb in^2, z along the beam: [Wang2017]."""
BOX_MASS = np.diag([8.538e-2] * 3 + [0.40972e-2, 1.0336e-2, 1.4433e-2])
"""Mass matrix of the composite box per length, lb s^2 / in^2 and lb s^2."""
EQUATIONS = "equations of the beam with the same sections, integrated along it"


def _box_beam() -> SectionTable:
    """The composite box along z, 10 inches long."""
    one = np.ones((2, 1, 1))
    return SectionTable(np.array([[0, 0, 0], [0, 0, LENGTH]]), one * np.eye(3), one * BOX, one * BOX_MASS)


def _coupled() -> Sequence[Comparison]:
    flexibility = np.linalg.inv(BOX)
    line = section_line("beam", _box_beam(), 3)
    load = np.append(np.zeros(6), [0, 1.0, 0, 0, 0, 0])
    twist = np.linalg.solve(line.stiffness[6:, 6:], load)[-1]
    # The moment of a force along y is -(L - s) about x.
    by_hand = float(-flexibility[5, 3] * LENGTH**2 / 2)
    return [Comparison("twist of the tip by a force across it, rad/lb", twist, by_hand, "closed form", 1e-9)]


def _vibrating() -> Sequence[Comparison]:
    exact = clamped_frequencies(
        lambda _s: SectionAt(np.eye(3), BOX, BOX_MASS), np.linspace(0, LENGTH, 21), np.linspace(10, 200, 39)
    )[:3]
    line = intrinsic_body(section_line("beam", _box_beam(), 31), CLAMPED).modes.frequencies
    chain = flexible_body("beam", section_beams(_box_beam(), 30), [RigidInterface("root", "root")])
    beams = np.sqrt(chain.lowest_modes(3, chain.interface("root").motion.toarray()).values)
    names = (
        f"frequency {k} of {what}, rad/s" for what in ("a line of 31 stations", "30 beams") for k in (1, 2, 3)
    )
    return compared(names, [line[:3], beams], [exact, exact], EQUATIONS, 5e-3)


def _tip(table: SectionTable, n_stations: int, push: tuple[float, float, float]) -> NDArray[np.float64]:
    """Displacement (3,) of the tip of a clamped intrinsic line under a dead force at the tip."""
    body = intrinsic_body(section_line("beam", table, n_stations), CLAMPED)
    return tip_at_rest(body, DeadForce(at="beam.tip", force=push)) - table.positions[-1]


def _bent_far() -> Sequence[Comparison]:
    push = (0.0, 150.0, 0.0)
    source = f"{EQUATIONS}, exact; sections and load of [Wang2017]"
    return _beside(_tip(_box_beam(), 21, push), bent_tip(BOX, LENGTH, push)[:3], "150 lb, in", source, 2e-4)


def _twisted() -> Sequence[Comparison]:
    places = np.linspace(0, 10.0, 81)[:, None] * [0, 0, 1]
    axes = twisted_axes(np.tile([0, 0, 1.0], (81, 1)), np.linspace(0, np.pi / 2, 81))
    stiffness = np.diag([8.2604167e9, 8.2604167e9, 2.5e10, 0.520833e9, 0.130208333e9, 0.141872656e9])
    one = np.ones((81, 1, 1))
    table = SectionTable(places, axes, one * stiffness, one * np.diag([1, 1, 1, 0.5, 0.5, 1]))
    source = "BeamDyn, OpenFAST's regression test bd_static_twisted_with_k1 (r-test, 2022)"
    exact = np.array([1.71810805, -3.59245231, -1.14114462])
    return _beside(_tip(table, 41, (0.0, -4e6, 0.0)), exact, "4 MN, twisted by 90 degrees, m", source, 1e-3)


def _beside(
    found: NDArray[np.float64], exact: NDArray[np.float64], under: str, source: str, allowed: float
) -> Sequence[Comparison]:
    size = float(np.linalg.norm(exact))
    return compared(
        (f"tip along {axis} under {under}" for axis in "xyz"), found, exact, source, allowed, size
    )


CASES: tuple[ValidationCase, ...] = (
    ValidationCase("section table: bending-twist coupling of a box", _coupled),
    ValidationCase("section table: frequencies of the box", _vibrating),
    ValidationCase("section table: large bending of the box", _bent_far),
    ValidationCase("section table: large bending of a twisted beam", _twisted),
)
