"""Error of a run caused by the kinematics of the model, at the motion of the run.

If elements or rigid interfaces rotate relative to the frame of their body, the elements have spurious strains
of third order in the rotation. At the times of the largest rotations, two internal forces of the elements are
compared: f of the model, and f_turned with exact rotations of elements and ties (`turned_force`). One Newton
step of the whole system gives the resulting change of the motion,

    K_t delta = - ( f_turned(q) - f(q) ),

with the tangent K_t, and the constraints of joints and frames (`residual_correction`). q is the run's motion
plus the quasi-static motion that the basis lacks (`missing_motion`). Without this addition, elements may be
compressed, because the basis cannot relax the compression, and K_t may be nearly singular. For a strip of
1 m, bent by a quarter of its length, the estimate would be 5 mm instead of 0.1 mm. The estimate is
quasi-static. It does not include changed frequencies, which affect the phase of long vibrations, nor the
discretisation error of the mesh.

A body without elements, and any body of a machine with controllers, is assessed by its rotation limit: the
relative error of a deflection is about 2e-3 at the `rotation_limit` (strips of h/t = 10) and grows with the
third power of the rotation.

A body condensed to a line (`condense`) has no rotation limit. Its mass is lumped at the stations, and its
error is the resulting error of deflections under its weight, of second order in the length of the segments.
Forces at stations cause no such error. Deformations of the sections by large bending are not included. The
error of a line that is not condensed from elements is unknown.

A linear body is compared with the body before linearisation, whose quadratic strains include the shortening
by bending and the membrane stiffening. If the body bends by more than its thickness, its linear motion has a
large residual from stretching alone. For a plate 4 mm thick, with nodes displaced by 14 mm, the estimate
would be 0.3 m instead of 0.14 mm. The linear motion is therefore corrected to second order first; Newton's
method continues from the result (`MissingMotionSearch`). Without elements or with controllers, the error of a
linear body is theta^2 / 2 of its length L, with theta its largest rotation. Where rotations are unknown,
theta = 3 u / (2 L), that of a cantilever with the same end displacement u. A linear body also lacks the
centrifugal stiffness. Its ratio to the elastic stiffness is taken as (spin / lowest frequency)^2, at most 1,
and this fraction of the displacement is added to the error.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from supple.body import BodyForm, FlexibleBody, MeanAxisFrame, smaller_rotations
from supple.body.full_body import FullBody
from supple.body.turned_elements import turned_force
from supple.equations.checks.validity import is_rotor
from supple.error.missing_motion import MissingMotionSearch
from supple.error.residual_correction import (
    ExpandedStates,
    ResidualCorrections,
    corrections_of,
    displacements,
    expanded_states,
    rms_over_points,
)
from supple.integrate import ErrorPart, FramedMotion, Solution
from supple.integrate.engine import Progress
from supple.machine import System
from supple.methods.floating.full.full_state import FullState
from supple.quantities import PositionSensor, QuantityOfInterest, WholeBody
from supple.quantities.place import Place
from supple.quantities.quantity_of_interest import blocks_of_times, largest_displacement
from supple.reduction import ReductionBasis

INSTANTS = 6
"""Number of times at which forces are compared: those of the largest rotation in six parts of the run."""
CANTILEVER = 1.5
"""Ratio of the end rotation of a cantilever under an end force to its deflection over length."""
AT_LIMIT = 2e-3
"""Relative error of the deflection at the rotation limit of the kinematics."""


def model_errors(
    system: System,
    fulls: Mapping[str, FullBody],
    bases: Mapping[str, ReductionBasis],
    solution: Solution,
    quantities: Sequence[QuantityOfInterest],
    *,
    instants: int = INSTANTS,
    progress: Progress | None = None,
) -> dict[str, ErrorPart]:
    """Errors of a finished run caused by the kinematics of the model, by name of the quantity.

    Parameters
    ----------
    system, solution : the machine as simulated, with its bodies reduced, and the result
    fulls : the full bodies of the reduced ones, by name; the rotation limit is used for other bodies, bodies
        without elements, and machines with controllers
    bases : of the reduced bodies, by name
    quantities : the error of positions of a body in `fulls` is the RMS of the computed change of its nodes;
        for another quantity it is the size of the quantity times the relative error of its body. If the
        quantity has no body, or a rigid one, the largest relative error of all bodies counts
    instants : number of times at which forces are compared (`widest_instants`)
    """
    seen_bodies = [full for name, full in fulls.items() if full.body.model is not None and name in bases]
    if system.controllers:  # their forces are known during the run only
        seen_bodies = []
    changes: _Changes | None = None
    if seen_bodies:
        changes = _with_exact_rotations(system, seen_bodies, bases, solution, instants, progress)
    missed = {} if changes is None else changes.corrections
    limits = model_errors_by_limit(system, solution, but=missed)
    errors = {**limits, **{body: float(own.rms.max()) for body, own in missed.items()}}
    known = [each for each in quantities if _is_known(each, system)]
    return {each.name: _part(each, system, solution, changes, errors) for each in known}


def _is_known(quantity: QuantityOfInterest, system: System) -> bool:
    """Whether the error is known of the quantity's body or, if it has none, of all elastic bodies."""
    bodies = [placed.body for placed in system.bodies if placed.body.n_coordinates]
    own = [body for body in bodies if body.name == quantity.body]
    return all(body.lumping_error is not None for body in own or bodies)


@dataclass(frozen=True, eq=False)
class _Changes:
    """Quasi-static changes `steps` (k, n) of k states of the machine; `fulls` are its assessed bodies."""

    seen: ExpandedStates
    fulls: Sequence[FullBody]
    states: Sequence[FullState]
    steps: np.ndarray

    @cached_property
    def corrections(self) -> dict[str, ResidualCorrections]:
        """The changes of each body."""
        return corrections_of(self.seen, self.fulls, self.states, self.steps)

    def rms_at(self, place: Place) -> float:
        """Largest displacement of a place: of an interface, or RMS over nodes."""
        number = [full.name for full in self.fulls].index(place.body)
        index, full = self.seen.indices[number], self.fulls[number]
        at = place.at if isinstance(place.at, str) else list(place.at)
        moved = displacements(self.seen, index, full, at, self.states, self.steps)
        return float(rms_over_points(moved).max())


def _with_exact_rotations(
    system: System,
    fulls: Sequence[FullBody],
    bases: Mapping[str, ReductionBasis],
    solution: Solution,
    parts: int,
    progress: Progress | None,
) -> _Changes:
    """Quasi-static changes, at the times of the largest rotations, if elements and ties rotate exactly."""
    instants = widest_instants(system, solution, parts)
    seen = expanded_states(system, fulls, bases, solution, instants)
    search = MissingMotionSearch(seen.prepared, seen.by_position)
    further = search
    if any(full.body.linearized_from is not None for full in fulls):
        fulls = [_with_quadratic_strains(full) for full in fulls]
        stretched = expanded_states(system, fulls, bases, solution, instants)
        further = MissingMotionSearch(stretched.prepared, stretched.by_position)

    def forces(of: Callable[[FlexibleBody, np.ndarray], np.ndarray], at: FullState) -> dict[str, np.ndarray]:
        places = [seen.prepared.coordinate_slices[index] for index in seen.indices]
        return {
            full.name: of(full.body, at.configuration.coordinates[place])
            for full, place in zip(fulls, places, strict=True)
        }

    states, steps = [], np.zeros((len(instants), seen.prepared.n))
    for row in range(len(instants)):
        state = seen.state(row)
        missing = search.at(state)
        if missing is not None:
            state = search.moved(state, missing)
        states.append(state)
        if further is not search:
            bent = search.response(state, forces(_second_order, state))
            state = further.moved(state, bent)
            lacking = further.at(state)
            steps[row] = bent.displacement
            if lacking is not None:
                state = further.moved(state, lacking)
                steps[row] += lacking.displacement
        steps[row] += further.response(state, forces(_spurious, state)).displacement
        if progress is not None:
            progress((row + 1) / len(instants))
    return _Changes(seen, fulls, states, steps)


def _spurious(body: FlexibleBody, q: np.ndarray) -> np.ndarray:
    """Forces (n,) of elements and ties that rotate exactly, less the forces of the body's own kinematics."""
    return turned_force(body, q) - body.force.internal_force(q)


def _second_order(body: FlexibleBody, q: np.ndarray) -> np.ndarray:
    """Even part (f(q) + f(-q)) / 2 (n,) of the internal forces, which shortens a bent body.

    Linear motion stretches a body that bends; Newton's method may diverge from such a motion.
    """
    return (body.force.internal_force(q) + body.force.internal_force(-q)) / 2


def _with_quadratic_strains(full: FullBody) -> FullBody:
    """The body before it was linearised; any other body unchanged."""
    return replace(full, body=full.body.linearized_from or full.body)


def model_errors_by_limit(
    system: System, solution: Solution, *, but: Container[str] = ()
) -> dict[str, float]:
    """Error of the nodes of every elastic body, from its largest rotation and its rotation limit.

    The error of a linear body follows from rotation and length, and from its spin. The error of any other
    body follows from its rotation limit, if it has one, and from the lumping of its mass, if any.

    but : names of bodies to leave out
    """
    found = {}
    for placed in system.bodies:
        body = placed.body
        motion = solution.motion(body.name, FramedMotion)
        if not body.n_coordinates or body.name in but:
            continue
        size = largest_displacement(body, motion.coordinates)
        turn = float(_largest_rotation(body, motion).max(initial=0.0))
        if body.is_linear:
            length = float(np.linalg.norm(np.ptp(body.nodes, axis=0)))
            if body.rotation_rows is None:
                turn = CANTILEVER * size / length if length else 0.0
            found[body.name] = turn**2 / 2 * length + _missing_stiffness(body, motion) * size
            continue
        known = np.isfinite(body.rotation_limit)
        share = AT_LIMIT * (turn / body.rotation_limit) ** 3 if known else 0.0
        found[body.name] = (float(share) + (body.lumping_error or 0.0)) * size
    return found


def _missing_stiffness(body: BodyForm, motion: FramedMotion) -> float:
    """Missing centrifugal stiffness of a linear body at its fastest spin, over its stiffness; at most 1."""
    spins = np.linalg.norm(motion.angular_velocity, axis=1)
    fastest = int(np.argmax(spins))
    if not spins[fastest] or is_rotor(body, motion, fastest):
        return 0.0
    return min(float(spins[fastest] / body.lowest_frequency()) ** 2, 1.0)


def widest_instants(system: System, solution: Solution, parts: int = INSTANTS) -> np.ndarray:
    """Indices of the output times of largest rotation, one in each of `parts` equal parts of the run."""
    turns = np.zeros(len(solution.times))
    for placed in system.bodies:
        if placed.body.n_coordinates:
            own = _largest_rotation(placed.body, solution.motion(placed.body.name, FramedMotion))
            turns = np.maximum(turns, own / max(float(own.max(initial=0.0)), 1e-300))
    split = np.array_split(np.arange(len(turns)), min(parts, len(turns)))
    return np.array([part[np.argmax(turns[part])] for part in split])


def _largest_rotation(body: BodyForm, motion: FramedMotion) -> np.ndarray:
    """Largest rotation relative to the frame (t,), rad; if unknown, the norm of the coordinates instead."""
    rows = body.rotation_rows
    if rows is None:
        return np.linalg.norm(motion.coordinates, axis=1)
    found = np.empty(len(motion.coordinates))
    for times in blocks_of_times(len(found)):
        turns = (motion.coordinates[times] @ rows.T).reshape(-1, rows.shape[0] // 3, 3)
        found[times] = np.sqrt((turns**2).sum(axis=2).max(axis=1))
    return found


def _part(
    quantity: QuantityOfInterest,
    system: System,
    solution: Solution,
    changes: _Changes | None,
    errors: Mapping[str, float],
) -> ErrorPart:
    """The model part of a quantity; `errors` are those of the nodes of the bodies."""
    name = quantity.body if quantity.body in errors else None  # None: the largest error of all bodies
    remedy = _remedy(system, name)
    exactly = "elements and ties rotated exactly"
    if changes is not None and name in changes.corrections:
        if isinstance(quantity, WholeBody):
            return ErrorPart(errors[name], exactly, remedy)
        if isinstance(quantity, PositionSensor):
            return ErrorPart(changes.rms_at(quantity.place), exactly, remedy)
    shares = [0.0]
    for body, error in errors.items():
        if name not in (None, body):
            continue
        motion = solution.motion(body, FramedMotion)
        size = largest_displacement(system.placed(body).body, motion.coordinates)
        if size > 0:
            shares.append(error / size)
    return ErrorPart(max(shares) * quantity.size(system, solution), "relative to the body's motion", remedy)


def _remedy(system: System, name: str | None) -> str:
    """Remedy for one elastic body, or for the machine: mean axes where they are not used yet."""
    bodies = [placed.body for placed in system.bodies if placed.body.n_coordinates]
    own = [body for body in bodies if name in (None, body.name)]
    if own and all(body.lumping_error for body in own):
        return "take more stations"
    frames = [getattr(body, "frame", None) for body in own]
    others = [frame for frame in frames if not isinstance(frame, MeanAxisFrame)]
    smaller = smaller_rotations((others or frames or [None])[0])
    if any(body.is_linear for body in own):
        return f"reduce it with modal derivatives, from a model with quadratic strains, or {smaller}"
    return smaller
