"""Motion outside a basis: the full-order residual along a reduced run, and the motion that balances it.

At a time of the run the motion is expanded to all coordinates of the body, `q = V gamma + z(gamma)`, with its
rates and accelerations; z is the motion outside the columns V that condensed tensors add (otherwise zero).
The full-order equations are evaluated with the run's joint forces. Along V the residual r vanishes. The
remaining residual is balanced by Newton's method for the whole system (`missing_motion`), with corrections

    [ K_t(q) + M / p   D^T   G^T ] [ delta  ]     [ r ]
    [ D                          ] [ mu     ] = - [ 0 ]
    [ G                          ] [ lambda ]     [ 0 ]

K_t is the tangent of the deformed body and of the inertia forces at given accelerations: the centrifugal term
reduces the stiffness, and the tension that it causes increases the stiffness. M is the mass matrix, p the
ratio of displacement to acceleration. The frame rows D and the joint rows G are constraints, with multipliers
mu and lambda. The motion of the frame and of the other bodies, and the joint forces, are unknowns. One
clamped interface, closed loops and free flight are therefore treated in the same way. The inertia M / p
resists rigid motion, which a static equilibrium would leave free.
delta is the quasi-static missing motion. In displacements of the run, z is zero at the first interface; in
these equations z is relative to the body's frame. The rigid motion between the two is subtracted from delta.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from supple.algebra import read_only
from supple.body import BodyForm, MeanAxisFrame, frame_projector, in_space
from supple.body.full_body import FullBody
from supple.equations.compiled_machine import compiled_start
from supple.equations.configuration import Configuration
from supple.error.missing_motion import CONVERGED, FOLLOWED, MissingMotionSearch
from supple.errors import ModelError, RedundantConstraintWarning
from supple.integrate import FramedMotion, Progress, Solution
from supple.integrate.motion import FloatingMotion
from supple.machine.system import System
from supple.methods.floating.full.full_state import FullState
from supple.methods.floating.full.full_system import FullSystem
from supple.reduction import Condensation, ReducedBody, ReductionBasis
from supple.simulation.full_rest import fixes_rigid_motion

__all__ = ["ResidualCorrections", "active_constraints", "residual_corrections", "system_corrections"]

_SLOWNESS = 100.0
"""Ratio of the lowest natural frequency to 1 / sqrt(p): large enough that M / p changes every deflection by
less than one per cent, small enough that the tangent of a free body is regular."""
_SLOWNESS_IN_FLIGHT = (3.0, 30.0)
"""Bounds of this ratio if the joints leave rigid motion free; fast rotation reduces it to the smaller bound.
Only M / p resists the free rigid motion: with larger ratios, a residual within the run's tolerance rotated a
spinning beam by a radian."""
_FASTER_THAN_SPIN = 3.0
"""Ratio of 1 / sqrt(p) to the angular velocity, so that M / p exceeds the inertia forces of the rotation."""


@dataclass(frozen=True, eq=False)
class ResidualCorrections:
    """Missing motion of one body at k times.

    times : (k,)
    deformation : (n, k)    delta in the body's coordinates, relative to its frame
    origin : (k, 3)         displacement of the frame's origin, global
    rotation : (k, 3)       rotation of the frame, rad, body components
    rms : (k,)              root-mean-square displacement of the nodes: in space if the joints fix all rigid
                            motion; otherwise of the deformation alone, because no static equilibrium
                            determines the position. Infinite, with zero deformation, where no equilibrium
                            was found
    factorizations : int    number of factored tangents of the whole system
    """

    times: np.ndarray
    deformation: np.ndarray
    origin: np.ndarray
    rotation: np.ndarray
    rms: np.ndarray
    factorizations: int = 0

    def __post_init__(self) -> None:
        for item in ("times", "deformation", "origin", "rotation", "rms"):
            object.__setattr__(self, item, read_only(getattr(self, item)))

    def at(self, rows: np.ndarray) -> ResidualCorrections:
        """The corrections at some of the times, by their indices."""
        return ResidualCorrections(
            self.times[rows],
            self.deformation[:, rows],
            self.origin[rows],
            self.rotation[rows],
            self.rms[rows],
            self.factorizations,
        )


def residual_corrections(
    system: System, full: FullBody, basis: ReductionBasis, solution: Solution, instants: np.ndarray
) -> ResidualCorrections:
    """Motion of one body outside its basis at some output times of a run; see `system_corrections`."""
    return system_corrections(system, (full,), {full.name: basis}, solution, instants)[full.name]


def system_corrections(
    system: System,
    fulls: Sequence[FullBody],
    bases: Mapping[str, ReductionBasis],
    solution: Solution,
    instants: np.ndarray,
    *,
    between: np.ndarray | None = None,
    tolerance: float = CONVERGED,
    progress: Progress | None = None,
) -> dict[str, ResidualCorrections]:
    """Motion outside the bases of a finished run at some of its output times, by body.

    All bodies are corrected together, because the missing motion of one body loads the others.

    Parameters
    ----------
    system : System             as simulated, with the reduced bodies
    fulls : FullBody            bodies to correct, with all their coordinates
    bases : ReductionBasis      of the reduced bodies, by name
    solution : Solution         of the run
    instants : int array (k,)   indices of output times; the missing motion at one of them is the start value
                                at the next (`MissingMotionSearch`)
    between : int array         indices of intermediate times, along which the motion is followed where the
                                search does not converge directly; None: no intermediate times
    tolerance : float           largest last correction, relative to the motion found
    progress : function         called with the completed fraction of the times

    Raises
    ------
    ModelError      the system has no such body, or its number of coordinates is not that of the basis
    AccuracyError   no equilibrium was found at any time and a tangent is singular: the body has buckled, or
                    its joints are in a singular position (dead centre)
    """
    instants = np.asarray(instants)
    others = np.setdiff1d(np.zeros(0, dtype=np.intp) if between is None else between, instants)
    seen = expanded_states(system, fulls, bases, solution, np.concatenate([instants, others]))
    prepared, indices = seen.prepared, seen.indices
    search = MissingMotionSearch(prepared, seen.by_position)
    states = [seen.state(row) for row in range(len(instants))]
    steps, known = np.zeros((len(instants), prepared.n)), np.zeros(len(instants), dtype=bool)
    reached = -1
    for done, row in enumerate(np.argsort(instants, kind="stable"), start=1):
        missing = search.directly(states[row], tolerance) if len(others) else None
        if missing is None:
            for other in np.flatnonzero((others > reached) & (others < instants[row])):
                search.at(seen.state(len(instants) + int(other)), FOLLOWED)
            missing = search.at(states[row], tolerance)
        reached = instants[row]
        if missing is not None:
            steps[row], known[row] = missing.displacement, True
        if progress is not None:
            progress(done / len(instants))
    if search.singular is not None and not known.any():
        raise search.singular
    for index, full in zip(indices, fulls, strict=True):
        own, rigid = steps[:, prepared.slices[index]], seen.expanded[full.name].rigid[: len(instants)]
        rotations = solution.motion(full.name, FloatingMotion).rotation[instants]
        own[:, :3] -= np.einsum("tij,tj->ti", rotations, rigid[:, :3])
        own[:, 3:6] -= rigid[:, 3:]
    found = corrections_of(seen, fulls, states, steps)
    return {
        name: replace(own, rms=np.where(known, own.rms, np.inf), factorizations=search.factorizations)
        for name, own in found.items()
    }


def corrections_of(
    seen: ExpandedStates, fulls: Sequence[FullBody], states: Sequence[FullState], steps: np.ndarray
) -> dict[str, ResidualCorrections]:
    """The parts of single bodies in changes `steps` (k, n) of k states of the whole system, by name."""
    times = np.array([state.time for state in states])
    found = {}
    for index, full in zip(seen.indices, fulls, strict=True):
        own = steps[:, seen.prepared.slices[index]]
        moved = displacements(seen, index, full, slice(None), states, steps)
        found[full.name] = ResidualCorrections(
            times=times,
            deformation=own[:, 6:].T,
            origin=own[:, :3],
            rotation=own[:, 3:6],
            rms=rms_over_points(moved),
        )
    return found


def rms_over_points(vectors: np.ndarray) -> np.ndarray:
    """Root-mean-square length (k,) over the points of vectors (k, p, 3)."""
    return np.sqrt(np.mean(np.sum(vectors**2, axis=2), axis=1))


def displacements(
    seen: ExpandedStates,
    index: int,
    full: FullBody,
    at: str | slice | Sequence[int],
    states: Sequence[FullState],
    steps: np.ndarray,
) -> np.ndarray:
    """Displacements (k, p, 3) of p nodes, or of an interface (p = 1), in changes `steps` (k, n) of k states.

    Displacements in space if the joints fix all rigid motion. Otherwise no static equilibrium determines the
    rigid motion, and the displacements are those of the deformation in mean axes.

    index : of the body in the machine
    at : nodes, or the name of an interface
    """
    prepared = seen.prepared
    if isinstance(at, str):
        interface = full.interface(at)
        places = interface.position[None]

        def expand(coordinates: np.ndarray) -> np.ndarray:
            return (coordinates @ interface.motion[:3].T)[:, None]
    else:
        places = full.nodes[at]

        def expand(coordinates: np.ndarray) -> np.ndarray:
            return full.expand(coordinates)[:, at]

    own = steps[:, prepared.slices[index]]
    if not seen.joints_fix_rigid_motion:
        return expand(frame_projector(full.body, MeanAxisFrame())(own[:, 6:].T).T)
    part = prepared.coordinate_slices[index]
    coordinates = np.array([state.configuration.coordinates[part] for state in states])
    rotations = np.array([state.configuration.rotations[index] for state in states])
    turned = np.cross(own[:, None, 3:6], places + expand(coordinates))
    return in_space(own[:, :3], rotations, expand(own[:, 6:]) + turned)


@dataclass(frozen=True, eq=False)
class ExpandedStates:
    """States of a reduced run with all coordinates of some of its bodies, computed one at a time.

    prepared : FullSystem           the machine with these bodies in full
    indices : indices of these bodies in the machine
    by_position : float             p, the ratio of displacement to acceleration
    """

    prepared: FullSystem
    indices: tuple[int, ...]
    by_position: float
    solution: Solution
    instants: np.ndarray
    expanded: Mapping[str, _ExpandedMotion]

    @cached_property
    def joints_fix_rigid_motion(self) -> bool:
        """Whether the joints of the machine fix all rigid motion."""
        return fixes_rigid_motion(self.prepared.system, self.prepared.model)

    def state(self, row: int) -> FullState:
        """The state at the output time with index `instants[row]`."""
        return _expanded(self.prepared, self.solution, self.expanded, row, int(self.instants[row]))


def expanded_states(
    system: System,
    fulls: Sequence[FullBody],
    bases: Mapping[str, ReductionBasis],
    solution: Solution,
    instants: np.ndarray,
) -> ExpandedStates:
    """Expanded states of a finished reduced run; parameters as for `system_corrections`."""
    indices, reduced = zip(*(_found(system, full, bases[full.name]) for full in fulls), strict=True)
    placed = list(system.bodies)
    for index, full in zip(indices, fulls, strict=True):
        at_rest = np.zeros(full.n_coordinates)
        placed[index] = replace(placed[index], body=full, coordinates=at_rest, coordinate_rates=at_rest)
    expanded = {
        full.name: _expanded_motion(full, body, bases[full.name], motion, instants)
        for full, body in zip(fulls, reduced, strict=True)
        for motion in (solution.motion(full.name, FloatingMotion),)
    }
    prepared = FullSystem(replace(system, bodies=placed), active_constraints(system, solution))
    lowest = min(body.lowest_frequency() for body in reduced)
    slowness = (
        _SLOWNESS
        if fixes_rigid_motion(prepared.system, prepared.model)
        else _slowness_in_flight(solution, lowest)
    )
    return ExpandedStates(
        prepared=prepared,
        indices=indices,
        by_position=(slowness / lowest) ** 2,
        solution=solution,
        instants=instants,
        expanded=expanded,
    )


def active_constraints(system: System, solution: Solution) -> tuple[int, ...]:
    """Indices of the constraint equations of a run that are not redundant."""
    known = solution.engine_state.get("active")
    if known is not None:
        return tuple(int(index) for index in known)
    with warnings.catch_warnings():
        # The run has reported the redundant ones already.
        warnings.simplefilter("ignore", RedundantConstraintWarning)
        return compiled_start(system, float(solution.times[0])).model.active


def _slowness_in_flight(solution: Solution, lowest: float) -> float:
    """Ratio of the lowest natural frequency to 1 / sqrt(p), from the bodies' angular velocities."""
    motions = [solution.motion(name, FramedMotion) for name in solution.bodies]
    spins = [float(np.linalg.norm(own.angular_velocity, axis=1).max()) for own in motions]
    return float(np.clip(lowest / (_FASTER_THAN_SPIN * max([*spins, 1e-300])), *_SLOWNESS_IN_FLIGHT))


def _found(system: System, full: FullBody, basis: ReductionBasis) -> tuple[int, BodyForm]:
    """Index of a body in the system, and its reduced form there."""
    index = system.body_index(full.name, "residual correction")
    body = system.bodies[index].body
    if body.n_coordinates != basis.r:
        raise ModelError(
            f"residual correction: body '{full.name}' is in the system as a {type(body).__name__}; give the "
            f"simulated system, where it is reduced to {basis.r} coordinates"
        )
    return index, body


class _ExpandedMotion(NamedTuple):
    """Coordinates (k, n) of one body at k times; `rigid` (k, 6): rigid part of z, as in `RunColumns`."""

    coordinates: np.ndarray
    coordinate_rates: np.ndarray
    coordinate_accelerations: np.ndarray
    rigid: np.ndarray


def _expanded_motion(
    full: FullBody, reduced: ReducedBody, basis: ReductionBasis, motion: FloatingMotion, instants: np.ndarray
) -> _ExpandedMotion:
    gamma, rate, acceleration = (
        getattr(motion, item)[instants]
        for item in ("coordinates", "coordinate_rates", "coordinate_accelerations")
    )
    moved = [each @ basis.vectors.T for each in (gamma, rate, acceleration)]
    rigid = np.zeros((len(gamma), 6))
    if reduced.condensed is not None:
        condensation = Condensation(full.body, basis)
        z = condensation.bilinear  # z(gamma) = z(gamma, gamma); rates by the product rule
        following = z(gamma, gamma)
        rigid = condensation.rigid_part(following).T
        moved[0] = moved[0] + following.T
        moved[1] = moved[1] + 2 * z(gamma, rate).T
        moved[2] = moved[2] + 2 * (z(rate, rate) + z(gamma, acceleration)).T
    return _ExpandedMotion(moved[0], moved[1], moved[2], rigid)


def _expanded(
    prepared: FullSystem,
    solution: Solution,
    expanded: Mapping[str, _ExpandedMotion],
    row: int,
    instant: int,
) -> FullState:
    """State of the run at one output time, with all coordinates of the expanded bodies."""

    def now(item: str, body: str) -> np.ndarray:
        if body in expanded and item.startswith("coordinate"):
            return getattr(expanded[body], item)[row]
        return getattr(solution.bodies[body], item)[instant]

    def joined(*items: str) -> np.ndarray:
        return np.concatenate([now(item, body) for body in names for item in items])

    system = prepared.system
    names = [placed.body.name for placed in system.bodies]
    multipliers = np.concatenate(
        [np.zeros(0)] + [solution.multipliers[joint.name][instant] for joint in system.joints]
    )
    acceleration = joined("acceleration", "angular_acceleration", "coordinate_accelerations")
    return FullState(
        time=float(solution.times[instant]),
        configuration=Configuration(
            np.array([now("position", body) for body in names]),
            np.array([now("rotation", body) for body in names]),
            joined("coordinates"),
        ),
        velocity=joined("velocity", "angular_velocity", "coordinate_rates"),
        acceleration=acceleration,
        auxiliary=acceleration,
        multipliers=multipliers[list(prepared.model.active)],
        # Frame conditions carry no force: the six frame equations already balance the sum of nodal forces.
        frame_multipliers=tuple(np.zeros(6) for _ in prepared.interiors),
    )
