"""The cases of the trust benchmark."""

from __future__ import annotations

from collections.abc import Callable

import jax.numpy as jnp
import numpy as np

from supple.body import FlexibleBody, RigidBody
from supple.machine import (
    GROUND,
    At,
    Ball,
    BaseAcceleration,
    Placed,
    Prismatic,
    Ramp,
    Revolute,
    SpringDamper,
    System,
)
from supple.machine.system import Load
from supple.reduction import NoDerivatives, NormalModes
from supple_benchmarks.trust.bodies import (
    DAMPED,
    MODALLY,
    Damping,
    beam,
    framed,
    laminate,
    plate,
    rod,
    shell_strip,
    solid_bar,
    tube,
)
from supple_benchmarks.trust.loads import (
    Over,
    alone,
    blow,
    chirp,
    driven,
    every,
    following,
    moving_force,
    pushed,
    spin,
    struck,
)
from supple_benchmarks.trust.trust_case import TrustCase

__all__ = ["CASES", "QUICK"]

Made = Callable[[], FlexibleBody]
SIDE = np.array([0.0, 1.0, 0.0])
FIRST = 10.0
"""rad/s, lowest frequency of the clamped strip; the second is 64, those of the beam are 20 and 128."""


def _hinged(mean_axes: bool = False, damping: Damping | None = None) -> System:
    """A strip on a hinge, released from the horizontal."""
    body = framed(shell_strip(), mean_axes=mean_axes, damping=damping)
    hinge = Revolute(name="hinge", first=GROUND, second=At("body", "root"), axis=(0, 1, 0))
    return System((Placed(body),), (hinge,), gravity=np.array([0.0, 0.0, -9.81]))


def _caught() -> System:
    """A strip on a hinge, its tip suspended by a spring."""
    hinged = _hinged()
    spring = SpringDamper(
        first=GROUND,
        second=At("body", "tip"),
        anchor=(1.0, 0.0, 0.6),
        stiffness=30.0,
        rest_length=0.5,
    )
    return System(hinged.bodies, hinged.joints, loads=(spring,), gravity=hinged.gravity)


def _slider_crank() -> System:
    """A flexible crank driven up to 6 rad/s, a flexible rod, and its end on a rail."""
    crank, link = framed(rod(0.3, "crank")), framed(rod(0.8, "rod", 6))
    joints = (
        driven(spin(6.0, 0.5), "crank"),
        Revolute(name="pin", first=At("crank", "tip"), second=At("rod", "root"), axis=(0, 1, 0)),
        Ball(name="end", first=At("rod", "tip"), second=At("slider", "eye")),
        Prismatic(name="rail", first=GROUND, second=At("slider", "eye"), axis=(1, 0, 0)),
    )
    slider = RigidBody("slider", 0.5, np.zeros(3), 1e-3 * np.eye(3), {"eye": np.zeros(3)})
    bodies = (
        Placed(crank),
        Placed(link, position=np.array([0.3, 0.0, 0.0])),
        Placed(slider, position=np.array([1.1, 0.0, 0.0])),
    )
    return System(bodies, joints)


def _two_links(free: bool = False) -> System:
    """An arm of two strips: the shoulder is driven, the elbow is free."""
    upper, lower = framed(shell_strip(0.5, 4, "upper")), framed(shell_strip(0.4, 4, "lower"))
    shoulder = (
        Revolute(name="shoulder", first=GROUND, second=At("upper", "root"), axis=(0, 1, 0))
        if free
        else driven(lambda t: 1.2 * jnp.sin(2.0 * t) ** 2, "upper")
    )
    elbow = Revolute(name="elbow", first=At("upper", "tip"), second=At("lower", "root"), axis=(0, 1, 0))
    gravity = np.array([0.0, 0.0, -9.81 if free else 0.0])
    return System(
        (Placed(upper), Placed(lower, position=np.array([0.5, 0.0, 0.0]))), (shoulder, elbow), gravity=gravity
    )


def _four_bar() -> System:
    """A closed loop: a crank driven to 4 rad/s, a coupler and a rocker."""
    crank, coupler = framed(rod(0.3, "crank", 4)), framed(rod(0.9, "coupler", 6))
    rocker = framed(rod(0.6, "rocker", 5))
    # Crank along x; coupler from (0.3, 0) to B, rocker from (1, 0) to B, in the x-z plane.
    B, D = _meeting(np.array([0.3, 0.0]), 0.9, np.array([1.0, 0.0]), 0.6), np.array([1.0, 0.0])
    at_coupler = -np.arctan2(B[1], B[0] - 0.3)
    at_rocker = -np.arctan2(B[1] - D[1], B[0] - D[0])
    joints = (
        driven(spin(4.0, 0.5), "crank"),
        Revolute(name="pin A", first=At("crank", "tip"), second=At("coupler", "root"), axis=(0, 1, 0)),
        Revolute(name="pin B", first=At("coupler", "tip"), second=At("rocker", "tip"), axis=(0, 1, 0)),
        Revolute(name="pivot", first=GROUND, second=At("rocker", "root"), axis=(0, 1, 0)),
    )
    return System(
        (
            Placed(crank),
            Placed(coupler, position=np.array([0.3, 0.0, 0.0]), rotation=np.array([0.0, at_coupler, 0.0])),
            Placed(rocker, position=np.array([1.0, 0.0, 0.0]), rotation=np.array([0.0, at_rocker, 0.0])),
        ),
        joints,
    )


def _meeting(first: np.ndarray, one: float, second: np.ndarray, other: float) -> np.ndarray:
    """The upper point at given distances from two points of a plane."""
    base = second - first
    d = float(np.linalg.norm(base))
    along = (one**2 - other**2 + d**2) / (2 * d)
    across = np.sqrt(one**2 - along**2)
    return first + along * base / d + across * np.array([-base[1], base[0]]) / d


def _tumbling(angular_velocity: list[float], mean_axes: bool = True) -> System:
    """A flying, rotating beam, pushed at its end: pure rotation would excite only axial vibrations."""
    placed = Placed(framed(beam(), mean_axes=mean_axes), angular_velocity=np.array(angular_velocity))
    return System((placed,), loads=(pushed(blow(2.0, 0.05, 0.1)),))


def _of(
    body: Made, *loads: Load, damping: Damping | None = None, mean_axes: bool = False
) -> Callable[[], System]:
    """Function that creates the machine of one clamped body."""
    return lambda: alone(framed(body(), damping=damping, mean_axes=mean_axes), *loads)


def _turned(body: Made, angle: Over, *, mean_axes: bool = False) -> Callable[[], System]:
    return lambda: alone(framed(body(), mean_axes=mean_axes), joint=driven(angle))


def _shaken(body: Made, over: Over) -> Callable[[], System]:
    return lambda: alone(
        framed(body()), BaseAcceleration(acceleration=lambda t: over(t) * np.array([0.0, 0.3, 1.0]))
    )


_SLOW_AND_BLOW = (
    struck(29, lambda t: 40.0 * t * (1.0 - t)),
    struck(14, blow(150.0, 0.41, 0.036)),
)
"""The vibration after the blow is simulated for a twentieth of a second: with a longer vibration, a full run
with an eighth of the step would have too many steps."""

CASES: tuple[TrustCase, ...] = (
    TrustCase("strip spun up", _turned(shell_strip, spin(6.0, 1.0)), 1.2, 60, 1e-3),
    TrustCase("strip spun up, mean axes", _turned(shell_strip, spin(6.0, 1.0), mean_axes=True), 1.2, 60),
    TrustCase("beam spun up fast", _turned(beam, spin(12.0, 0.8)), 1.0, 80, 1e-3),
    TrustCase("beam spun up, tightly", _turned(beam, spin(8.0, 0.8)), 1.0, 100, 1e-5),
    TrustCase("plate struck at a corner", _of(plate, struck(29, blow(60.0, 0.1, 0.02))), 0.4, 100, 1e-2),
    TrustCase(
        "plate struck, damped", _of(plate, struck(29, blow(60.0, 0.1, 0.02)), damping=DAMPED), 0.4, 100
    ),
    TrustCase(
        "plate struck, modal damping",
        _of(plate, struck(29, blow(60.0, 0.1, 0.02)), damping=MODALLY),
        0.4,
        100,
        1e-2,
    ),
    TrustCase("plate, slow load and a blow", _of(plate, *_SLOW_AND_BLOW), 0.5, 50, 1e-3),
    TrustCase(
        "plate, blow between outputs", _of(plate, struck(17, blow(400.0, 0.1015, 0.002))), 0.15, 30, 1e-2
    ),
    TrustCase("plate, load in step", _of(plate, struck(13, every(60.0, 0.02, 0.008))), 0.4, 100, 1e-2),
    TrustCase("laminate, step", _of(laminate, pushed(lambda t: 0.5 + 0.0 * t)), 0.6, 100, 1e-2),
    TrustCase("laminate, ramp", _of(laminate, pushed(Ramp(1.0, 0.5))), 0.8, 80, 1e-3),
    TrustCase("strip, first mode", _of(shell_strip, pushed(lambda t: 0.05 * jnp.sin(FIRST * t))), 1.5, 75),
    TrustCase("strip, between modes", _of(shell_strip, pushed(lambda t: 0.5 * jnp.sin(30.0 * t))), 1.0, 100),
    TrustCase("strip, second mode", _of(shell_strip, pushed(lambda t: 0.2 * jnp.sin(64.0 * t))), 0.6, 120),
    TrustCase(
        "beam, first mode damped",
        _of(beam, pushed(lambda t: 0.5 * jnp.sin(20.0 * t)), damping=DAMPED),
        1.0,
        100,
    ),
    TrustCase("beam, chirp", _of(beam, pushed(chirp(1.0, 5.0, 200.0, 0.8))), 0.8, 200, 1e-2),
    TrustCase(
        "strip, moving load",
        _of(shell_strip, moving_force([1, 4, 7, 10, 13, 16, 19], np.linspace(0, 1, 7), 0.5, 1.0)),
        1.0,
        100,
    ),
    TrustCase("beam, follower", _of(beam, following(Ramp(10.0, 0.4))), 0.6, 60, 1e-3),
    TrustCase("tube, follower", _of(tube, following(Ramp(30.0, 0.2))), 0.3, 60, 1e-2),
    TrustCase("tube, dead load sideways", _of(tube, pushed(Ramp(30.0, 0.2), SIDE), mean_axes=True), 0.3, 60),
    TrustCase("solid, step", _of(solid_bar, pushed(lambda t: 5.0 + 0.0 * t)), 0.3, 100, 1e-2),
    TrustCase("solid, slow and damped", _of(solid_bar, pushed(Ramp(30.0, 0.3)), damping=DAMPED), 0.4, 60),
    TrustCase("beam in large bending", _of(beam, pushed(Ramp(40.0, 0.5))), 0.7, 70, 1e-3),
    TrustCase(
        "strip in large bending, mean axes",
        _of(shell_strip, pushed(Ramp(8.0, 1.0)), mean_axes=True),
        1.2,
        60,
    ),
    TrustCase("strip, base shaken", _shaken(shell_strip, lambda t: 3.0 * jnp.sin(15.0 * t)), 1.0, 100),
    TrustCase("beam, base struck", _shaken(beam, blow(60.0, 0.1, 0.03)), 0.5, 100, 1e-2),
    TrustCase("beam tumbling freely", lambda: _tumbling([0.3, 5.0, 0.2]), 0.5, 50, 1e-3, NormalModes(5)),
    TrustCase("beam spinning freely", lambda: _tumbling([0.0, 0.0, 8.0], False), 0.5, 50, 1e-2),
    TrustCase("strip dropped on its hinge", _hinged, 0.6, 60, 1e-2),
    TrustCase("strip dropped, damped, mean axes", lambda: _hinged(True, DAMPED), 0.6, 60),
    TrustCase("strip caught by a spring", _caught, 0.6, 60, 1e-2),
    TrustCase("arm of two links", _two_links, 1.0, 50, 1e-3),
    TrustCase("two links released", lambda: _two_links(True), 0.5, 50, 1e-2),
    TrustCase("slider-crank", _slider_crank, 0.8, 80, 1e-3),
    TrustCase("four-bar", _four_bar, 0.8, 80, 1e-3),
    TrustCase(
        "plate without its modes",
        _of(plate, struck(29, lambda t: 5.0 * jnp.sin(60.0 * t))),
        0.4,
        80,
        1e-2,
        NormalModes(1),
        NoDerivatives(),
    ),
)
"""Cases with all kinds of loads, joints, elements, frames and accuracies."""

_NAMES = ("strip spun up", "tube, follower")
QUICK = tuple(case for case in CASES if case.name in _NAMES)
"""Cases of the quick form."""
