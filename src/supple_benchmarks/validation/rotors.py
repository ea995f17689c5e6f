"""Rotors with rotary inertia at their nodes: whirl frequencies against closed forms and other codes.

In axes that rotate with the rotor at the rate W, a forward whirl of frequency w in space has the frequency
|w - W|, and a backward whirl w + W.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq
from scipy.sparse import block_diag, csc_array

from supple.algebra.cross import cross_matrix
from supple.body import (
    FlexibleBody,
    Frame,
    FullBody,
    MeanAxisFrame,
    NodalFixedFrame,
    RigidInterface,
    superelement,
)
from supple.errors import ModelError
from supple.fem import BeamSection, Isotropic, shell_model
from supple.linearization import SparseMachine, linearize, machine_modes
from supple.machine import GROUND, At, JournalBearing, Placed, Revolute, Spin, System
from supple.mesh import CellType, Mesh
from supple.reduction import CompleteBasis, NoDerivatives, reduce
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase, compared, matched

__all__ = [
    "CASES",
    "Disc",
    "Rotor",
    "RoundShaft",
    "disc_on_massless_shaft",
    "rotor_body",
    "turning_frequencies",
    "whirl_of_timoshenko_shaft",
]

Array = NDArray[np.float64]
AXIS = (1.0, 0.0, 0.0)


@dataclass(frozen=True)
class Disc:
    """A rigid disc on a shaft: position on it, m; mass, kg; polar and transverse inertia, kg m^2."""

    place: float
    mass: float
    polar: float
    transverse: float


@dataclass(frozen=True)
class RoundShaft:
    """A piece of a round shaft: start and end along x, and radius, m."""

    start: float
    end: float
    radius: float


@dataclass(frozen=True)
class Rotor:
    """Successive pieces of a shaft of one material, from x = 0, with one shear factor, and discs.

    Raises ModelError for a disc that is not on a piece of the shaft.
    """

    material: Isotropic
    pieces: tuple[RoundShaft, ...]
    shear_factor: float
    discs: tuple[Disc, ...] = ()

    def __post_init__(self) -> None:
        for each in self.discs:
            if not any(piece.start <= each.place <= piece.end for piece in self.pieces):
                raise ModelError(
                    f"a disc at {each.place:g} m is not on the shaft: give a place between the start "
                    "and the end of a piece"
                )


def disc(place: float, width: float, inner: float, outer: float, density: float) -> Disc:
    """A disc with a width and an inner and outer radius, m, and a density, kg/m^3."""
    mass = density * np.pi * (outer**2 - inner**2) * width
    polar = mass / 2 * (inner**2 + outer**2)
    return Disc(place, mass, polar, polar / 2 + mass * width**2 / 12)


def rotor_body(rotor: Rotor, longest: float, interfaces: dict[str, float]) -> FlexibleBody:
    """A body of beam elements shorter than 1.5 times `longest`, m, with the discs' inertia at their nodes.

    interfaces : their positions along the shaft, m, by name
    """
    marks = sorted(
        {0.0, *(p.end for p in rotor.pieces), *(d.place for d in rotor.discs), *interfaces.values()}
    )
    x = np.concatenate(
        [np.linspace(a, b, max(1, round((b - a) / longest)) + 1)[:-1] for a, b in pairwise(marks)]
        + [[marks[-1]]]
    )
    middle = (x[:-1] + x[1:]) / 2
    sets, sections = {}, {}
    for number, piece in enumerate(rotor.pieces):
        area, second, shear = np.pi * piece.radius**2, np.pi * piece.radius**4 / 4, rotor.shear_factor
        name = f"piece {number}"
        sets[name] = {CellType.LINE2: np.flatnonzero((piece.start < middle) & (middle < piece.end))}
        sections[name] = BeamSection(
            rotor.material, area, second, second, 2 * second, shear, shear, orientation=(0, 1, 0)
        )
    lines = np.column_stack([np.arange(len(x) - 1), np.arange(1, len(x))])
    model = shell_model(Mesh(x[:, None] * np.eye(3)[0], {CellType.LINE2: lines}, cell_sets=sets), sections)
    mass = model.mass
    for each in rotor.discs:
        node = int(np.argmin(abs(x - each.place)))
        blocks = [np.zeros((6, 6))] * len(x)
        blocks[node] = np.diag([each.mass] * 3 + [each.polar, each.transverse, each.transverse])
        mass = mass + csc_array(block_diag(blocks))
    at = {name: int(np.argmin(abs(x - place))) for name, place in interfaces.items()}
    return superelement(
        "rotor",
        model.mesh.nodes,
        model.stiffness,
        mass,
        dofs_per_node=6,
        interfaces=[RigidInterface(name, [node]) for name, node in at.items()],
    )


def disc_on_massless_shaft(
    stiffness: float = 5000.0, polar: float = 2.0, transverse: float = 1.1
) -> FlexibleBody:
    """A disc that tilts on springs relative to the interface "hub", at the same point.

    stiffness : of the tilt, N m/rad;  polar, transverse : inertia of the disc, kg m^2
    """
    springs = np.diag([1e8, 1e8, 1e8, 1e8, stiffness, stiffness])
    mass = np.diag([10.0, 10.0, 10.0, 3.0, 2.0, 2.0, 10.0, 10.0, 10.0, polar, transverse, transverse])
    return superelement(
        "rotor",
        np.zeros((2, 3)),
        np.kron([[1.0, -1.0], [-1.0, 1.0]], springs),
        mass,
        dofs_per_node=6,
        interfaces=[RigidInterface("hub", [0])],
    )


def turning_frequencies(
    body: FlexibleBody, frame: Frame, rate: float, held: dict[str, float | None], *, full: bool = False
) -> Array:
    """Frequencies of a rotor in axes that rotate with it at `rate`, rad/s.

    held : interfaces with a hinge along the axis (None), or with a bearing of the given transverse stiffness,
        N/m
    full : the 24 slowest modes of a FullBody; False: all modes of a reduced body with all coordinates
    """
    form = (
        FullBody(body, frame) if full else reduce(body, frame, CompleteBasis(), derivatives=NoDerivatives())
    )
    hinges = [
        Revolute(name=name, first=GROUND, second=At("rotor", name), axis=AXIS)
        for name, stiffness in held.items()
        if stiffness is None
    ]
    bearings = [
        JournalBearing(first=GROUND, second=At("rotor", name), axis=AXIS, stiffness=stiffness * np.eye(2))
        for name, stiffness in held.items()
        if stiffness is not None
    ]
    machine = linearize(System((Placed(form),), hinges, bearings), spin=Spin(rate, np.array(AXIS)))
    return machine_modes(machine, 24 if full else None).frequencies


def whirls(found: Array, expected: ArrayLike, rate: float) -> list[float]:
    """Whirl frequencies in space, positive forward: one per expected frequency, by `matched`.

    found : frequencies in axes that rotate at `rate`, without sign;  expected : whirl frequencies in space
    The sign of each w - rate is that of the expected frequency.
    """
    seen = np.asarray(expected, dtype=np.float64) - rate
    return (rate + np.copysign(matched(found, abs(seen)), seen)).tolist()


def in_fixed_axes(body: FlexibleBody, frame: Frame, rate: float) -> tuple[Array, Array, Array]:
    """M, C and K (n, n) of a free, axisymmetric rotor in axes fixed in space; it rotates at `rate`, rad/s.

    The displacements p in rotating axes are the displacements s in fixed axes, in other components:
    p = R(t)^T s,  p' = R^T (s' - W X s),  p'' = R^T (s'' - 2 W X s' + W^2 X^2 s), with the rate W and the
    cross matrix X of the axis.

    Raises TypeError if the linearised machine is sparse.
    """
    reduced = reduce(body, frame, CompleteBasis(), derivatives=NoDerivatives())
    machine = linearize(System((Placed(reduced),)), spin=Spin(rate, np.array(AXIS)))
    if isinstance(machine, SparseMachine):
        raise TypeError("a reduced rotor has dense matrices: give a rotor with all its coordinates")
    shapes, *_ = np.linalg.lstsq(body.expansion.toarray(), reduced.nodal_basis, rcond=None)
    inverse = np.linalg.inv(np.hstack([body.rigid_modes, shapes]) @ machine.basis)
    mass, damping, stiffness = (
        inverse.T @ part @ inverse for part in (machine.mass, machine.damping, machine.stiffness)
    )
    turn = rate * np.kron(np.eye(body.n // 3), cross_matrix(np.array(AXIS)))
    return mass, damping - 2 * mass @ turn, stiffness - damping @ turn + mass @ turn @ turn


def whirl_of_timoshenko_shaft(rotor: Rotor, rate: float, near: ArrayLike) -> Array:
    """Whirl frequencies in space, rad/s, positive forward, of a clamped-free shaft rotating at `rate`, rad/s.

        u' = phi + Q / kGA,   phi' = M / EI,   M' = - Q - rho I (w^2 - 2 W w) phi,   Q' = - rho A w^2 u

    w is the whirl frequency, W the rate, k the shear factor. u and phi are complex in the plane across the
    shaft, in uniform whirl exp(i w t). M and Q jump at discs. The frequencies are roots of the determinant of
    the exact transfer matrix.

    near : pairs of bounds, rad/s, each containing one root
    Source: H. D. Nelson, A finite rotating shaft element using Timoshenko beam theory, J. Mech. Des. 102
    (1980) 793-803, eqs. (1)-(10).
    """
    E, G, density = rotor.material.youngs_modulus, rotor.material.shear_modulus, rotor.material.density

    def end_forces(w: float) -> float:
        state = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        for piece in rotor.pieces:
            area, second = np.pi * piece.radius**2, np.pi * piece.radius**4 / 4
            stops = sorted(
                (d for d in rotor.discs if piece.start < d.place <= piece.end), key=lambda disc: disc.place
            )
            at = piece.start
            for stop in [*stops, None]:
                end = piece.end if stop is None else stop.place
                system = np.array(
                    [
                        [0.0, 1.0, 0.0, 1 / (rotor.shear_factor * G * area)],
                        [0.0, 0.0, 1 / (E * second), 0.0],
                        [0.0, -density * second * (w**2 - 2 * rate * w), 0.0, -1.0],
                        [-density * area * w**2, 0.0, 0.0, 0.0],
                    ]
                )
                scale = np.array([1.0, 1.0, E * second, E * second])
                state = scale[:, None] * (
                    scipy.linalg.expm(system * (scale / scale[:, None]) * (end - at))
                    @ (state / scale[:, None])
                )
                at = end
                if stop is not None:
                    state[2] -= (stop.transverse * w**2 - stop.polar * rate * w) * state[1]
                    state[3] -= stop.mass * w**2 * state[0]
        return float(np.linalg.det(state[2:]))

    bounds = np.reshape(near, (-1, 2))
    return np.array([brentq(end_forces, low, high, xtol=1e-9) for low, high in bounds])


def _disc_on_a_massless_shaft() -> list[Comparison]:
    """Whirl of a disc that tilts: J_t w^2 - J_p W w - k = 0."""
    rate = 60.0
    expected = np.roots([1.1, -2.0 * rate, -5000.0]).real
    source = "closed form: roots of J_t w^2 - J_p W w - k = 0"
    return _in_both_frames(disc_on_massless_shaft(), rate, expected, source, 1e-5)


def _in_both_frames(
    body: FlexibleBody, rate: float, expected: Array, source: str, allowed: float
) -> list[Comparison]:
    """Whirl of a rotor on a hinge at its hub, with its frame at the hub and in mean axes."""
    comparisons = []
    for name, frame in (("nodal-fixed", NodalFixedFrame("hub")), ("mean axes", MeanAxisFrame())):
        found = whirls(turning_frequencies(body, frame, rate, {"hub": None}), expected, rate)
        names = [f"{_whirl(each)}, {name}, rad/s" for each in expected]
        comparisons += compared(names, found, expected, source, allowed)
    return comparisons


def _whirl(w: float) -> str:
    return "forward whirl" if w > 0 else "backward whirl"


STEEL = Isotropic(2.1e11, 0.3, 7850.0)
OVERHUNG = Rotor(STEEL, (RoundShaft(0.0, 0.5, 0.02), RoundShaft(0.5, 0.53, 0.15)), 0.9)
"""A clamped shaft, diameter 40 mm; the disc at its end is a piece of shaft, diameter 300 mm, length 30 mm."""


def _disc_of_beam_elements() -> list[Comparison]:
    """Whirl of the clamped shaft with a disc of beam elements, at 600 rad/s."""
    rate, bounds = 600.0, [(-400.0, -50.0), (50.0, 900.0)]
    expected = whirl_of_timoshenko_shaft(OVERHUNG, rate, bounds)
    body = rotor_body(OVERHUNG, 0.05, {"hub": 0.0})
    source = "exact transfer matrix of Timoshenko's rotating shaft (Nelson 1980)"
    return _in_both_frames(body, rate, expected, source, 1e-3)


FRISWELL = (85.39, 87.80, 251.78, 294.71)
"""Whirl frequencies of `friswell_rotor`, rad/s, at 4000 rpm; backward, forward, backward, forward."""


def friswell_rotor() -> Rotor:
    """Two discs on a shaft of 50 mm diameter: example 5.9.1 of Friswell et al."""
    density = 7810.0
    material = Isotropic(211e9, 211 / (2 * 81.2) - 1, density)
    discs = (disc(0.5, 0.07, 0.025, 0.14, density), disc(1.0, 0.07, 0.025, 0.175, density))
    return Rotor(material, (RoundShaft(0.0, 1.5, 0.025),), 0.9, discs)


def _two_discs_on_bearings() -> list[Comparison]:
    """Whirl of `friswell_rotor` at 4000 rpm on bearings of 1 MN/m, with a mean-axis frame."""
    rate = 4000 * np.pi / 30
    signed = [sign * w for sign, w in zip((-1, 1, -1, 1), FRISWELL, strict=True)]
    body = rotor_body(friswell_rotor(), 0.1, {"left": 0.0, "right": 1.5})
    found = turning_frequencies(body, MeanAxisFrame(), rate, {"left": 1e6, "right": 1e6})
    source = (
        "M. I. Friswell et al., Dynamics of Rotating Machines (2010), example 5.9.1; numbers of ROSS "
        "(petrobras/ross, test_examples.py), six elements"
    )
    names = [f"{_whirl(each)} {number // 2 + 1}, rad/s" for number, each in enumerate(signed)]
    return compared(names, whirls(found, signed, rate), signed, source, 3e-3)


LALANNE = (55.408, 67.209, 157.90, 193.71, 249.90, 407.62, 446.62)
"""Whirl frequencies of `lalanne_rotor`, Hz, at 25 000 rpm."""


def lalanne_rotor() -> Rotor:
    """Three discs on a shaft of 100 mm diameter: rotor of Lalanne and Ferraris."""
    density = 7800.0
    places = ((0.2, 0.05, 0.12), (0.5, 0.05, 0.20), (1.0, 0.06, 0.20))
    discs = tuple(disc(place, width, 0.05, outer, density) for place, width, outer in places)
    return Rotor(Isotropic(2e11, 0.3, density), (RoundShaft(0.0, 1.3, 0.05),), 0.9, discs)


def lalanne_frequencies(frame: Frame) -> Array:
    """Whirl frequencies of `lalanne_rotor` at 25 000 rpm on its anisotropic bearings, Hz, ascending."""
    body = rotor_body(lalanne_rotor(), 0.05, {"left": 0.0, "right": 1.3})
    mass, damping, stiffness = in_fixed_axes(body, frame, 25_000 * np.pi / 30)
    for motion in (interface.motion.toarray() for interface in body.interfaces):
        across = motion[1:3]
        stiffness = stiffness + across.T @ np.diag([5e7, 7e7]) @ across
        damping = damping + across.T @ np.diag([5e2, 7e2]) @ across
    # Bending only: axial motion and rotation about the axis, which are free, are removed.
    bending = np.flatnonzero(np.arange(body.n) % 3)
    mass, damping, stiffness = (part[np.ix_(bending, bending)] for part in (mass, damping, stiffness))
    inverse = np.linalg.inv(mass)
    zero, one = np.zeros_like(mass), np.eye(len(mass))
    poles = np.linalg.eigvals(np.block([[zero, one], [-inverse @ stiffness, -inverse @ damping]]))
    return np.sort(np.asarray(poles.imag[poles.imag > 0], dtype=np.float64)) / (2 * np.pi)


def _three_discs_on_unlike_bearings() -> list[Comparison]:
    """The first seven whirl frequencies of `lalanne_rotor` at 25 000 rpm, with a mean-axis frame."""
    found = lalanne_frequencies(MeanAxisFrame())
    source = "M. Lalanne, G. Ferraris, Rotordynamics Prediction in Engineering (1998), rotor of three discs"
    return compared((f"frequency {number}, Hz" for number in range(1, 8)), found, LALANNE, source, 3e-3)


CASES: tuple[ValidationCase, ...] = (
    ValidationCase("disc on a massless shaft", _disc_on_a_massless_shaft),
    ValidationCase("overhung disc of beam elements", _disc_of_beam_elements),
    ValidationCase("rotor of two discs on bearings", _two_discs_on_bearings),
    ValidationCase("rotor of three discs on anisotropic bearings", _three_discs_on_unlike_bearings),
)
