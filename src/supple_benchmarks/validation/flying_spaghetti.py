"""The flying spaghetti: a free flexible beam, with force and torque at one end, as an intrinsic line.

J. C. Simo and L. Vu-Quoc, "On the dynamics of flexible beams under large overall motions - the plane case",
part II, J. Appl. Mech. 53 (1986) 855-863. Reference: an equal beam of quadratic planar elements in an
inertial frame, with a constant mass matrix, integrated by DOP853 with a relative tolerance of 1e-7.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from supple.fem import BeamSection, Isotropic
from supple.integrate import FixedStep, GeneralizedAlpha, Run
from supple.machine import DeadForce, FollowerTorque, System
from supple.methods.intrinsic import FREE, IntrinsicBody, intrinsic_body
from supple.simulation import simulate
from supple_benchmarks.lines import condensed_beam
from supple_benchmarks.planar_beam import BeamElements, PlanarBeam
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase, compared

__all__ = ["CASES"]

Array = NDArray[np.float64]

BEAM = PlanarBeam(
    length=10.0,
    axial_stiffness=1e4,
    shear_stiffness=1e4,
    bending_stiffness=500.0,
    mass_per_length=1.0,
    rotary_inertia_per_length=10.0,
)
ROOT, TIP = np.array([6.0, 0.0, 0.0]), np.array([0.0, 8.0, 0.0])
FORCE, TORQUE = 8.0, -80.0
"""Loads at the root for t < LOADED: force along x, of constant direction, and torque about z."""
LOADED, DURATION = 2.5, 5.0
N_SEGMENTS, STEP = 16, 0.0125


def _reference() -> Array:
    """Positions (2, 2, 2) at t = LOADED and t = DURATION, of root and tip, in x and y."""
    elements = BeamElements(BEAM, 6)
    N = elements.n_nodes
    unit = np.eye(3 * N).reshape(3 * N, N, 3)
    inverse = np.linalg.inv(elements.momentum(unit).reshape(3 * N, 3 * N))
    start = elements.straight(np.arctan2(*(TIP - ROOT)[1::-1])) + np.append(ROOT[:2], 0.0)
    state, found = np.concatenate([start.ravel(), np.zeros(3 * N)]), []
    for span, share in (((0.0, LOADED), 1.0), ((LOADED, DURATION), 0.0)):
        load = np.zeros(3 * N)
        load[[0, 2]] = share * FORCE, share * TORQUE

        def rates(_: float, state: Array, load: Array = load) -> Array:
            force = load - elements.internal_force(state[: 3 * N].reshape(N, 3))
            return np.concatenate([state[3 * N :], inverse @ force])

        state = solve_ivp(rates, span, state, method="DOP853", rtol=1e-7, atol=1e-8).y[:, -1]
        found.append(state[: 3 * N].reshape(N, 3)[[0, -1], :2])
    return np.array(found)


def _line() -> IntrinsicBody:
    """The beam as an intrinsic line with all modes; a section of area 0.01 has the stiffness of `BEAM`."""
    points = ROOT + np.linspace(0, 1, N_SEGMENTS + 1)[:, None] * (TIP - ROOT)
    section = BeamSection(Isotropic(1e6, 0.0, 100.0), 1e-2, 5e-4, 5e-4, 1e-3, 2.0, 2.0, orientation=(0, 0, 1))
    radius = math.sqrt(BEAM.rotary_inertia_per_length / BEAM.mass_per_length)
    return intrinsic_body(condensed_beam("beam", points, section, radius), FREE)


def _while_loaded(load: Sequence[float]) -> Callable[[jax.Array], jax.Array]:
    return lambda time: jnp.where(time < LOADED, 1.0, 0.0) * jnp.array(load)


def _flown() -> Sequence[Comparison]:
    body = _line()
    push = DeadForce(at="beam.root", force=_while_loaded((FORCE, 0.0, 0.0)))
    turn = FollowerTorque(first="beam.root", torque=_while_loaded((0.0, 0.0, TORQUE)))
    run = Run(DURATION, LOADED, step=FixedStep(STEP), method=GeneralizedAlpha(1.0))
    solution = simulate(System([body], loads=[push, turn]), run)
    places = body.places(solution.bodies["beam"])[1]
    weights = np.full(N_SEGMENTS + 1, 1 / N_SEGMENTS)
    weights[[0, -1]] /= 2
    centre = float(weights @ places[-1, :, 0])
    # Constant acceleration F / m under the load, then constant velocity.
    gained = FORCE * LOADED / BEAM.length * (LOADED / 2 + DURATION - LOADED)
    relative = f"error over L = {BEAM.length:g} m"
    source = "Simo and Vu-Quoc (1986), beam elements in the plane by DOP853"
    found = [
        Comparison(
            f"centre of mass along x after 5 s, m; {relative}",
            centre,
            3 + gained,
            "impulse of the load",
            2e-3,
            BEAM.length,
        )
    ]
    for time, own, exact in zip((LOADED, DURATION), places[1:, [0, -1], :2], _reference(), strict=True):
        for end, place, expected in zip(("root", "tip"), own, exact, strict=True):
            names = [f"{end} along {axis} after {time:g} s, m; {relative}" for axis in "xy"]
            found += compared(names, place, expected, source, 1e-2, BEAM.length)
    return found


CASES: tuple[ValidationCase, ...] = (ValidationCase("flying spaghetti", _flown, quick=False),)
