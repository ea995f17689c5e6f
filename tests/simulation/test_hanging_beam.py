"""A heavy beam that hangs between two pins: `equilibrium` against the differential equations of the beam."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from supple.body import FullBody, MeanAxisFrame, RigidInterface, flexible_body
from supple.fem import BeamSection, Isotropic, shell_model
from supple.machine import GROUND, At, Placed, Revolute, System
from supple.mesh import CellType, Mesh
from supple.simulation import equilibrium

LENGTH, AREA, MODULUS, DENSITY, GRAVITY = 1.0, 2e-4, 1e8, 2700.0, 9.81
SECOND = 1e-9
N = 20


def sag_of_the_beam():
    """`x' = (1 + e) cos a`, `z' = (1 + e) sin a`, `E I a'' = H sin a - V cos a`, `E A e = H cos a + V sin a`.

    `V' = w`; pinned at both ends, its length apart: nearly a catenary, its thrust H from the stretch.
    """
    weight, stretching, bending = DENSITY * AREA * GRAVITY, MODULUS * AREA, MODULUS * SECOND

    def rates(s, y, thrust):
        _, _, angle, bend = y
        lifted = weight * (s - LENGTH / 2)
        stretch = 1 + (thrust * np.cos(angle) + lifted * np.sin(angle)) / stretching
        turning = stretch * (thrust * np.sin(angle) - lifted * np.cos(angle)) / bending
        return np.stack([stretch * np.cos(angle), stretch * np.sin(angle), bend, turning])

    def ends(left, right, _):
        return np.array([left[0], left[1], left[3], right[0] - LENGTH, right[3]])

    s = np.linspace(0, LENGTH, 201)
    thrust = np.cbrt(stretching * weight**2 * LENGTH**2 / 24)
    slope = weight * (s - LENGTH / 2) / thrust
    guess = np.stack([s, weight * s * (s - LENGTH) / 2 / thrust, slope, 0 * s])
    found = solve_bvp(rates, ends, s, guess, p=[thrust], tol=1e-8, max_nodes=20000)
    assert found.success
    return -found.sol(LENGTH / 2)[1], found.p[0]


def test_a_heavy_beam_hangs_between_two_pins_as_its_equations_say():
    """Within 3e-4 of the sag and of the thrust on twenty elements."""
    section = BeamSection(
        Isotropic(MODULUS, 0.0, DENSITY),
        AREA,
        SECOND,
        SECOND,
        2 * SECOND,
        5 / 6,
        5 / 6,
        orientation=(0, 1, 0),
    )
    mesh = Mesh(
        np.linspace(0, LENGTH, N + 1)[:, None] * np.eye(3)[0],
        {CellType.LINE2: np.column_stack([np.arange(N), np.arange(1, N + 1)])},
        node_sets={"left": [0], "right": [N]},
    )
    sides = [RigidInterface(side, side) for side in ("left", "right")]
    body = FullBody(flexible_body("beam", shell_model(mesh, section), sides), MeanAxisFrame())
    pins = [
        Revolute(name=side, first=GROUND, second=At("beam", side), axis=(0, 1, 0))
        for side in ("left", "right")
    ]
    found = equilibrium(System((Placed(body),), pins, gravity=(0, 0, -GRAVITY)))
    sag, thrust = sag_of_the_beam()
    (placed,) = found.system.bodies
    lowest = placed.positions([N // 2])[0]
    assert lowest == pytest.approx([LENGTH / 2, 0.0, -sag], abs=3e-4 * sag)
    pulled = np.linalg.norm(found.joint_forces["right"][:3])
    assert pulled == pytest.approx(np.hypot(thrust, DENSITY * AREA * GRAVITY * LENGTH / 2), rel=3e-4)
