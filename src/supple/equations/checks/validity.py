"""Check, during every run, that the motion is within the limits of the kinematics.

Three limits are checked. A body without nonlinear terms has no geometric stiffness: at an angular velocity
near its lowest frequency its deflection is too large, and above this frequency the deflection diverges. The
deflection is also too large where condensed motion has no inertia, if the missing centrifugal stiffness is a
large part of the body's stiffness. Strains are wrong at rotations beyond the range for which they were
derived: about 0.3 rad where curvatures enter linearly, 0.1 rad where all displacements do. Rigid interfaces
strain the adjacent elements by the third order of their rotation, also those of solids. Averaging interfaces
on soft sections change deflections if the sections rotate relative to the frame.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_array

from supple.algebra.largest_vector import largest_vector
from supple.body import BodyForm, Frame, MeanAxisFrame, smaller_rotations
from supple.body.averaging_error import DEFLECTION_ERROR
from supple.equations.checks.strictness import Watch
from supple.integrate import FramedMotion, Solution, Validity
from supple.machine import At, ForceElement
from supple.machine.system import System

SOFTENED_LIMIT = 0.01
"""Estimated relative error of a deflection due to averaging interfaces, from which a warning is given."""

LINEAR_ROTATION_LIMIT = 0.1
"""rad, rotation theta. Linear strains lack the shortening by bending, theta^2 / 2. At this rotation it is
0.5 % of the length, a tenth of the deflection of such a body."""

TIED_ROTATION_LIMIT = 0.5
"""rad, rotation of a rigid interface of solids, whose nodes are tied to second order. The deflection of a
cantilever with a rigid tip is 0.3 % too small at 0.46 rad, 2.5 % at 0.64 and 6 % at 0.78."""

ROUND = 0.1
"""Largest difference of the spreads of a rotor's nodes along two directions across its axis of rotation,
relative to the whole spread."""

_STIFFER = {"modal": "Give it stiffening=CentrifugalStiffness() (spin_stiffness = true in a case file)"}
"""Remedy for missing geometric stiffness, by kind of body; for other kinds modal derivatives."""
_TURNS_LESS = {"modal": "Use explicit elements, or several modal parts tied to each other"}
"""Remedy for a rotation relative to the frame, by the body's kind; for other kinds, by its frame."""


class Peaks(NamedTuple):
    """Largest angular velocity (rad/s), relative rotation (rad) and interface error of a body, with times."""

    spin: float = 0.0
    spin_time: float = 0.0
    rotation: float = 0.0
    rotation_time: float = 0.0
    softened: float = 0.0
    """Largest relative error of a deflection due to averaging interfaces on soft sections, with its time"""
    softened_time: float = 0.0

    def merged(self, other: Peaks) -> Peaks:
        """The larger of both, each with its time."""
        spin = (self if self.spin >= other.spin else other)[:2]
        rotation = (self if self.rotation >= other.rotation else other)[2:4]
        softened = (self if self.softened >= other.softened else other)[4:]
        return Peaks(*spin, *rotation, *softened)


@dataclass(frozen=True, eq=False)
class _Limits:
    """Limits of one flexible body."""

    body: BodyForm
    spin: float
    flying_apart: float
    """Angular velocity at which the missing stiffness equals the elastic one"""
    axes: np.ndarray
    """(3,) weights of the angular velocity about each axis of the body"""
    rotation: float
    is_tied: bool
    """Whether only the rotations of rigid interfaces are limited, as in solids"""
    rotation_basis: np.ndarray | csc_array | None
    """(3 P, n) rotation vectors from coordinates, of these interfaces or of all points"""
    averaging: np.ndarray | None
    """(3 k, n) mean rotations of the k averaging interfaces from coordinates, or None"""
    softness: np.ndarray
    """(3 k,) softness c / C of these interfaces about each axis"""

    @property
    def frame(self) -> Frame | None:
        """Frame of the body; None for a form without a chosen frame."""
        return getattr(self.body, "frame", None)


@dataclass(frozen=True, eq=False)
class ValidityMonitor(Watch[Peaks]):
    """The limits of a system's bodies, and the check of a run against them."""

    limits: tuple[_Limits, ...]

    def peaks(self, chunk: Solution) -> dict[str, Peaks]:
        """Peaks of every flexible body in a part of a run."""
        return {
            own.body.name: _peaks(own, chunk.times, motion).merged(_softened(own, chunk.times, motion))
            for own in self.limits
            for motion in (chunk.motion(own.body.name, FramedMotion),)
        }

    def updated(self, so_far: Mapping[str, Peaks], leg: Solution) -> dict[str, Peaks]:
        """The peaks including those of a leg."""
        return {name: so_far.get(name, Peaks()).merged(peak) for name, peak in self.peaks(leg).items()}

    def excesses(self, found: Mapping[str, Peaks]) -> list[str]:
        """A message for every exceeded limit: body, value, limit, consequence and remedy."""
        messages = []
        for own in self.limits:
            peak = found.get(own.body.name, Peaks())
            if peak.spin > own.spin:
                messages.append(_too_fast(own, peak))
            if peak.rotation > own.rotation:
                messages.append(_too_wide(own, peak))
            if peak.softened > SOFTENED_LIMIT:
                messages.append(_out_of_shape(own, peak))
        return messages


def _too_fast(own: _Limits, peak: Peaks) -> str:
    spins = f"rotates at {peak.spin:.4g} rad per unit of time (t = {peak.spin_time:.4g})"
    if own.body.is_linear:
        return (
            f"body '{own.body.name}' is linear and {spins}, {peak.spin / own.flying_apart:.2f} times its "
            f"lowest frequency {own.flying_apart:.4g}: without geometric stiffness its deflections "
            "are too large or diverge. "
            + _STIFFER.get(
                own.body.kind, "Reduce it with modal derivatives, from a model with quadratic strains"
            )
        )
    missing = 100 * (peak.spin / own.flying_apart) ** 2
    return (
        f"body '{own.body.name}' {spins}, and its basis lacks the motion by which centrifugal force stiffens "
        f"it: up to {missing:.3g} % of the stiffness are missing, and deflections are too large or diverge. "
        "Wrap the basis in "
        "SteadyLoads(...) (steady = true in a case file), or add derivatives"
        + ("" if isinstance(own.frame, MeanAxisFrame) else ", or use MeanAxisFrame() with Rubin(...)")
    )


def _too_wide(own: _Limits, peak: Peaks) -> str:
    turns = f"rotates by {peak.rotation:.3f} rad relative to its frame (t = {peak.rotation_time:.4g})"
    limit = f"its kinematics hold to about {own.rotation:.2f} rad"
    remedy = _TURNS_LESS.get(own.body.kind) or smaller_rotations(own.frame)
    if own.body.is_linear and own.body.kind not in _TURNS_LESS:
        return (
            f"body '{own.body.name}' is linear and {turns}; {limit}, as they lack the shortening by bending, "
            f"{peak.rotation**2 / 2:.2g} of its length. Reduce it from a model with quadratic strains, or "
            f"{remedy}"
        )
    of = "a rigid interface of " if own.is_tied else ""
    remedy = f"take an averaging interface, {remedy}" if own.is_tied else remedy
    return f"{of}body '{own.body.name}' {turns}; {limit}. {remedy[:1].upper()}{remedy[1:]}"


def _out_of_shape(own: _Limits, peak: Peaks) -> str:
    return (
        f"body '{own.body.name}': a soft section has rotated with its averaging interface relative to the "
        f"frame (t = {peak.softened_time:.4g}), and deflections are off by some {100 * peak.softened:.2g} %. "
        "Use a rigid interface, fix the frame to this one, or close the section by a bulkhead"
    )


def _peaks(limits: _Limits, times: np.ndarray, motion: FramedMotion) -> Peaks:
    spins = np.linalg.norm(motion.angular_velocity * limits.axes, axis=1)
    fastest = int(np.argmax(spins))
    peaks = Peaks(spin=float(spins[fastest]), spin_time=float(times[fastest]))
    if limits.rotation_basis is None:
        return peaks
    rotation, widest = largest_vector(limits.rotation_basis, motion.coordinates)
    return peaks._replace(rotation=rotation, rotation_time=float(times[widest]))


def _softened(limits: _Limits, times: np.ndarray, motion: FramedMotion) -> Peaks:
    """Estimated error due to averaging interfaces: the largest 6 phi^2 c / C of the interfaces and times."""
    if limits.averaging is None:
        return Peaks()
    turns = (motion.coordinates @ limits.averaging.T).reshape(len(times), -1, 3)
    shares = (turns**2 * limits.softness.reshape(-1, 3)).sum(axis=2).max(axis=1)
    worst = int(np.argmax(shares))
    return Peaks(softened=float(DEFLECTION_ERROR * shares[worst]), softened_time=float(times[worst]))


def _averaging(body: BodyForm, carrying: set[At]) -> tuple[np.ndarray | None, np.ndarray]:
    """Mean rotations (3 k, n) of averaging interfaces under moments, and c / C of their sections, (3 k,)."""
    held = [i for i in body.interfaces if At(body.name, i.name) in carrying]
    found = [(i.motion[3:], body.section_softness(i.name)) for i in held]
    found = [(motion, softness) for motion, softness in found if softness.any()]
    if not found:
        return None, np.zeros(0)
    dense = [motion if isinstance(motion, np.ndarray) else motion.toarray() for motion, _ in found]
    return np.vstack(dense), np.concatenate([softness for _, softness in found])


def watch(system: System, validity: Validity) -> ValidityMonitor:
    """Prepare the limits of every flexible body of a system."""
    # Finite elements without a frame can rotate without limit.
    bodies = [placed.body for placed in system.bodies]
    deforming = [body for body in bodies if body.n_coordinates and body.has_frame]
    return ValidityMonitor(
        validity, tuple(_limits(body, validity, _carrying_moments(system)) for body in deforming)
    )


def _carrying_moments(system: System) -> set[At]:
    """Interfaces where a joint fixes a rotation, or where a force element other than a line spring acts."""
    holding = [joint for joint in system.joints if not all(row.startswith("position") for row in joint.rows)]
    loads = [load for load in system.acting if isinstance(load, ForceElement) and not load.acts_along_line]
    return {end for element in (*holding, *loads) for end in (element.first, element.second)}


def _limits(body: BodyForm, validity: Validity, carrying: set[At]) -> _Limits:
    axes, flying_apart = np.ones(3), body.lowest_frequency() if body.is_linear else np.inf
    missing = body.missing_centrifugal_stiffness
    if missing.any():
        axes, flying_apart = np.sqrt(missing / missing.max()), float(missing.max() ** -0.5)
    limit, rows = body.rotation_limit, body.rotation_rows
    tied = [each.motion[3:] for each in body.interfaces if each.cubic_turn < 0]
    is_tied = bool(np.isinf(limit) and tied and not body.is_linear)
    if is_tied:
        limit = TIED_ROTATION_LIMIT
        rows = np.vstack([each if isinstance(each, np.ndarray) else each.toarray() for each in tied])
    averaging, softness = _averaging(body, carrying)
    return _Limits(
        body,
        spin=validity.spin_ratio * flying_apart,
        flying_apart=flying_apart,
        axes=axes,
        rotation=min(limit, LINEAR_ROTATION_LIMIT) if body.is_linear else limit,
        is_tied=is_tied,
        rotation_basis=rows,
        averaging=averaging,
        softness=softness,
    )


def is_rotor(body: BodyForm, motion: FramedMotion, instant: int) -> bool:
    """Whether a body is a rotor at an output time: nodes are spread evenly about the axis of its rotation.

    In a rotor, such as a shaft or a disc, centrifugal tension does not stiffen bending across this axis.
    False for a body that does not rotate.
    """
    turn = motion.angular_velocity[instant]
    rate = float(np.linalg.norm(turn))
    if not rate:
        return False
    velocity = motion.rotation[instant].T @ motion.velocity[instant]
    arms = body.nodes - np.cross(turn, velocity) / rate**2
    across = arms - np.outer(arms @ turn, turn) / rate**2
    whole = float(np.sum((arms - arms.mean(axis=0)) ** 2)) + float(np.sum(across**2))
    spread = np.linalg.eigvalsh(across.T @ across)  # ascending; zero along the axis
    centre = len(arms) * float(np.sum(across.mean(axis=0) ** 2))
    return bool(spread[2] - spread[1] <= ROUND * whole and centre <= ROUND * whole)
