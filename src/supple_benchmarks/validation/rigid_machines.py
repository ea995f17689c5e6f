"""Mechanisms of rigid bodies, against closed forms and reference solutions of benchmark libraries."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipk

from supple.body import RigidBody
from supple.errors import RedundantConstraintWarning
from supple.integrate import FixedStep, FloatingMotion, Kinematic, Run, Solution
from supple.machine import (
    GROUND,
    At,
    ConstantRate,
    Cylindrical,
    FollowerTorque,
    Placed,
    PrescribedRotation,
    Prismatic,
    Revolute,
    SpringDamper,
    System,
    Universal,
)
from supple.quantities import JointMotionSensor
from supple.simulation import simulate
from supple_benchmarks.validation.validation_case import (
    Comparison,
    ValidationCase,
    compared,
    largest_difference,
)

__all__ = ["CASES"]

Array = NDArray[np.float64]
Z = (0.0, 0.0, 1.0)
LIBRARY = "M. Gonzalez et al., Multibody Syst. Dyn. 16 (2006) 179-190, problem"


def _plane_body(
    name: str, mass: float, inertia: float, centre: ArrayLike, points: Mapping[str, ArrayLike]
) -> RigidBody:
    """A body in the x-y plane, `inertia` about z; its other moments of inertia have no effect."""
    three = {key: np.array([*np.asarray(place, dtype=float), 0.0]) for key, place in points.items()}
    tensor = inertia * np.diag([0.6, 0.6, 1.0])
    return RigidBody(name, mass, np.array([*np.asarray(centre, dtype=float), 0.0]), tensor, three)


def _at(body: RigidBody, place: ArrayLike, angle: float) -> Placed:
    return Placed(
        body, position=np.array([*np.asarray(place, dtype=float), 0.0]), rotation=np.array([0, 0, angle])
    )


def _hinge(first: At, second: At, name: str) -> Revolute:
    return Revolute(name=name, first=first, second=second, axis=Z)


def _simulated(system: System, run: Run) -> Solution:
    """Result of `simulate`, without its warning that redundant joint equations are left out."""
    with warnings.catch_warnings(action="ignore", category=RedundantConstraintWarning):
        return simulate(system, run)


def _direction(angle: float) -> Array:
    return np.array([np.cos(angle), np.sin(angle)])


def pendulum() -> Sequence[Comparison]:
    """A physical pendulum released at 120 degrees: sin(angle / 2) = k sn(K - w t).

    k = sin(60 degrees);  K : complete elliptic integral of modulus k;  w : frequency of small vibrations
    """
    mass, arm, inertia, g, swing = 2.0, 0.8, 0.15, 9.81, 2 * np.pi / 3
    rate = np.sqrt(mass * g * arm / (inertia + mass * arm**2))
    k = np.sin(swing / 2)
    period = 4 * ellipk(k**2) / rate
    bob = RigidBody("bob", mass, np.array([0, 0, -arm]), inertia * np.eye(3), {"hinge": np.zeros(3)})
    hinge = Revolute(name="hinge", first=GROUND, second=At("bob", "hinge"), axis=(1, 0, 0))
    system = System([Placed(bob, rotation=np.array([swing, 0, 0]))], [hinge], gravity=np.array([0, 0, -g]))
    run = Run(period, period / 60, step=FixedStep(period / 3000))
    solution = simulate(system, run)
    rotation = solution.motion("bob", FloatingMotion).rotation
    angle = np.arctan2(rotation[:, 2, 1], rotation[:, 1, 1])
    exact = 2 * np.arcsin(k * ellipj(ellipk(k**2) - rate * solution.times, k**2)[0])
    carried = float(np.linalg.norm(solution.multipliers["hinge"][15, :3]))
    centripetal = 2 * (1 - np.cos(swing)) * mass * arm**2 / (inertia + mass * arm**2)
    source = "Jacobi's elliptic function sn: M. Abramowitz, I. A. Stegun, Handbook (1964), chapter 16"
    return (
        largest_difference("angle over a period, rad", angle, exact, source, 1e-5),
        Comparison(
            "force of the hinge at the lowest point, N",
            carried,
            mass * g * (1 + centripetal),
            "energy and centripetal acceleration",
            1e-5,
        ),
    )


def double_pendulum() -> Sequence[Comparison]:
    """Two equal uniform rods released from the horizontal: angles after 1.5 s, before chaotic motion.

    4/3 p'' + 1/2 cos(p - q) q'' + 1/2 sin(p - q) q'^2 + 3/2 g/l sin p = 0
    1/3 q'' + 1/2 cos(p - q) p'' - 1/2 sin(p - q) p'^2 + 1/2 g/l sin q = 0

    p, q : angles of the upper and of the lower rod from the vertical
    """
    length, g, duration = 1.0, 9.81, 1.5

    def rates(_: float, y: Array) -> Array:
        p, q, dp, dq = y
        c, s = np.cos(p - q) / 2, np.sin(p - q) / 2
        forces = [-s * dq**2 - 1.5 * g / length * np.sin(p), s * dp**2 - 0.5 * g / length * np.sin(q)]
        return np.array([dp, dq, *np.linalg.solve([[4 / 3, c], [c, 1 / 3]], forces)])

    exact = solve_ivp(rates, (0, duration), [np.pi / 2, np.pi / 2, 0, 0], "DOP853", rtol=1e-11, atol=1e-12).y[
        :2, -1
    ]
    ends = {"a": (0.0, 0.0), "b": (length, 0.0)}
    upper, lower = (
        _plane_body(name, 1.0, length**2 / 12, (length / 2, 0.0), ends) for name in ("upper", "lower")
    )
    joints = (
        _hinge(GROUND, At("upper", "a"), "shoulder"),
        _hinge(At("upper", "b"), At("lower", "a"), "elbow"),
    )
    system = System(
        [_at(upper, (0, 0), 0.0), _at(lower, (length, 0), 0.0)], joints, gravity=np.array([0, -g, 0])
    )
    solution = simulate(system, Run(duration, duration / 30, step=FixedStep(duration / 3000)))
    found = [
        np.arctan2(motion.rotation[-1, 0, 0], -motion.rotation[-1, 1, 0])
        for motion in (solution.motion(name, FloatingMotion) for name in ("upper", "lower"))
    ]
    source = "Lagrange's equations of two uniform rods, integrated by DOP853 to 1e-11"
    names = [f"angle of the {name} rod after 1.5 s, rad" for name in ("upper", "lower")]
    return compared(names, found, np.arctan2(np.sin(exact), np.cos(exact)), source, 1e-4, np.pi / 2)


def n_four_bar() -> Sequence[Comparison]:
    """The N-four-bar mechanism: a row of N = 2 windows of rods of 1 m and 1 kg, started upright at 1 m/s.

    At 90 degrees all rods are in line, and the mechanism could fold. Without folding it is one pendulum, with
    (N + 1)/3 + N kg m^2 about its hinge and a static moment of (N + 1)/2 + N kg m.
    """
    windows, g, duration = 2, 9.81, 3.0
    turned, lifted = (windows + 1) / 3 + windows, (windows + 1) / 2 + windows
    exact = solve_ivp(
        lambda _, y: [y[1], lifted / turned * g * np.sin(y[0])],
        (0, duration),
        [0.0, 1.0],
        method="DOP853",
        rtol=1e-11,
        atol=1e-12,
        dense_output=True,
    ).sol
    ends = {"a": (0.0, 0.0), "b": (1.0, 0.0)}
    bodies, joints = [], []
    for k in range(windows + 1):
        post = _plane_body(f"post {k}", 1.0, 1 / 12, (0.5, 0.0), ends)
        bodies.append(
            Placed(
                post,
                position=np.array([k, 0.0, 0.0]),
                rotation=np.array([0, 0, np.pi / 2]),
                angular_velocity=np.array([0, 0, -1.0]),
            )
        )
        joints.append(_hinge(GROUND, At(f"post {k}", "a"), f"foot {k}"))
    for k in range(windows):
        bar = _plane_body(f"bar {k}", 1.0, 1 / 12, (0.5, 0.0), ends)
        bodies.append(Placed(bar, position=np.array([k, 1.0, 0.0]), velocity=np.array([1.0, 0, 0])))
        joints.append(_hinge(At(f"post {k}", "b"), At(f"bar {k}", "a"), f"left {k}"))
        joints.append(_hinge(At(f"bar {k}", "b"), At(f"post {k + 1}", "b"), f"right {k}"))
    system = System(bodies, joints, gravity=np.array([0.0, -g, 0.0]))
    solution = _simulated(system, Run(duration, 0.05, step=FixedStep(0.0025)))
    tip = solution.motion("bar 0", FloatingMotion).position
    angle = exact(solution.times)[0]
    arm = np.column_stack([np.sin(angle), np.cos(angle)])
    source = f"{LIBRARY} A02; one pendulum, by DOP853 to 1e-11"
    return (largest_difference("position of B0 over 3 s, m", tip[:, :2], arm, source, 1e-3),)


def squeezer() -> Sequence[Comparison]:
    """Andrews' squeezing mechanism: seven bodies, driven from rest by a constant moment for 0.03 s.

    The origin of each body's frame is at a joint; names K1 .. K7 and lengths are those of the source.
    """
    A, B, C = np.array([-0.06934, -0.00227]), np.array([-0.03635, 0.03273]), (0.014, 0.072, 0.0)
    beta, Theta, gamma = -0.0617138900142764, 0.0, 0.455279819163070
    Phi, delta, Omega, epsilon = 0.222668390165886, 0.487364979543843, -0.222668390165886, 1.23054744454982
    data: dict[str, tuple[float, float, ArrayLike, dict[str, ArrayLike], ArrayLike, float]] = {
        "K1": (0.04325, 2.194e-6, (9.2e-4, 0), {"foot": (0, 0), "end": (7e-3, 0)}, (0, 0), beta),
        "K2": (
            0.00365,
            4.410e-7,
            (-0.0115, 0),
            {"end": (0, 0), "P": (-0.028, 0)},
            7e-3 * _direction(beta),
            beta + Theta,
        ),
        "K3": (
            0.02373,
            5.255e-6,
            (0.01043, -0.01874),
            {"foot": (0, 0), "P": (0, -0.035), "D": (0.02, -0.018)},
            B,
            gamma,
        ),
        "K4": (
            0.00706,
            5.667e-7,
            (0, -0.00579),
            {"end": (0, 0), "P": (0, -0.02)},
            A + 0.04 * _direction(delta),
            Phi + delta,
        ),
        "K5": (0.07050, 1.169e-5, (0.02308, 0.00916), {"foot": (0, 0), "end": (0.04, 0)}, A, delta),
        "K6": (
            0.00706,
            5.667e-7,
            (0.00579, 0),
            {"end": (0, 0), "P": (0.02, 0)},
            A + 0.04 * _direction(epsilon - np.pi / 2),
            Omega + epsilon,
        ),
        "K7": (0.05498, 1.912e-5, (-0.00449, -0.01228), {"foot": (0, 0), "end": (0, -0.04)}, A, epsilon),
    }
    bodies = [
        _at(_plane_body(name, mass, inertia, centre, points), place, angle)
        for name, (mass, inertia, centre, points, place, angle) in data.items()
    ]
    ends = [("ground", f"{name}.foot") for name in ("K1", "K3", "K5", "K7")]
    ends += [("K1.end", "K2.end"), ("K5.end", "K4.end"), ("K7.end", "K6.end")]
    ends += [("K2.P", f"{name}.P") for name in ("K3", "K4", "K6")]
    joints = [
        Revolute(name=f"{second} on {first}", first=first, second=second, axis=Z) for first, second in ends
    ]
    loads = (
        SpringDamper(first=GROUND, second=At("K3", "D"), anchor=C, stiffness=4530.0, rest_length=0.07785),
        FollowerTorque(first=At("K1", "foot"), torque=(0, 0, 0.033)),
    )
    system = System(bodies, joints, loads)
    solution = _simulated(system, Run(0.03, 3e-4, step=FixedStep(3e-5)))
    turned = JointMotionSensor("beta", "K1.foot on ground").values(system, solution)[-1, 0]
    angles = {
        name: float(np.arctan2(rotation[1, 0], rotation[0, 0]))
        for name in solution.bodies
        for rotation in (solution.motion(name, FloatingMotion).rotation[-1],)
    }
    source = "E. Hairer, G. Wanner, Solving ODEs II, section VII.7; Test Set for IVP Solvers: Andrews"
    return (
        Comparison("beta after 0.03 s, rad", beta + turned, 15.81077119629904, source, 2e-4),
        Comparison("gamma, rad", angles["K3"], 0.04082224013073101, source, 1e-3),
        Comparison("delta, rad", angles["K5"], 0.5244099658805304, source, 1e-4),
        Comparison("epsilon, rad", angles["K7"], 1.048080741042263, source, 1e-4),
    )


class _BricardMotion:
    """Motion of Bricard's mechanism, a cube of six rods of length 1, as a function of one angle `psi`.

    The exterior angles at the joints are p, q, p, q, p, q. The chain closes if (1 + cos p)(1 + cos q) = 1. In
    the plane (p, q) this is a closed curve about p = q = 0; `psi` is its polar angle. The rotation of a rod
    from its place in the cube, where p = q = 90 degrees, is a product of rotations about the joint axes.
    """

    corners = np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1]], dtype=float)
    edges = np.roll(corners, -1, axis=0) - corners
    axes = np.cross(np.roll(edges, 1, axis=0), edges)
    start = np.pi / 4

    @staticmethod
    def angles(psi: float) -> Array:
        """The angles p and q, (2,), rad."""
        c, s = np.cos(psi), np.sin(psi)
        size = brentq(
            lambda r: (1 + np.cos(r * c)) * (1 + np.cos(r * s)) - 1, 0.5, np.pi / max(abs(c), abs(s))
        )
        return float(size) * np.array([c, s])

    def poses(self, psi: float) -> tuple[Array, Array]:
        """Rotations (5, 3, 3) of the rods relative to the cube, and positions (5, 3) of their first ends."""
        turn, place, rotations, places = np.eye(3), np.zeros(3), [], []
        for k, angle in enumerate(np.resize(self.angles(psi), 5)):
            places.append(turn @ self.corners[k] + place)
            turn = turn @ Rotation.from_rotvec(self.axes[k] * (angle - np.pi / 2)).as_matrix()
            place = places[-1] - turn @ self.corners[k]
            rotations.append(turn)
        return np.array(rotations), np.array(places)

    def swung(self, tensors: Array, g: float, times: Array) -> Array:
        """Angle psi (t,) after a release at rest, rad: psi'' = -(m' psi'^2 / 2 + V') / m, for rods of 1 kg.

        m, V : generalised mass and potential energy as functions of psi;  m', V' : their derivatives
        tensors : (5, 3, 3) inertia of each rod about its centre, axes of the cube, kg m^2
        """
        psi = np.linspace(0, 2 * np.pi, 801)
        poses = [self.poses(each) for each in psi[:-1]]
        rotations, places = (np.array(part + part[:1]) for part in zip(*poses, strict=True))
        centres = places + np.einsum("tkij,kj->tki", rotations, self.edges[:5]) / 2
        moving = CubicSpline(psi, centres, bc_type="periodic")(psi, 1)
        turning = CubicSpline(psi, rotations, bc_type="periodic")(psi, 1)
        spin = np.einsum("tkji,tkjl->tkil", rotations, turning)
        spin = np.stack([spin[..., 2, 1], spin[..., 0, 2], spin[..., 1, 0]], axis=-1)
        inertia = (moving**2).sum(axis=(1, 2)) + np.einsum("tki,kij,tkj->t", spin, tensors, spin)
        inertia[-1] = inertia[0]
        m = CubicSpline(psi, inertia, bc_type="periodic")
        V = CubicSpline(psi, g * centres[..., 1].sum(axis=1), bc_type="periodic")

        def rates(_: float, y: Array) -> list[float]:
            return [y[1], -(m(y[0], 1) * y[1] ** 2 / 2 + V(y[0], 1)) / m(y[0])]

        span = (0.0, float(times[-1]))
        return solve_ivp(
            rates, span, [self.start, 0.0], t_eval=times, method="DOP853", rtol=1e-10, atol=1e-10
        ).y[0]


def bricard() -> Sequence[Comparison]:
    """Bricard's mechanism: a closed chain of six hinges with one degree of freedom, overconstrained."""
    cube, g, thickness = _BricardMotion(), 9.81, 0.1
    bodies, tensors = [], []
    for k in range(5):
        across = np.eye(3) - np.outer(cube.edges[k], cube.edges[k])
        tensors.append((1 + thickness**2) / 12 * across + thickness**2 / 6 * (np.eye(3) - across))
        ends = {"a": np.zeros(3), "b": cube.edges[k]}
        bodies.append(
            Placed(RigidBody(f"rod {k}", 1.0, cube.edges[k] / 2, tensors[k], ends), position=cube.corners[k])
        )
    ends = ["ground", *(f"rod {k}.{end}" for k in range(5) for end in "ab"), "ground"]
    joints = [
        Revolute(name=f"P{k}", first=ends[2 * k], second=ends[2 * k + 1], axis=tuple(cube.axes[k]))
        for k in range(6)
    ]
    system = System(bodies, joints, gravity=np.array([0.0, -g, 0.0]))
    solution = _simulated(system, Run(2.0, 0.02, step=FixedStep(4e-3)))
    found = solution.motion("rod 3", FloatingMotion).position
    psi = cube.swung(np.array(tensors), g, solution.times)
    exact = np.array([cube.poses(each)[1][3] for each in psi])
    source = f"{LIBRARY} A04; its closure in closed form and its energy, by DOP853 to 1e-10"
    return (largest_difference("position of P3 over 2 s, m", found, exact, source, 1e-3, scale=1.0),)


def slider_crank() -> Sequence[Comparison]:
    """A slider-crank driven at constant speed, kinematic analysis: slide and moment of the motor.

    x = r cos a + sqrt(l^2 - r^2 sin^2 a),     moment = d/da (kinetic energy)

    x : position of the slider;  a : angle of the crank;  r, l : lengths of crank and rod
    """
    r, length, speed = 0.2, 0.5, 30.0
    masses, slider_mass = {"crank": 1.2, "rod": 0.8}, 2.0

    def place(a: Array) -> Array:
        return r * np.cos(a) + np.sqrt(length**2 - (r * np.sin(a)) ** 2)

    def energy(a: NDArray[np.inexact]) -> NDArray[np.inexact]:
        lean = np.arcsin(r * np.sin(a) / length)
        lean_rate = r * np.cos(a) / (length * np.cos(lean)) * speed
        slide_rate = -r * np.sin(a) * speed - length * np.sin(lean) * lean_rate
        across_rate = r * np.cos(a) * speed - length / 2 * np.cos(lean) * lean_rate
        along_rate = -r * np.sin(a) * speed - length / 2 * np.sin(lean) * lean_rate
        crank = masses["crank"] * r**2 / 3 * speed**2
        rod = masses["rod"] * (along_rate**2 + across_rate**2 + length**2 / 12 * lean_rate**2)
        return (crank + rod + slider_mass * slide_rate**2) / 2

    crank = _plane_body(
        "crank", masses["crank"], masses["crank"] * r**2 / 12, (r / 2, 0), {"a": (0, 0), "b": (r, 0)}
    )
    rod = _plane_body(
        "rod", masses["rod"], masses["rod"] * length**2 / 12, (length / 2, 0), {"a": (0, 0), "b": (length, 0)}
    )
    slider = _plane_body("slider", slider_mass, 1e-3, (0, 0), {"pin": (0, 0)})
    joints = (
        PrescribedRotation(
            name="motor", first=GROUND, second=At("crank", "a"), axis=Z, angle=ConstantRate(speed)
        ),
        _hinge(At("crank", "b"), At("rod", "a"), "crank pin"),
        _hinge(At("rod", "b"), At("slider", "pin"), "piston pin"),
        Prismatic(name="cylinder", first=GROUND, second=At("slider", "pin"), axis=(1, 0, 0)),
    )
    spin = np.array([0.0, 0.0, speed])
    bodies = (
        Placed(_at(crank, (0, 0), 0.0).body, angular_velocity=spin),
        Placed(
            rod,
            position=np.array([r, 0, 0]),
            velocity=np.array([0, r * speed, 0]),
            angular_velocity=-r / length * spin,
        ),
        _at(slider, (r + length, 0), 0.0),
    )
    solution = _simulated(System(bodies, joints), Run(0.2, 0.002, method=Kinematic()))
    angle = speed * solution.times
    moment = -solution.multipliers["motor"][:, 5]
    exact = energy(angle + 1e-30j).imag / 1e-30
    slide = solution.motion("slider", FloatingMotion).position[:, 0]
    return (
        largest_difference("slide, m", slide, place(angle), "cosine rule", 1e-9),
        largest_difference("moment, N m", moment, exact, "virtual work", 1e-7),
    )


def universal_joint() -> Sequence[Comparison]:
    """Two shafts with a universal joint at 35 degrees: the driven speed varies twice per revolution.

    w_2 / w_1 = cos b / (1 - sin^2 b cos^2 a)

    a : angle of the driving shaft;  b : angle between the shafts
    """
    bend, speed = np.radians(35.0), 5.0
    towards = Rotation.from_euler("z", -bend).as_matrix()
    ends = {"left": np.array([-0.5, 0, 0]), "right": np.array([0.5, 0, 0])}
    driving, driven = (
        RigidBody(name, 1.0, np.zeros(3), 0.1 * np.eye(3), ends) for name in ("driving", "driven")
    )
    axis = towards[:, 0]
    bodies = (
        Placed(driving, position=-0.5 * axis, rotation=towards, angular_velocity=np.array([speed, 0, 0])),
        Placed(
            driven, position=np.array([0.5, 0, 0]), angular_velocity=np.array([speed / np.cos(bend), 0, 0])
        ),
    )
    joints = (
        PrescribedRotation(
            name="motor",
            first=GROUND,
            second=At("driving", "left"),
            axis=tuple(axis),
            angle=ConstantRate(speed),
        ),
        Universal(
            name="cross",
            first=At("driving", "right"),
            second=At("driven", "left"),
            first_axis=tuple(towards[:, 1]),
            second_axis=Z,
        ),
        Cylindrical(name="bearing", first=GROUND, second=At("driven", "right"), axis=(1, 0, 0)),
    )
    solution = _simulated(System(bodies, joints), Run(1.2, 0.02, method=Kinematic()))
    exact = speed * np.cos(bend) / (1 - (np.sin(bend) * np.cos(speed * solution.times)) ** 2)
    found = solution.motion("driven", FloatingMotion).angular_velocity[:, 0]
    return (largest_difference("driven speed, rad/s", found, exact, "spherical trigonometry", 1e-8),)


CASES = (
    ValidationCase("N-four-bar mechanism", n_four_bar),
    ValidationCase("Andrews' squeezing mechanism", squeezer),
    ValidationCase("Bricard's mechanism", bricard),
    ValidationCase("pendulum released at 120 degrees", pendulum, quick=False),
    ValidationCase("double pendulum", double_pendulum, quick=False),
    ValidationCase("slider-crank at constant speed", slider_crank, quick=False),
    ValidationCase("universal joint at 35 degrees", universal_joint, quick=False),
)
