"""The error of a reduced run at every step, from its residual: the error equation of a whole system."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.algebra.rotation import rotation_exp, rotation_log, rotation_right_jacobian
from supple.body import Damping, FlexibleBody, FullBody, Frame, in_space
from supple.error_equation.elastic_history import force_polynomial, tangent_history
from supple.error_equation.error_model import body_of_columns, system_of_columns
from supple.error_equation.error_space import ErrorSpace
from supple.error_equation.linearised_march import (
    ElasticGain,
    ErrorState,
    GainHistory,
    StepOfRun,
    first_error,
    march_error,
)
from supple.error_equation.nodal_squares import NodalSquares, nodal_squares
from supple.error_equation.run_columns import RunColumns
from supple.integrate import Coefficients, Solution
from supple.machine import System
from supple.multibody.equations.build_model import build_model
from supple.multibody.equations.configuration import Configuration, SystemMotion
from supple.multibody.equations.model import Model
from supple.reduction import ReducedBody

__all__ = ["ErrorHistory", "JudgedBody", "StartError", "error_histories"]

Array = NDArray[np.float64]

STEPS_AT_ONCE = 64


@dataclass(frozen=True, eq=False)
class JudgedBody:
    """A body of a run: with all its coordinates, the columns that the run moves in, and those of its error."""

    full: FullBody
    motion: RunColumns
    space: ErrorSpace


class StartError(NamedTuple):
    """True start less the run's of one body: positions and velocities `(dR, psi, q)`, (6 + n,) each."""

    position: Array
    velocity: Array


@dataclass(frozen=True, eq=False)
class ErrorHistory:
    """Error of one body at every step (t,): of its frame, and of its displacements in the columns Z.

    times : (t,)
    origin : (t, 3)         dR, global
    turn : (t, 3)           psi, body components
    coordinates : (t, k)    of columns Z: of the displacements that the run shows
    rms : (t,)              root mean square over the nodes, in space
    """

    body: JudgedBody
    times: Array
    rotation: Array
    origin: Array
    turn: Array
    coordinates: Array
    rms: Array

    @property
    def deformation(self) -> Array:
        """Columns Z (n, k)."""
        return self.body.space.vectors

    def at_nodes(self, row: int) -> Array:
        """Error of every node in space, (N, 3), at one step."""
        full, motion = self.body.full, self.body.motion
        q = motion.vectors[:, : motion.r] @ motion.coordinates[row, : motion.r]
        place = full.nodes + full.expand(q)
        seen = full.expand(self.deformation @ self.coordinates[row]) + np.cross(self.turn[row], place)
        return in_space(self.origin[[row]], self.rotation[[row]], seen[None])[0]


class _Prepared(NamedTuple):
    """What the march takes of one body."""

    gain: ElasticGain | None
    history: GainHistory | None


def error_histories(
    reduced: System,
    bodies: Mapping[str, JudgedBody],
    coefficients: Coefficients,
    steps: Solution,
    active: tuple[int, ...],
    start: Mapping[str, StartError],
) -> dict[str, ErrorHistory]:
    """Errors of the bodies of a run, driven by the run's own residual.

    Parameters
    ----------
    reduced : System        as it was simulated
    bodies : JudgedBody     by name; other bodies have no error of their own, but follow
    coefficients : Coefficients     of the run's integrator
    steps : Solution        of the run, at every step that it took
    active : constraint equations of the run, the redundant ones left out
    start : StartError      by name, of those bodies that do not start as they should

    Returns
    -------
    dict of ErrorHistory    at every step
    """
    columns = {
        name: body_of_columns(each.full.body, each.full.frame, each.space.vectors, each.full.damping)
        for name, each in bodies.items()
    }
    system = system_of_columns(reduced, columns)
    model = build_model(system, active)
    names = [placed.body.name for placed in system.bodies]
    places = dict(zip(names, model.slices, strict=True))
    motion = _motion(system, bodies, steps, active)
    prepared = [
        _prepared(each, columns[name].r, places[name].start + 6)
        for name, each in bodies.items()
        if not each.full.body.is_linear
    ]
    gains = tuple(each[0] for each in prepared)
    histories = tuple(each[1] for each in prepared)
    position, velocity = _start_vectors(bodies, places, model.n_velocities, start)
    model = jax.device_put(model)
    gains = jax.device_put(gains)
    first = jax.tree.map(lambda leaf: leaf[0], motion)
    begun = first_error(
        model, gains, first, tuple(_rows(own, slice(0, 1)) for own in histories), position, velocity
    )
    found = [np.asarray(begun.position)[None]]
    for block, number in _blocks(motion, histories, steps.times):
        begun, states = march_error(model, gains, coefficients, begun, block)
        begun = jax.tree.map(lambda leaf, n=number: leaf[n - 1], states)
        found.append(np.asarray(states.position)[:number])
    errors = np.concatenate(found)
    return {
        name: _history(each, steps, name, errors[:, places[name]]) for name, each in bodies.items()
    }


def _motion(
    system: System, bodies: Mapping[str, JudgedBody], steps: Solution, active: tuple[int, ...]
) -> SystemMotion:
    """The run in the coordinates of the system of columns, at every step."""
    names = [placed.body.name for placed in system.bodies]
    sizes = {placed.body.name: placed.body.n_coordinates for placed in system.bodies}

    def deformation(name: str, item: str) -> Array:
        if name not in bodies:
            return getattr(steps.bodies[name], f"coordinate_{item}" if item != "coordinates" else item)
        own = getattr(bodies[name].motion, item)
        return np.pad(own, ((0, 0), (0, sizes[name] - own.shape[1])))

    def joined(frame: Sequence[str], item: str) -> Array:
        parts = []
        for name in names:
            parts += [getattr(steps.bodies[name], each) for each in frame]
            parts.append(deformation(name, item))
        return np.hstack(parts)

    multipliers = np.hstack(
        [np.zeros((len(steps.times), 0))] + [steps.multipliers[joint.name] for joint in system.joints]
    )
    return SystemMotion(
        time=np.asarray(steps.times),
        configuration=Configuration(
            np.stack([steps.bodies[name].position for name in names], axis=1),
            np.stack([steps.bodies[name].rotation for name in names], axis=1),
            np.hstack([deformation(name, "coordinates") for name in names]),
        ),
        velocity=joined(("velocity", "angular_velocity"), "rates"),
        acceleration=joined(("acceleration", "angular_acceleration"), "accelerations"),
        multipliers=multipliers[:, list(active)],
    )


def _prepared(judged: JudgedBody, size: int, start: int) -> tuple[ElasticGain, GainHistory]:
    """What the deformation of a nonlinear body adds, along the run."""
    body, motion, Z = judged.full.body, judged.motion, judged.space.vectors
    k = Z.shape[1]
    force = force_polynomial(body, motion.vectors, Z)(motion.coordinates)
    tangents = tangent_history(body, motion.vectors, motion.coordinates, motion.rates, Z)
    damping = judged.full.damping
    time = 0.0 if damping is None else damping.retardation_time
    n_samples = len(tangents.material)
    # Room for more, as with the columns: runs whose tangents take nearly as many share one program.
    more = -n_samples % 8

    def padded(samples: Array) -> Array:
        return np.pad(samples, ((0, more), (0, size - k), (0, size - k)))

    def with_room(weights: Array) -> Array:
        return np.pad(weights, ((0, 0), (0, more)))

    return (
        ElasticGain(
            start,
            stiffness=padded(tangents.material + tangents.geometric),
            viscous=time * padded(tangents.material),
            # The stress D eps_dot turns with the strains too; of what strains gain by it, the symmetric half.
            viscous_stiffness=time * padded(tangents.geometric + tangents.material / 2),
        ),
        GainHistory(
            np.pad(force, ((0, 0), (0, size - k))),
            with_room(tangents.weights),
            with_room(tangents.weight_rates),
        ),
    )


def _start_vectors(
    bodies: Mapping[str, JudgedBody],
    places: Mapping[str, slice],
    n: int,
    start: Mapping[str, StartError],
) -> tuple[Array, Array]:
    position, velocity = np.zeros(n), np.zeros(n)
    for name, error in start.items():
        place, Z = places[name], None
        if name in bodies:
            body = bodies[name].full.body
            Z = bodies[name].space.vectors.T @ body.mass
        for vector, given in ((position, error.position), (velocity, error.velocity)):
            vector[place.start : place.start + 6] = given[:6]
            own = given[6:] if Z is None else Z @ given[6:]
            vector[place.start + 6 : place.start + 6 + len(own)] = own
    return position, velocity


def _rows(history: GainHistory, rows: slice) -> GainHistory:
    return GainHistory(*(each[rows] for each in history))


def _blocks(
    motion: SystemMotion, histories: tuple[GainHistory, ...], times: Array
) -> Iterator[tuple[StepOfRun, int]]:
    """Steps of the run, so many at once, the last of them repeated where there are fewer; and their number."""
    rotations = motion.configuration.rotations
    # (t, nb, 3): the turn of every frame in the step that ends at each time.
    turn = np.asarray(_turns_between(rotations[:-1], rotations[1:]))
    turned, turns = (np.asarray(each) for each in _turn_matrices(turn))
    h = np.diff(times)
    for start in range(0, len(h), STEPS_AT_ONCE):
        rows = np.arange(start, start + STEPS_AT_ONCE)
        number = int(np.sum(rows < len(h)))
        rows = np.minimum(rows, len(h) - 1)
        ends = jax.tree.map(lambda leaf, at=rows + 1: leaf[at], (motion, histories))
        yield StepOfRun(h[rows], ends[0], turned[rows], turns[rows], ends[1]), number


_turns_between = jax.jit(jax.vmap(jax.vmap(lambda a, b: rotation_log(a.T @ b))))
_turn_matrices = jax.jit(
    jax.vmap(jax.vmap(lambda turn: (rotation_exp(-turn), rotation_right_jacobian(turn))))
)


def _history(judged: JudgedBody, steps: Solution, name: str, errors: Array) -> ErrorHistory:
    full, motion, Z = judged.full, judged.motion, judged.space.vectors
    own = steps.bodies[name]
    coordinates = errors[:, 6 : 6 + Z.shape[1]].copy()
    # What follows the basis at rest is in no displacement of the run: all of it is error.
    coordinates[:, : motion.vectors.shape[1]] += motion.unseen
    shown = motion.vectors[:, : motion.r]
    squares = nodal_squares(full.nodes, _at_nodes(full, shown), _at_nodes(full, Z))
    origin, turn = errors[:, :3], errors[:, 3:6]
    rms = squares.rms(own.rotation, origin, turn, motion.coordinates[:, : motion.r], coordinates)
    return ErrorHistory(judged, steps.times, own.rotation, origin, turn, coordinates, rms)


def _at_nodes(full: FullBody, columns: Array) -> Array:
    """Displacements (N, 3, m) of columns (n, m)."""
    return np.moveaxis(full.expand(columns.T), 0, 2)
