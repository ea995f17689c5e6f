"""Truncation error: change of a motion by the omitted modes, drift of the centre of mass, and warnings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
import scipy  # its parts are imported when first used
from numpy.typing import NDArray

from supple.algebra import read_only
from supple.arrays import FloatArray
from supple.equations.checks.strictness import warn_or_raise
from supple.equations.compiler_options import STARTING
from supple.errors import ModelError, ValidityWarning
from supple.integrate import ErrorPart, Run, Solution
from supple.machine import System
from supple.methods.intrinsic.complete_motion import complete_motion, intrinsic_of, states_of
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody, body_of
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.methods.intrinsic.line_equations import momenta, station_velocities
from supple.methods.intrinsic.line_system import LineSystem, States, places_of, system_wrenches
from supple.methods.intrinsic.machine_of_lines import machine_of_lines
from supple.methods.intrinsic.supported_root import is_joined
from supple.programs.program_cache import CachedProgram

__all__ = ["TruncationError", "truncation_error"]


INSTANTS = 8
"""Number of sampled output times that are spread over the run."""

STIFF = 1e-3
"""Smallest deflection relative to which the drift is stated, as a fraction of the length."""

ROUNDING = 1e-9
"""Smallest deflection relative to which changes of positions are stated, as a fraction of the length."""

LARGEST = 1e-2
"""Truncation error relative to the deflection, above which a warning is issued."""

FEWEST = 5
"""Fewest output times for which the impulse of the loads is integrated; with fewer, the drift is 0."""


@dataclass(frozen=True, eq=False)
class TruncationError:
    """Change of a motion by the omitted modes.

    times : (t,)            sampled output times
    places : (t,)           RMS change of station positions, m; infinite where `complete_motion` fails
    forces, velocities : (t,)   norms of the changes of q_2 and of q_1, relative to the largest norm of each
    drift : float           drift of a free body's centre of mass from the motion due to its loads, m
    deflection : float      largest displacement of a station relative to the root, m
    length : float          extent of the undeformed body, m
    """

    times: FloatArray
    places: FloatArray
    forces: FloatArray
    velocities: FloatArray
    drift: float
    deflection: float
    length: float

    @property
    def drifts(self) -> bool:
        """Whether the drift is larger than the largest change of places."""
        return self.drift > float(self.places.max(initial=0.0))

    @property
    def largest(self) -> float:
        """Larger of `places` and `drift`, relative to the deflection.

        The deflection is at least `ROUNDING` * length for `places`, and `STIFF` * length for `drift`.
        """
        size = float(self.places.max(initial=0.0))
        of_places = size / max(self.deflection, ROUNDING * self.length)
        return max(of_places, self.drift / max(self.deflection, STIFF * self.length))


def error_instants(system: System, solution: Solution) -> NDArray[np.intp]:
    """Sampled output times (t,): spread over the run, and at the largest strain of each body."""
    n = len(solution.times)
    spread = np.linspace(0, n - 1, INSTANTS + 1).round().astype(int)[1 if n > 1 else 0 :]
    largest = [
        int(np.linalg.norm(body_of(placed).forces_of(motion.coordinates), axis=1).argmax())
        for placed in intrinsic_of(system)
        for motion in (solution.motion(placed.body.name, IntrinsicMotion),)
    ]
    return np.unique(np.append(spread, largest))


def truncation_error(
    system: System, solution: Solution, whole: Sequence[IntrinsicBody] = ()
) -> dict[str, TruncationError]:
    """Truncation error of a run by body, at a few instants, by `complete_motion`.

    The error is larger than estimated if the motion excites omitted modes near their own frequencies, because
    their response is then not static. Where joints connect bodies, each line is estimated by itself, with its
    root and joint forces from the run; changes of the other bodies' motion are not included.

    Parameters
    ----------
    system, solution : a machine with intrinsic bodies, and its run
    whole : bodies with more modes, matched by name; needed for bodies without `complete`

    Raises ModelError if no intrinsic body has omitted modes, and for machines with controllers.
    Source: [Wang2015] (37), as an error estimate.
    """
    check_without_controllers(system)
    by_name = {body.name: body for body in whole}
    lines = intrinsic_of(system)
    bodies = {placed.body.name: body_of(placed) for placed in lines}
    for name, own in bodies.items():
        if name in by_name and by_name[name].n_coordinates > own.n_coordinates:
            bodies[name] = replace(own, complete=by_name[name])
    few = [body for body in bodies.values() if body.complete is not None]
    if not few:
        raise ModelError(
            f"body '{lines[0].body.name}': to estimate its truncation error, give the same body with more "
            "modes (the same line and support, a larger n_modes)"
            if lines
            else "the machine has no intrinsic body, and other bodies have no truncation error"
        )
    machine = replace(
        system,
        bodies=[replace(placed, body=bodies.get(placed.body.name, placed.body)) for placed in system.bodies],
    )
    rows = error_instants(machine, solution)
    complete = complete_motion(machine, solution, rows)
    found = {}
    for body in few:
        more = body.complete
        assert more is not None
        shown = complete.shown.motion(body.name, IntrinsicMotion)
        other = complete.solution.motion(body.name, IntrinsicMotion)
        first, second = more.places(shown)[1], more.places(other)[1]
        places = np.sqrt(np.mean(np.sum((first - second) ** 2, axis=2), axis=1))
        forces, changed = (more.forces_of(motion.coordinates) for motion in (shown, other))
        found[body.name] = TruncationError(
            times=read_only(complete.solution.times),
            places=read_only(np.where(complete.found, places, np.inf)),
            forces=_share(changed - forces, changed),
            velocities=_share(other.rates - shown.rates, other.rates),
            drift=centre_drift(machine, solution, body.name),
            deflection=_deflection(body, solution),
            length=float(np.linalg.norm(np.ptp(body.line.tree.points, axis=0))),
        )
    return found


def centre_drift(system: System, solution: Solution, name: str) -> float:
    """Largest distance of a free body's centre of mass from the motion due to the impulse of its loads, m.

        c(t) - c(0) - c'(0) t - 1/m int int F dt dt

    c is the centre of mass, m the mass, and F the sum of the loads. With few modes, the momentum of a bent
    free line follows the loads only approximately. F is a cubic spline through its values at the output
    times. The difference from a spline through every second value estimates the spline's error, which is
    subtracted.

    Returns 0 for a body with a supported root, if `is_joined`, and for fewer than five output times.
    """
    number, times = system.body_index(name), solution.times
    body = body_of(system.bodies[number])
    if is_joined(system) or body.support.free.shape[1] < 6 or len(times) < FEWEST:
        return 0.0
    lines = machine_of_lines(system, float(times[0])).lines
    states = tuple(states_of(body_of(each), solution.bodies[each.body.name]) for each in system.bodies)
    masses = tuple(body_of(each).line.translating for each in system.bodies)
    found = _centres(lines, masses, jnp.asarray(times), states)
    centre, velocity, force = jax.device_get(found[number])
    acceleration = force / body.mass

    def displacement(known: slice) -> FloatArray:
        spline = scipy.interpolate.CubicSpline(times[known], acceleration[known])
        return spline.antiderivative(2)(times)

    path = displacement(slice(None))
    free = centre[0] + velocity[0] * (times - times[0])[:, None]
    away = np.linalg.norm(centre - free - path, axis=1)
    unsure = np.linalg.norm(path - displacement(slice(None, None, 2)), axis=1)
    return float(np.maximum(away - unsure, 0.0).max())


def _centres_of_lines(
    system: LineSystem, masses: tuple[jax.Array, ...], times: jax.Array, states: States
) -> list[tuple[jax.Array, jax.Array, jax.Array]]:
    """Centre of mass, its velocity, and the sum of the loads (t, 3) of each line."""

    def at(instant: tuple[jax.Array, States]) -> list[tuple[jax.Array, jax.Array, jax.Array]]:
        time, now = instant
        roots = tuple(None if drive is None else drive.twist(time) for drive in system.drives)
        found = []
        for model, drive, state, mass, wrench in zip(
            system.lines, system.drives, now, masses, system_wrenches(system, now, time, roots), strict=True
        ):
            own, moments = jnp.trace(mass[:, :3], axis1=1, axis2=2) / 3, mass[:, 3:]
            # Mass times the offset of its centre from the station: the moments are skew-symmetric.
            beside = 0.5 * (moments[:, [2, 0, 1], [1, 2, 0]] - moments[:, [1, 2, 0], [2, 0, 1]])
            rotations, positions = places_of(model, drive, state, time)
            centre = (own[:, None] * positions + jnp.einsum("nij,nj->ni", rotations, beside)).sum(axis=0)
            p = momenta(model, station_velocities(model, state.q1), state.q1, None)
            loads = jnp.zeros((len(own), 3)) if wrench is None else wrench[:, :3]
            linear, force = (jnp.einsum("nij,nj->i", rotations, each) for each in (p[:, :3], loads))
            found.append((centre / own.sum(), linear / own.sum(), force))
        return found

    return jax.lax.map(at, (times, states))


_centres = CachedProgram(_centres_of_lines, STARTING)


def check_without_controllers(system: System) -> None:
    """Raise ModelError for a machine with controllers: the response to their forces is not computed."""
    if system.controllers:
        raise ModelError(
            f"controller '{system.controllers[0].name}': the truncation error of machines with controllers "
            "is not estimated, because the response to the forces of controllers is not computed: compare "
            "with a run with more modes"
        )


def _share(change: FloatArray, amplitudes: FloatArray) -> FloatArray:
    largest = np.linalg.norm(amplitudes, axis=1).max(initial=0.0)
    return read_only(np.linalg.norm(change, axis=1) / (largest or 1.0))


def _deflection(body: IntrinsicBody, solution: Solution) -> float:
    """Largest displacement of a station relative to the root."""
    motion = solution.motion(body.name, IntrinsicMotion)
    _, positions = body.places(motion)
    seen = np.einsum("tij,tni->tnj", motion.rotation, positions - positions[:, :1])
    rest = body.line.tree.points - body.line.tree.points[0]
    return float(np.linalg.norm(seen - rest, axis=2).max(initial=0.0))


def truncation_parts(system: System, solution: Solution) -> Mapping[str, ErrorPart]:
    """Truncation part of the error, by body: that of the run, or computed if the run has none."""
    return solution.truncation or {name: _part(each) for name, each in _errors(system, solution).items()}


def report_truncation(system: System, run: Run, solution: Solution) -> Solution:
    """The solution with `truncation`, the part of its error due to omitted modes.

    Warns (ValidityWarning; an error in a strict run) of bodies with a truncation error above 1 % of the
    deflection.
    """
    errors = _errors(system, solution)
    for name, error in errors.items():
        _warn(system, run, name, error)
    return replace(solution, truncation={name: _part(error) for name, error in errors.items()})


def report_truncation_of_cases(cases: Sequence[System], run: Run, solutions: Sequence[Solution]) -> None:
    """Warn about the largest truncation error of a batch, with each body in its most strained case."""
    finished = [number for number, solution in enumerate(solutions) if solution.stopped is None]
    if not finished:
        return
    found: dict[int, dict[str, TruncationError]] = {}
    worst: tuple[float, int, str] | None = None
    for placed in intrinsic_of(cases[0]):
        name = placed.body.name
        number = max(finished, key=lambda n, name=name: _strain(cases[n], solutions[n], name))
        if number not in found:
            found[number] = _errors(cases[number], solutions[number])
        if name in found[number]:
            worst = max(worst or (0.0, 0, ""), (found[number][name].largest, number, name))
    if worst is not None:
        _, number, name = worst
        _warn(cases[number], run, name, found[number][name], where=f"case {number}: ")


def _strain(system: System, solution: Solution, name: str) -> float:
    """Square root of twice the largest strain energy of a body in a run."""
    body = body_of(system.bodies[system.body_index(name)])
    forces = body.forces_of(solution.motion(name, IntrinsicMotion).coordinates)
    return float(np.linalg.norm(forces, axis=1).max(initial=0.0))


def _errors(system: System, solution: Solution) -> dict[str, TruncationError]:
    """`truncation_error` of the bodies with omitted modes; none for machines with controllers."""
    few = any(body_of(placed).complete is not None for placed in intrinsic_of(system))
    known = not is_joined(system) or all(joint.name in solution.multipliers for joint in system.joints)
    estimated = few and known and not system.controllers and solution.stopped is None
    return truncation_error(system, solution) if estimated else {}


def _warn(system: System, run: Run, name: str, error: TruncationError, where: str = "") -> None:
    if error.largest <= LARGEST:
        return
    body = system.bodies[system.body_index(name)].body
    why = (
        f"its centre of mass drifts by {error.drift:.2g} from the path due to its loads"
        if error.drifts
        else f"with all modes its stations would move by {max(error.places):.2g} (RMS)"
    )
    warn_or_raise(
        f"{where}body '{name}': {body.n_coordinates} modes are too few: {why}, which is {error.largest:.1%} "
        "of its deflection. Keep more modes, or omit their number: then all modes are kept, or as many as a "
        "given accuracy needs",
        ValidityWarning,
        run.validity,
    )


def _part(error: TruncationError) -> ErrorPart:
    return ErrorPart(
        max(error.drift, *error.places),
        "drift of the centre of mass"
        if error.drifts
        else "omitted modes follow the motion statically, at a few instants",
        "keep more modes",
    )
