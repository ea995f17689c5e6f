"""Models of decks (input files of other programs) with masses, springs and ties, against closed forms."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from supple.body import FlexibleBody, deck_body, deck_frequencies
from supple.importers.deck import (
    BeamProperty,
    BeamValues,
    Deck,
    DeckElements,
    IsotropicMaterial,
    NodalMatrix,
    RigidTie,
    ScalarTerms,
    SolidProperty,
)
from supple.mesh import CellType, block
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase

__all__ = ["CASES"]

STEEL = IsotropicMaterial(2.1e11, 0.0, 7850.0)
SIDE, LENGTH = 0.01, 1.0
SQUARE = BeamValues(SIDE**2, SIDE**4 / 12, SIDE**4 / 12, 0.141 * SIDE**4, 0.0, 0.0, 7850.0 * SIDE**2)
SHARE = 0.7
"""Ratio of the tip mass to the beam's mass"""


def _beam(
    n: int, masses: Sequence[NodalMatrix], held: Sequence[ScalarTerms], springs: Sequence[ScalarTerms] = ()
) -> Deck:
    """A deck with a beam along x of n elements, with masses, supports (`held`) and springs."""
    nodes = np.column_stack([np.linspace(0, LENGTH, n + 1), np.zeros((n + 1, 2))])
    numbers = np.arange(n)
    cells = DeckElements(
        "CBAR",
        CellType.LINE2,
        np.column_stack([numbers, numbers + 1]),
        numbers + 1,
        numbers + 1,
        "beam",
        np.tile([0.0, 0.0, 1.0], (n, 1)),
    )
    properties = {"beam": BeamProperty(STEEL, SQUARE)}
    return Deck(
        Path("beam"),
        np.arange(n + 1),
        nodes,
        (cells,),
        properties,
        masses=tuple(masses),
        held=tuple(held),
        springs=tuple(springs),
    )


def _supports(freedoms: Sequence[int]) -> ScalarTerms:
    rows = np.arange(len(freedoms))
    return ScalarTerms(rows, np.array(freedoms), np.ones(len(rows)), rows)


def _tip_mass() -> tuple[Comparison, ...]:
    n, m = 40, SQUARE.mass_per_length * LENGTH
    tip = NodalMatrix(6 * n + np.arange(3), SHARE * m * np.eye(3))
    found = deck_frequencies(_beam(n, [tip], [_supports(range(6))]), 1, held=True)[0]
    root = brentq(
        lambda x: 1 + np.cos(x) * np.cosh(x) + SHARE * x * (np.cos(x) * np.sinh(x) - np.sin(x) * np.cosh(x)),
        0.5,
        1.8,
    )
    assert isinstance(root, float)
    exact = root**2 * np.sqrt(STEEL.youngs_modulus * SQUARE.I1 / (m * LENGTH**3)) / (2 * np.pi)
    source = "Euler and Bernoulli's beam with a tip mass"
    return (Comparison("lowest frequency, Hz", float(found), float(exact), source, 5e-4),)


def _spring_at_the_tip() -> tuple[Comparison, ...]:
    """A cantilever with a tip mass m and a transverse spring k from the tip to the ground.

    omega^2 = (3 E I / L^3 + k) / (m + 33/140 of the beam's mass)
    """
    n, stiffness, mass = 20, 500.0, 10.0
    tip = NodalMatrix(6 * n + np.arange(3), mass * np.eye(3))
    spring = ScalarTerms(
        np.zeros(1, int), np.array([6 * n + 2]), np.ones(1), np.ones(1, int), np.array([stiffness])
    )
    given = _beam(n, [tip], [_supports([*range(6), 6 * n + 1])], springs=(spring,))
    found = deck_frequencies(given, 1, held=True)[0]
    m = SQUARE.mass_per_length * LENGTH
    bending = 3 * STEEL.youngs_modulus * SQUARE.I1 / LENGTH**3
    exact = np.sqrt((bending + stiffness) / (mass + 33 / 140 * m)) / (2 * np.pi)
    return (
        Comparison("lowest frequency, Hz", float(found), float(exact), "Rayleigh's beam on a spring", 1e-3),
    )


def _turned(body: FlexibleBody, nodes: NDArray[np.float64], tied: NDArray[np.int64], phi: float) -> float:
    """Strain energy, J, after a rotation of all untied nodes by phi about x, and of the tie by tan(phi).

    With tan(phi) as rotation coordinate of the tie, this energy is least (`second_order_tie`).

    tied : numbers of the tied nodes; the last is the reference node of the tie
    """
    turn = Rotation.from_rotvec([phi, 0.0, 0.0]).as_matrix() - np.eye(3)
    free = np.setdiff1d(np.arange(len(nodes)), tied)
    place = turn @ nodes[tied[-1]]
    q = np.concatenate([(nodes[free] @ turn.T).ravel(), place, [np.tan(phi), 0.0, 0.0]])
    return float(body.force.energies(q[:, None])[0])


def _tie_that_turns() -> tuple[Comparison, ...]:
    mesh = block(1.0, 0.1, 0.1, 4, 1, 1, CellType.HEXA8)
    nodes = np.vstack([mesh.nodes, [0.5, 0.3, 0.0]])
    cells, numbers = mesh.cells[CellType.HEXA8], np.arange(4)
    solids = DeckElements("CHEXA", CellType.HEXA8, cells, numbers, numbers, "solid")
    tied = np.flatnonzero(np.abs(nodes[:, 0] - 0.5) < 1e-9)
    given = Deck(
        Path("bar"),
        np.arange(len(nodes)),
        nodes,
        (solids,),
        {"solid": SolidProperty(STEEL)},
        rigid=(RigidTie("tie", int(tied[-1]), tied[:-1], 1),),
    )
    body = deck_body("bar", given, [])
    energies = [_turned(body, nodes, tied, phi) for phi in (0.05, 0.1)]
    order = float(np.log2(energies[1] / energies[0]))
    source = "strains to second order have no energy in phi, phi^2 and phi^3"
    return (Comparison("order of the energy in the rotation", order, 8.0, source, 0.05),)


CASES = (
    ValidationCase("a beam of a deck with a mass at its tip", _tip_mass),
    ValidationCase("a beam of a deck on a spring", _spring_at_the_tip),
    ValidationCase("a rigid tie within a rotated solid", _tie_that_turns),
)
