"""The error of a reduced run at every step, from its residual: the error equation of a whole system."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import jax
import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray
from supple.body import in_space
from supple.equations.build_model import build_model
from supple.equations.configuration import Configuration, SystemMotion
from supple.equations.floating_solution import floating_solution
from supple.equations.machine_model import Model
from supple.error.equation.assessed_body import AssessedBody, MissedAtRest, StartError
from supple.error.equation.elastic_history import (
    PROVEN,
    force_polynomial,
    strain_rate_history,
    strain_rate_polynomial,
    tangent_history,
    unit_stiffness,
)
from supple.error.equation.elastic_polynomial import ElasticPolynomial
from supple.error.equation.error_model import system_of_columns
from supple.error.equation.few_matrices import few_matrices
from supple.error.equation.linearised_march import (
    ElasticGain,
    ErrorState,
    GainHistory,
    first_error,
    march_error,
)
from supple.error.equation.products_of_run import monomials, rate_monomials
from supple.error.equation.steps_of_run import blocks_of_run, rotation_vectors, rotations, standing
from supple.integrate import Coefficients, FloatingMotion, Solution, Statistics
from supple.machine import System

__all__ = ["ErrorEquation", "ErrorHistory", "TangentMotion"]


MORE_DIRECTIONS = 8
"""Largest number of directions of an error that become columns of the motion."""
SMALLEST_DIRECTION = 0.02
"""Ratio to the error below which its remainder outside the chosen directions is neglected."""
FEWEST_SAMPLES = 32
"""Smallest number of tangents along a run for which a march of the error is compiled."""


class _InColumns(NamedTuple):
    """Motion of a body in columns Z C of its error space: `chosen` C (k, s), coordinates and rates (t, s)."""

    chosen: FloatArray
    coordinates: FloatArray
    rates: FloatArray


TangentMotion = Mapping[str, _InColumns]
"""Motion of the bodies, by name."""


class _Point(NamedTuple):
    """Motion of the system in columns at every step, about which the integrator is linearised."""

    motion: SystemMotion
    bodies: Mapping[str, _InColumns]


@dataclass(frozen=True, eq=False)
class ErrorHistory:
    """Error of one body at every step (t,): of its frame, and of its displacements in columns Z.

    times : (t,)
    origin : (t, 3)         dR, global
    turn : (t, 3)           psi, body components
    coordinates : (t, k)    error of the displacements relative to the frame, in columns Z
    rms : (t,)              root mean square over the nodes, in space
    """

    body: AssessedBody
    times: FloatArray
    rotation: FloatArray
    origin: FloatArray
    turn: FloatArray
    coordinates: FloatArray
    rms: FloatArray

    @property
    def deformation(self) -> FloatArray:
        """Columns Z (n, k)."""
        return self.body.space.vectors

    def at_nodes(self, row: int) -> FloatArray:
        """Error of every node in space, (N, 3), at one step."""
        full, motion = self.body.full, self.body.motion
        place = full.nodes + full.expand(motion.vectors @ motion.coordinates[row])
        seen = full.expand(self.deformation @ self.coordinates[row]) + np.cross(self.turn[row], place)
        return in_space(self.origin[[row]], self.rotation[[row]], seen[None])[0]


@dataclass(frozen=True, eq=False)
class ErrorEquation:
    """The error equation of a run: its linearised equations, driven by its residual.

    reduced : System        as simulated
    bodies : AssessedBody   by name; other bodies have no basis error, but their motion changes as well
    coefficients : Coefficients     of the run's integrator
    steps : Solution        of the run, at every step
    active : indices of the constraint equations of the run that are not redundant
    start : StartError      by name, of bodies whose initial state in the run deviates from the true one
    proven : float          allowed error of the tangents along the run (`tangent_history`)
    fewest_samples : int    smallest number of tangents for which a march is compiled, a power of two
    """

    reduced: System
    bodies: Mapping[str, AssessedBody]
    coefficients: Coefficients
    steps: Solution
    active: tuple[int, ...]
    start: Mapping[str, StartError]
    proven: float = PROVEN
    fewest_samples: int = FEWEST_SAMPLES

    def first(self, tangents: TangentMotion | None = None) -> ErrorState:
        """True motion less the run's motion at every step, to first order; in all columns.

        tangents : the motion at which elastic tangents are taken; None: the run
        """
        return self._march(self.point, *self.start_vectors(), tangents)

    @cached_property
    def gains(self) -> dict[str, tuple[ElasticGain, GainHistory]]:
        """Effect of the deformation of nonlinear bodies along the run, by name."""
        return self._gained_along(self.point.bodies, None)

    def share_gains(self, gains: Mapping[str, tuple[ElasticGain, GainHistory]]) -> None:
        """Set the gains of this run to those computed for many runs together."""
        object.__setattr__(self, "gains", dict(gains))

    def stiffness(self, name: str, row: int) -> FloatArray:
        """Tangent `Z^T K_t Z` (k, k) of a nonlinear body at a step of the run."""
        k = self.bodies[name].space.size
        gain, history = self.gains[name]
        gained = np.tensordot(history.weights[row], gain.stiffness, axes=1)
        return self.bodies[name].columns.stiffness[:k, :k] + gained[:k, :k]

    def with_missed(self, missed: Mapping[str, MissedAtRest]) -> TangentMotion:
        """Deformation of the bodies plus the quasi-static motion outside the bases, for the tangents."""
        return self._corrected(self._at_rest(missed)).bodies

    def _at_rest(self, missed: Mapping[str, MissedAtRest]) -> ErrorState:
        """Missing motion at every step, linearly interpolated between the times at which it is known."""
        position = np.zeros_like(self.point.motion.velocity)
        for name, own in missed.items():
            assessed = self.bodies[name]
            known = assessed.space.vectors.T @ (assessed.full.body.mass @ own.deformation)
            start = self._places[name].start + 6
            for column, values in enumerate(known):
                position[:, start + column] = np.interp(self.steps.times, own.times, values)
        none = np.zeros_like(position)
        return ErrorState(position, none, none, none, np.zeros_like(self.point.motion.multipliers))

    # Where differences diverge, the result is not finite.
    @np.errstate(over="ignore", invalid="ignore")
    def again(self, found: ErrorState, tangents: TangentMotion | None = None) -> ErrorState:
        """The differences by the equation linearised about the corrected motion; tangents as for `first`.

        The leading directions of each body's error become columns of the motion, so that its forces remain
        polynomials of few coordinates.
        """
        point = self._corrected(found)
        here = self._differences(point.motion)
        position, velocity = (
            np.asarray(each[0]) - own[0] for each, own in zip(found[:2], here[:2], strict=True)
        )
        more = self._march(point, position, velocity, tangents)
        if not np.isfinite(more.position).all():
            return jax.tree.map(lambda leaf: np.full_like(leaf, np.nan), more)
        return ErrorState(*(own + each for own, each in zip(here, more, strict=True)))._replace(
            position=self._composed(here.position, more.position)
        )

    def histories(self, found: ErrorState) -> dict[str, ErrorHistory]:
        """The differences as an error history of each body."""
        return {name: self._history(name, found.position[:, self._places[name]]) for name in self.bodies}

    def corrected(self, found: ErrorState, rows: NDArray[np.intp]) -> tuple[System, Solution]:
        """The system in the columns of the error, and the estimate of its true motion at some steps."""
        motion = jax.tree.map(lambda leaf: leaf[rows], self._moved(found))
        system = self._system
        return system, floating_solution(system, self.model.slices, self.active, motion, Statistics())

    @cached_property
    def _system(self) -> System:
        return system_of_columns(self.reduced, {name: each.columns for name, each in self.bodies.items()})

    @cached_property
    def model(self) -> Model:
        """The equations in the columns of the error."""
        return build_model(self._system, self.active)

    @cached_property
    def _names(self) -> list[str]:
        return [placed.body.name for placed in self._system.bodies]

    @cached_property
    def _places(self) -> dict[str, slice]:
        return dict(zip(self._names, self.model.slices, strict=True))

    @cached_property
    def _coordinate_places(self) -> dict[str, slice]:
        return dict(zip(self._names, self.model.coordinate_slices, strict=True))

    @cached_property
    def point(self) -> _Point:
        """The run itself."""
        steps, names = self.steps, self._names
        motions = {name: steps.motion(name, FloatingMotion) for name in names}
        sizes = {name: place.stop - place.start for name, place in self._coordinate_places.items()}

        def deformation(name: str, of_run: str, of_columns: str) -> FloatArray:
            if name not in self.bodies:
                return getattr(motions[name], of_run)
            own = getattr(self.bodies[name].motion, of_columns)
            return np.pad(own, ((0, 0), (0, sizes[name] - own.shape[1])))

        def joined(linear: str, angular: str, *coordinates: str) -> FloatArray:
            parts = []
            for name in names:
                own = motions[name]
                parts += [getattr(own, linear), getattr(own, angular), deformation(name, *coordinates)]
            return np.hstack(parts)

        multipliers = np.hstack(
            [np.zeros((len(steps.times), 0))]
            + [steps.multipliers[joint.name] for joint in self._system.joints]
        )
        configuration = Configuration(
            np.stack([motions[name].position for name in names], axis=1),
            np.stack([motions[name].rotation for name in names], axis=1),
            np.hstack([deformation(name, "coordinates", "coordinates") for name in names]),
        )
        motion = SystemMotion(
            time=np.asarray(steps.times),
            configuration=configuration,
            velocity=joined("velocity", "angular_velocity", "coordinate_rates", "rates"),
            acceleration=joined(
                "acceleration", "angular_acceleration", "coordinate_accelerations", "accelerations"
            ),
            multipliers=multipliers[:, list(self.active)],
        )
        bodies = {
            name: _InColumns(
                np.eye(each.space.size, each.space.n_motion), each.motion.coordinates, each.motion.rates
            )
            for name, each in self.bodies.items()
        }
        return _Point(motion, bodies)

    def _corrected(self, found: ErrorState) -> _Point:
        """The run plus the estimated error in its leading directions."""
        position, velocity, acceleration = (
            np.array(each) for each in (found.position, found.velocity, found.acceleration)
        )
        chosen = {}
        for name, each in self.bodies.items():
            place = self._places[name]
            own = slice(place.start + 6, place.start + 6 + each.space.size)
            Y = chosen[name] = _with_directions(position[:, own], each.space.n_motion)
            for vector in (position, velocity, acceleration):
                vector[:, own] = vector[:, own] @ Y @ Y.T
                vector[:, own.stop : place.stop] = 0.0
        motion = self._moved(ErrorState(position, velocity, acceleration, acceleration, found.multipliers))
        coordinates = motion.configuration.coordinates
        bodies = {}
        for name, Y in chosen.items():
            own = self._coordinate_places[name]
            place = slice(own.start, own.start + len(Y))
            rates = slice(self._places[name].start + 6, self._places[name].start + 6 + len(Y))
            bodies[name] = _InColumns(Y, coordinates[:, place] @ Y, motion.velocity[:, rates] @ Y)
        return _Point(motion, bodies)

    def _moved(self, found: ErrorState) -> SystemMotion:
        """The run with differences added, as a motion of the system."""
        run = self.point.motion
        frames = np.asarray(found.position)[:, self.model.frames.index]
        coordinates = run.configuration.coordinates.copy()
        for name in self._names:
            place = self._places[name]
            coordinates[:, self._coordinate_places[name]] += found.position[:, place.start + 6 : place.stop]
        return SystemMotion(
            run.time,
            Configuration(
                run.configuration.origins + frames[:, :, :3],
                run.configuration.rotations @ rotations(frames[:, :, 3:]),
                coordinates,
            ),
            run.velocity + found.velocity,
            run.acceleration + found.acceleration,
            run.multipliers + found.multipliers,
        )

    def _differences(self, motion: SystemMotion) -> ErrorState:
        """Corrected motion less the run."""
        run = self.point.motion
        position = np.zeros_like(run.velocity)
        turned = rotation_vectors(
            run.configuration.rotations.swapaxes(-1, -2) @ motion.configuration.rotations
        )
        moved = motion.configuration.origins - run.configuration.origins
        for index, name in enumerate(self._names):
            place, own = self._places[name], self._coordinate_places[name]
            position[:, place.start : place.start + 3] = moved[:, index]
            position[:, place.start + 3 : place.start + 6] = turned[:, index]
            position[:, place.start + 6 : place.stop] = (
                motion.configuration.coordinates[:, own] - run.configuration.coordinates[:, own]
            )
        acceleration = motion.acceleration - run.acceleration
        return ErrorState(
            position,
            motion.velocity - run.velocity,
            acceleration,
            acceleration,
            motion.multipliers - run.multipliers,
        )

    def _composed(self, first: FloatArray, more: FloatArray) -> FloatArray:
        """Composition of two successive differences of positions."""
        composed = first + more
        rows = self.model.frames.index[:, 3:]
        composed[:, rows] = rotation_vectors(rotations(first[:, rows]) @ rotations(more[:, rows]))
        return composed

    def start_vectors(self) -> tuple[FloatArray, FloatArray]:
        """Differences of positions and velocities at the start."""
        position, velocity = np.zeros(self.model.n_velocities), np.zeros(self.model.n_velocities)
        for name, error in self.start.items():
            place = self._places[name]
            for vector, given in ((position, error.position), (velocity, error.velocity)):
                vector[place.start : place.start + 6] = given[:6]
                own = given[6:]
                if name in self.bodies:
                    own = self.bodies[name].space.vectors.T @ (self.bodies[name].full.body.mass @ own)
                vector[place.start + 6 : place.start + 6 + len(own)] = own
        return position, velocity

    def _march(
        self,
        point: _Point,
        position: FloatArray,
        velocity: FloatArray,
        tangents: TangentMotion | None = None,
    ) -> ErrorState:
        """The linearised march about a motion, from start differences of positions and velocities.

        tangents : motion at which the bodies' tangents are taken; None: the same motion
        """
        at_run = point is self.point and tangents is None
        gained = (self.gains if at_run else self._gained_along(point.bodies, tangents)).values()
        gains, histories = tuple(each[0] for each in gained), tuple(each[1] for each in gained)
        model, gains = jax.device_put((self.model, gains))
        state = first_error(
            model, gains, self.coefficients, standing(point.motion, histories), position, velocity
        )
        found = [jax.tree.map(lambda leaf: np.asarray(leaf)[None], state)]
        for block, number in blocks_of_run(point.motion, histories):
            states = jax.device_get(march_error(model, gains, self.coefficients, state, block)[1])
            state = jax.tree.map(lambda leaf, last=number - 1: leaf[last], states)
            found.append(jax.tree.map(lambda leaf, n=number: leaf[:n], states))
        return jax.tree.map(lambda *leaves: np.concatenate(leaves), *found)

    def _gained_along(
        self, motion: TangentMotion, tangents: TangentMotion | None
    ) -> dict[str, tuple[ElasticGain, GainHistory]]:
        """Gains of the nonlinear bodies; tangents as for `_march`."""
        return {
            name: self.gained(name, own, own if tangents is None else tangents[name])
            for name, own in motion.items()
            if not self.bodies[name].full.body.is_linear
        }

    def gained(
        self, name: str, motion: _InColumns, tangent_motion: _InColumns | None = None
    ) -> tuple[ElasticGain, GainHistory]:
        """Effect of a nonlinear body's deformation: forces along a motion, tangents along another."""
        assessed, start = self.bodies[name], self._places[name].start + 6
        k, size = assessed.space.size, self._places[name].stop - start
        if assessed.polynomial is None:
            own = _from_instants(assessed, motion, tangent_motion or motion, self.proven)
        else:
            own = _from_polynomial(assessed, assessed.polynomial, motion, self.proven)

        def padded(samples: FloatArray) -> FloatArray:
            return np.pad(samples, ((0, self._more(len(samples))), (0, size - k), (0, size - k)))

        def filled(weights: FloatArray) -> FloatArray:
            return np.pad(weights, ((0, 0), (0, self._more(weights.shape[1]))))

        gain = ElasticGain(
            start,
            stiffness=padded(own.stiffness),
            viscous=padded(own.viscous),
            viscous_stiffness=padded(own.viscous_stiffness),
        )
        return gain, GainHistory(
            np.pad(own.force, ((0, 0), (0, size - k))),
            np.pad(own.viscous_force, ((0, 0), (0, size - k))),
            filled(own.weights),
            filled(own.rate_weights),
            np.full(len(own.force), assessed.retardation_time),
        )

    def _more(self, number: int) -> int:
        """Number of samples to add for a total of `fewest_samples` times 1, 2, 4 ..: rounds share a program.

        A further sample costs a product of two small matrices per block; a further program costs seconds.
        """
        fewest = self.fewest_samples
        return (fewest << max(0, (number - 1) // fewest).bit_length()) - number if number else 0

    def _history(self, name: str, errors: FloatArray) -> ErrorHistory:
        assessed, own = self.bodies[name], self.steps.motion(name, FloatingMotion)
        motion = assessed.motion
        coordinates = errors[:, 6 : 6 + assessed.space.size]
        origin = errors[:, :3] - np.einsum("tij,tj->ti", own.rotation, motion.rigid[:, :3])
        turn = errors[:, 3:6] - motion.rigid[:, 3:]
        rms = assessed.squares.rms(own.rotation, origin, turn, motion.coordinates, coordinates)
        return ErrorHistory(assessed, self.steps.times, own.rotation, origin, turn, coordinates, rms)


class _Elasticity(NamedTuple):
    """Effect of a body's deformation along a motion: fields as in `ElasticGain` and `GainHistory`."""

    force: FloatArray
    viscous_force: FloatArray
    stiffness: FloatArray
    viscous: FloatArray
    viscous_stiffness: FloatArray
    weights: FloatArray
    rate_weights: FloatArray


def _from_instants(
    assessed: AssessedBody, motion: _InColumns, bent: _InColumns, proven: float
) -> _Elasticity:
    """Forces from one pass over the elements, tangents from a few sample times of another motion."""
    body, Z = assessed.full.body, assessed.space.vectors
    columns = Z @ motion.chosen
    works = body.assembly.works(columns, Z)
    force = force_polynomial(works)(motion.coordinates)
    time = assessed.retardation_time
    tangents = tangent_history(body, Z @ bent.chosen, bent.coordinates, Z, material=time > 0, proven=proven)
    viscous_force = np.zeros_like(force)
    if time:
        viscous_force = strain_rate_polynomial(works)(motion.coordinates, motion.rates)
    rates = strain_rate_history(body, columns, motion.coordinates, motion.rates, Z, time, proven=proven)
    return _Elasticity(
        force,
        viscous_force,
        tangents.whole,
        tangents.material,
        rates.samples,
        tangents.weights,
        rates.weights,
    )


def _from_polynomial(
    assessed: AssessedBody, polynomial: ElasticPolynomial, motion: _InColumns, proven: float
) -> _Elasticity:
    """Exact forces in the columns of the run, and tangents from few combinations of their polynomial."""
    k, time = assessed.space.size, assessed.retardation_time
    force, (whole, material) = polynomial.force(motion.coordinates), polynomial.tangents
    unit = unit_stiffness(assessed.columns.stiffness[:k, :k])
    weights = monomials(motion.coordinates)
    none = np.zeros((0, k, k))
    if not time:
        of_strains = few_matrices([whole], weights, unit, proven)
        without = np.zeros((len(force), 0))
        return _Elasticity(
            force, np.zeros_like(force), *of_strains.sets, none, none, of_strains.weights, without
        )
    of_strains = few_matrices([whole, material], weights, unit, proven)
    rates = rate_monomials(motion.coordinates, motion.rates)
    of_rates = few_matrices([polynomial.rate_tangents], rates, unit, proven / time)
    return _Elasticity(
        force,
        polynomial.strain_rate_force(motion.coordinates, motion.rates),
        *of_strains.sets,
        *of_rates.sets,
        of_strains.weights,
        of_rates.weights,
    )


def _with_directions(errors: FloatArray, n_motion: int) -> FloatArray:
    """Columns (k, s): the first ones, and the leading directions of the errors (t, k) outside them."""
    outside = errors[:, n_motion:]
    _, sizes, rows = np.linalg.svd(outside, full_matrices=False)
    left = np.sqrt(np.cumsum(sizes[::-1] ** 2)[::-1])
    number = min(int(np.sum(left > SMALLEST_DIRECTION * np.linalg.norm(errors))), MORE_DIRECTIONS)
    k = errors.shape[1]
    chosen = np.zeros((k, n_motion + number))
    chosen[:n_motion, :n_motion] = np.eye(n_motion)
    chosen[n_motion:, n_motion:] = rows[:number].T
    return chosen
