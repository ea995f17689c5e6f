"""A beam condensed by NumPy and SciPy to boundary and modal coordinates, and imported as matrices."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import linalg

from supple.body import NodalFixedFrame, RigidInterface, check_model, superelement
from supple.fem import BeamSection, Isotropic, shell_model
from supple.linearization import linearize, machine_modes
from supple.machine import GROUND, At, Fixed, System
from supple.reduction import CompleteBasis, NoDerivatives, NoLoads, reduce
from supple_benchmarks.lines import BENDING_ROOTS, line_mesh, points_along_x
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase, compared

__all__ = ["CASES"]

STEEL = Isotropic(2.1e11, 0.0, 7800.0)
LENGTH, WIDTH, HEIGHT = 1.0, 0.01, 0.03
RAYLEIGH = "Euler-Bernoulli beam: Lord Rayleigh, Theory of Sound, chapter VIII"


def condensed_cantilever() -> Sequence[Comparison]:
    """Two nodes and fourteen modal coordinates: mass, centre of mass, and frequencies of the clamped beam."""
    nodes = points_along_x(LENGTH, 32)
    I1, I2 = WIDTH**3 * HEIGHT / 12, HEIGHT**3 * WIDTH / 12
    section = BeamSection(STEEL, WIDTH * HEIGHT, I2, I1, I1 + I2, orientation=(0.0, 1.0, 0.0))
    model = shell_model(line_mesh(nodes), section)
    K, M = model.stiffness.toarray(), model.mass.toarray()
    b = np.concatenate([np.arange(6), np.arange(len(K) - 6, len(K))])
    i = np.setdiff1d(np.arange(len(K)), b)
    static = -np.linalg.solve(K[np.ix_(i, i)], K[np.ix_(i, b)])
    _, modes = linalg.eigh(K[np.ix_(i, i)], M[np.ix_(i, i)], subset_by_index=(0, 13))
    T = np.zeros((len(K), 12 + modes.shape[1]))
    T[b, np.arange(12)], T[i, :12], T[i, 12:] = 1.0, static, modes
    grids, stiffness, mass = nodes[[0, -1]], T.T @ K @ T, T.T @ M @ T

    properties = check_model(grids, stiffness, mass, dofs_per_node=6, n_frequencies=0).mass
    ends = [RigidInterface("root", [0]), RigidInterface("tip", [1])]
    body = superelement("beam", grids, stiffness, mass, dofs_per_node=6, interfaces=ends)
    frame = NodalFixedFrame("root")
    small = reduce(body, frame, CompleteBasis(), derivatives=NoDerivatives(), loads=NoLoads)
    machine = System([small], [Fixed(name="wall", first=GROUND, second=At("beam", "root"))])
    found = machine_modes(linearize(machine), 5).frequencies
    area = WIDTH * HEIGHT
    exact = sorted(
        (root / LENGTH) ** 2 * np.sqrt(STEEL.youngs_modulus * second / (STEEL.density * area))
        for root in BENDING_ROOTS
        for second in (I1, I2)
    )[:5]
    return [
        Comparison("mass, kg", properties.mass, STEEL.density * area * LENGTH, "density times volume", 1e-9),
        Comparison(
            "centre of mass along the beam, m",
            float(properties.centre[0]),
            LENGTH / 2,
            "half the length",
            1e-9,
        ),
        *compared((f"bending {number}, rad/s" for number in range(1, 6)), found, exact, RAYLEIGH, 5e-3),
    ]


CASES: tuple[ValidationCase, ...] = (
    ValidationCase("superelement of another program: cantilever", condensed_cantilever),
)
