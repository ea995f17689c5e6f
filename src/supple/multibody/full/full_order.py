"""Full-order simulation: bodies with all their finite-element freedoms, by sparse bordered Newton steps.

The interior of the linear system of a step is each full body's own sparse matrix `S`, factored alone; the
border, a few dozen unknowns, holds the frames, the reduced and rigid bodies, the joint multipliers and, per
full body, the six multipliers `mu` of its frame conditions `D q = 0`. What joints and forces see of a full
body is the motion of its interfaces, `w = B q`, which the compiled equations treat as coordinates of a
massless body (`build_model`). Eliminating the interior,

    x = - S^-1 ( r + B^T c + F y + D^T dmu ),      w = B x,      D x = - D q / k,

with `c` the generalised interface forces and `y` the frame's accelerations, leaves a small dense system.
A Python loop over time steps is unavoidable here: each iteration is one sparse factorisation.
"""

from __future__ import annotations

import time as clock
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from scipy.sparse import csr_array

from supple.algebra.rotation import rotation_exp
from supple.body.full_body import FullBody
from supple.errors import ConvergenceError, ModelError
from supple.integrate import (
    Solution,
    Statistics,
    StepControl,
    StepRule,
    TimeIntegrator,
    Tolerances,
    concatenate,
)
from supple.machine import DeadForce
from supple.machine.system import System
from supple.multibody.compiled.initial_state import (
    check_joints_closed,
    independent_constraints,
    joint_terms,
    placed_velocity,
)
from supple.multibody.compiled.time_step import next_step, position_rounding
from supple.multibody.equations.balance import (
    Balance,
    Configuration,
    Linearization,
    Motion,
    balance,
    constraint_rows,
    tangent,
)
from supple.multibody.equations.model import Model, build_model, is_nodal_load_on_full_body
from supple.multibody.full.full_interior import Elimination, FullInterior, InteriorState, prepare_interior
from supple.multibody.run_parts import (
    CHUNKS,
    Checkpoint,
    Progress,
    Recorder,
    body_motions,
    failure_message,
    joint_forces,
    last_instant,
)

__all__ = ["FullOrderSystem", "FullState", "simulate_full_order"]


class FullState(NamedTuple):
    """State of the system; velocities and accelerations per body are `(frame (6,), coordinates)`, joined."""

    time: float
    configuration: Configuration
    velocity: np.ndarray
    acceleration: np.ndarray
    auxiliary: np.ndarray
    multipliers: np.ndarray
    frame_multipliers: tuple[np.ndarray, ...]


class _Border(NamedTuple):
    """The compiled part of one evaluation: joints, forces, reduced and rigid bodies."""

    terms: Balance
    gap: jax.Array
    matrix: jax.Array
    rows: jax.Array
    rows_by_increment: jax.Array


_border_terms = jax.jit(balance)


@jax.jit
def _border_matrices(
    model: Model,
    motion: Motion,
    linearization: Linearization,
    increments: jax.Array,
    velocity: jax.Array,
    position: jax.Array,
) -> tuple[jax.Array, jax.Array, jax.Array]:
    return (
        tangent(model, motion, linearization, increments, velocity, position),
        constraint_rows(model, linearization.joints),
        constraint_rows(model, linearization.joints, increments),
    )


class _Evaluation(NamedTuple):
    """Residuals at one iterate."""

    border_motion: Motion
    border: Balance
    gap: np.ndarray
    interior_states: tuple[InteriorState, ...]
    interior_residuals: tuple[np.ndarray, ...]
    """(6 + n,) of each full body, its interface forces included in the last n."""
    frame_gaps: tuple[np.ndarray, ...]
    relative_residual: np.ndarray


class FullOrderSystem:
    """A system with at least one full body, ready for stepping. Holds no state of the motion.

    active : the constraint equations to keep, redundant ones left out; all of them until `start` finds out
    """

    def __init__(self, system: System, active: tuple[int, ...] | None = None) -> None:
        self.system = system
        sizes = [6 + placed.body.n_coordinates for placed in system.bodies]
        ends = np.cumsum([0, *sizes])
        self.slices = tuple(slice(int(a), int(b)) for a, b in pairwise(ends))
        self.n = int(ends[-1])
        self.interiors = tuple(
            prepare_interior(index, placed.body, self._nodal_loads(placed.body))
            for index, placed in enumerate(system.bodies)
            if isinstance(placed.body, FullBody)
        )
        self.model = build_model(system, active)
        self.interior_of = {interior.index: interior for interior in self.interiors}

    def _nodal_loads(self, full: FullBody) -> tuple[DeadForce, ...]:
        return tuple(
            load
            for load in self.system.loads
            if isinstance(load, DeadForce)
            and load.body == full.name
            and is_nodal_load_on_full_body(self.system, load)
        )

    def to_border(self, vector: np.ndarray) -> np.ndarray:
        """Velocities (or the like) of the compiled part: interface motions instead of nodal freedoms."""
        parts = []
        for index, part in enumerate(self.slices):
            own = vector[part]
            interior = self.interior_of.get(index)
            parts.append(
                own if interior is None else np.concatenate([own[:6], interior.interface_rows @ own[6:]])
            )
        return np.concatenate(parts)

    def border_configuration(self, configuration: Configuration) -> Configuration:
        """Configuration of the compiled part."""
        coordinates = tuple(
            np.asarray(own if index not in self.interior_of else self.interior_of[index].interface_rows @ own)
            for index, own in enumerate(configuration.coordinates)
        )
        return Configuration(
            np.asarray(configuration.origins), np.asarray(configuration.rotations), coordinates
        )

    def advance(self, configuration: Configuration, increment: np.ndarray) -> Configuration:
        """The configuration moved by an increment (n,)."""
        steps = [increment[part] for part in self.slices]
        turns = [np.asarray(_rotation_exp(step[3:6])) for step in steps]
        return Configuration(
            origins=configuration.origins + np.array([step[:3] for step in steps]),
            rotations=np.array([a @ b for a, b in zip(configuration.rotations, turns, strict=True)]),
            coordinates=tuple(q + s[6:] for q, s in zip(configuration.coordinates, steps, strict=True)),
        )

    def evaluate(self, state: FullState, position: float) -> _Evaluation:
        """All residuals at a state; `position` scales the constraints' relative_residual."""
        configuration = self.border_configuration(state.configuration)
        motion = Motion(
            np.float64(state.time),
            configuration,
            self.to_border(state.velocity),
            self.to_border(state.acceleration),
            np.asarray(state.multipliers),
        )
        terms = jax.tree.map(np.asarray, _border_terms(self.model, motion))
        states, residuals, gaps = [], [], []
        # Squared norms by term (inertia, internal, applied, joint) and kind (force, moment, deformation).
        squares = np.zeros((4, 3))
        unbalanced = np.zeros(3)
        own_terms = (terms.inertia, terms.internal, terms.applied, terms.joint)
        for index, part in enumerate(self.model.slices):
            interior = self.interior_of.get(index)
            rows = [term[part] for term in own_terms]
            if interior is not None:
                inner = self._interior_state(interior, state)
                forces = interior.forces(inner)
                own = (forces.inertia, forces.internal, forces.applied, forces.joint)
                rows = [
                    np.concatenate([row[:6], interior.interface_rows.T @ row[6:]]) + mine
                    for row, mine in zip(rows, own, strict=True)
                ]
                states.append(inner)
                residuals.append(np.sum(rows, axis=0))
                gaps.append(forces.frame_gap)
            squares += np.array([_squares_by_kind(row) for row in rows])
            unbalanced += _squares_by_kind(np.sum(rows, axis=0))
        scale = np.sqrt(squares.max(axis=0))
        forces_imbalance = np.sqrt(unbalanced) / np.where(scale > 0, scale, 1.0)
        gap = terms.gap
        constraint = self._constraint_imbalance(state, np.concatenate([gap, *gaps]), position)
        return _Evaluation(
            motion,
            terms,
            gap,
            tuple(states),
            tuple(residuals),
            tuple(gaps),
            np.append(forces_imbalance, constraint),
        )

    def _constraint_imbalance(self, state: FullState, gap: np.ndarray, position: float) -> float:
        largest = float(np.max(abs(gap), initial=0.0))
        floor = self.model.length * float(position_rounding(self.model.length, state.configuration.origins))
        if largest <= floor or position == 0:
            return 0.0
        accelerations = self.model.length * np.max(abs(state.acceleration) / self.position_scale)
        return largest / position / (accelerations + floor / position)

    @cached_property
    def position_scale(self) -> np.ndarray:
        """What counts as a large change of each freedom, (n,)."""
        length = self.model.length
        parts = []
        for index, part in enumerate(self.slices):
            r = part.stop - part.start - 6
            scale = length if index in self.interior_of else self.model.bodies[index].coordinate_scale
            parts += [np.full(3, length), np.ones(3), np.full(r, scale)]
        return np.concatenate(parts)

    def _interior_state(self, interior: FullInterior, state: FullState) -> InteriorState:
        part = self.slices[interior.index]
        velocity, acceleration = state.velocity[part], state.acceleration[part]
        return InteriorState(
            rotation=state.configuration.rotations[interior.index],
            coordinates=state.configuration.coordinates[interior.index],
            rates=velocity[6:],
            accelerations=acceleration[6:],
            spin=velocity[3:6],
            spin_rate=acceleration[3:6],
            acceleration=acceleration[:3] - self.system.gravity,
            frame_multipliers=state.frame_multipliers[self.interiors.index(interior)],
            time=state.time,
        )

    def correction(
        self,
        evaluation: _Evaluation,
        targets: tuple[np.ndarray, tuple[np.ndarray, ...]],
        increments: np.ndarray,
        velocity: float,
        position: float,
    ) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, ...]]:
        """Solve the bordered system for the change of accelerations, multipliers and frame multipliers.

        targets : what the constraint rows and the frame conditions of each full body must become
        """
        model = self.model
        motion = evaluation.border_motion
        matrix, rows, rows_by_increment = (
            np.asarray(x)
            for x in _border_matrices(
                model,
                motion,
                evaluation.border.linearization,
                self.to_border(increments),
                np.float64(velocity),
                np.float64(position),
            )
        )
        joint_targets, frame_targets = targets
        m, n_border = len(joint_targets), model.n_velocities
        n_small = n_border + m + 6 * len(self.interiors)
        small, right = np.zeros((n_small, n_small)), np.zeros(n_small)
        multipliers = slice(n_border, n_border + m)
        scale = model.mass
        small[:n_border, :n_border] = matrix
        small[:n_border, multipliers] = scale * rows.T
        small[multipliers, :n_border] = scale * rows_by_increment
        right[:n_border] = -evaluation.border.residual
        right[multipliers] = scale * joint_targets
        eliminations: list[Elimination] = []
        for number, interior in enumerate(self.interiors):
            part = self.slices[interior.index]
            residual = evaluation.interior_residuals[number]
            out = interior.eliminate(
                evaluation.interior_states[number],
                residual[6:],
                increments[part][3:6],
                velocity,
                position,
            )
            eliminations.append(out)
            self._condense(interior, number, out, residual[:6], frame_targets[number], small, right, m)
        solution = np.linalg.solve(small, right)
        changes = []
        for index, part in enumerate(model.slices):
            interior = self.interior_of.get(index)
            own = solution[part]
            if interior is not None:
                number = self.interiors.index(interior)
                out = eliminations[number]
                mu = solution[n_border + m + 6 * number : n_border + m + 6 * number + 6]
                interface = (matrix[part] @ solution[:n_border])[6:] + (rows.T[part] @ solution[multipliers])[
                    6:
                ] * scale
                nodal = (
                    out.particular
                    + out.by_interface @ interface
                    + out.by_frame @ own[:6]
                    + out.by_multiplier @ mu
                )
                own = np.concatenate([own[:6], nodal])
            changes.append(own)
        mus = solution[n_border + m :].reshape(-1, 6)
        return np.concatenate(changes), scale * solution[multipliers], tuple(mus)

    def _condense(
        self,
        interior: FullInterior,
        number: int,
        out: Elimination,
        frame_residual: np.ndarray,
        frame_target: np.ndarray,
        small: np.ndarray,
        right: np.ndarray,
        m: int,
    ) -> None:
        """Replace the rows of one full body in the small system by those of its eliminated interior."""
        part = self.model.slices[interior.index]
        frame = slice(part.start, part.start + 6)
        interface = slice(part.start + 6, part.stop)
        n_border = self.model.n_velocities
        mu = slice(n_border + m + 6 * number, n_border + m + 6 * number + 6)
        forces = small[interface].copy()  # generalised interface forces per unknown of the small system

        def through(left: np.ndarray | csr_array) -> tuple[np.ndarray, np.ndarray]:
            """Matrix and particular part of `left @ x` in terms of the small system's unknowns."""
            total = (left @ out.by_interface) @ forces
            total[:, frame] += left @ out.by_frame
            total[:, mu] += left @ out.by_multiplier
            return total, left @ out.particular

        seen, seen_particular = through(out.frame_rows)
        small[frame] += seen
        small[frame, frame] += out.frame_corner
        right[frame] = -frame_residual - seen_particular
        moved, moved_particular = through(interior.interface_rows)
        small[interface] = moved
        small[interface, interface] -= np.eye(interface.stop - interface.start)
        right[interface] = -moved_particular
        held, held_particular = through(interior.frame_rows)
        small[mu] += held
        right[mu] = frame_target - held_particular

    def start(self, time: float) -> FullState:
        """Consistent initial state: velocities on the joints and in the frames, first accelerations."""
        system = self.system
        configuration = Configuration(
            origins=np.array([placed.position for placed in system.bodies]),
            rotations=np.array([placed.rotation for placed in system.bodies]),
            coordinates=tuple(np.array(placed.coordinates) for placed in system.bodies),
        )
        for interior in self.interiors:
            held = interior.frame_rows @ configuration.coordinates[interior.index]
            if np.max(abs(held)) > 1e-9 * self.model.length:
                raise ModelError(
                    f"the initial deformation of body '{interior.full.name}' moves its frame by "
                    f"{np.max(abs(held)):.3g}: subtract the rigid motion (frame_projector) first"
                )
        now = jnp.asarray(float(time))
        velocity = placed_velocity(system)
        rest = np.zeros(self.n)
        border = self.border_configuration(configuration)
        terms = joint_terms(self.model, now, border, jnp.asarray(self.to_border(velocity)))
        check_joints_closed(system, self.model, np.asarray(terms.gap))
        # Judged by the motions of the interfaces: a massless stand-in has no mass to measure them with.
        kept = independent_constraints(system, np.asarray(terms.jacobian), np.eye(self.model.n_velocities))
        self.model = build_model(system, active=kept)
        state = FullState(
            float(time),
            configuration,
            velocity,
            rest,
            rest,
            np.zeros(len(kept)),
            tuple(np.zeros(6) for _ in self.interiors),
        )
        # Velocities: the least change in the mass norm that closes the rates of joints and frames.
        drift = np.asarray(joint_terms(self.model, now, border, jnp.asarray(self.to_border(velocity))).rate)
        frame_drift = tuple(i.frame_rows @ velocity[self.slices[i.index]][6:] for i in self.interiors)
        still = self.evaluate(state._replace(velocity=rest), 0.0)
        balanced = still._replace(
            border=_zero_residual(still.border),
            interior_residuals=tuple(np.zeros_like(r) for r in still.interior_residuals),
        )
        change, _, _ = self.correction(balanced, (-drift, tuple(-d for d in frame_drift)), rest, 0.0, 0.0)
        state = state._replace(velocity=velocity + change)
        # Accelerations and multipliers, with the second derivative of the constraints at constant velocity.
        bending = np.asarray(
            joint_terms(self.model, now, border, jnp.asarray(self.to_border(state.velocity))).bending
        )
        evaluation = self.evaluate(state, 0.0)
        none = tuple(np.zeros(6) for _ in self.interiors)
        acceleration, multipliers, frame_multipliers = self.correction(
            evaluation, (-bending, none), rest, 0.0, 0.0
        )
        return state._replace(
            acceleration=acceleration,
            auxiliary=acceleration,
            multipliers=multipliers,
            frame_multipliers=frame_multipliers,
        )

    def step(
        self, start: FullState, h: float, method: TimeIntegrator, tolerances: Tolerances
    ) -> tuple[FullState, np.ndarray, int, bool]:
        """One time step: the new state, its relative_residual, the iterations, and whether it converged."""
        rule = StepRule(method.coefficients, h)
        acceleration, multipliers = start.acceleration, start.multipliers
        frame_multipliers = start.frame_multipliers
        moved = np.inf
        iteration = 0
        while True:
            auxiliary = rule.auxiliary(acceleration, start.acceleration, start.auxiliary)
            increments = rule.increment(start.velocity, start.auxiliary, auxiliary)
            state = FullState(
                start.time + h,
                self.advance(start.configuration, increments),
                rule.new_velocity(start.velocity, start.auxiliary, auxiliary),
                acceleration,
                auxiliary,
                multipliers,
                frame_multipliers,
            )
            evaluation = self.evaluate(state, rule.position)
            relative_residual = evaluation.relative_residual
            rounding = position_rounding(self.model.length, state.configuration.origins)
            settled = moved <= rounding and relative_residual[3] <= 1e-6
            if np.all(relative_residual <= tolerances.residual) or settled:
                return state, relative_residual, iteration, True
            if not np.isfinite(relative_residual).all() or iteration == tolerances.max_iterations:
                return state, relative_residual, iteration, False
            targets = (
                -evaluation.gap / rule.position,
                tuple(-gap / rule.position for gap in evaluation.frame_gaps),
            )
            change, joint_change, frame_change = self.correction(
                evaluation, targets, increments, rule.velocity, rule.position
            )
            acceleration = acceleration + change
            multipliers = multipliers + joint_change
            frame_multipliers = tuple(
                old + new for old, new in zip(frame_multipliers, frame_change, strict=True)
            )
            moved = rule.position * np.max(abs(change) / self.position_scale)
            iteration += 1

    def local_error(self, start: FullState, end: FullState, h: float, method: TimeIntegrator) -> float:
        """Leading local error of the step, relative to the scale of each freedom."""
        error = StepRule(method.coefficients, h).position_error(start.auxiliary, end.auxiliary)
        return float(np.max(abs(error) / self.position_scale))


_rotation_exp = jax.jit(rotation_exp)


def _zero_residual(terms: Balance) -> Balance:
    nothing = np.zeros_like(terms.inertia)
    return Balance(nothing, nothing, nothing, nothing, terms.gap, terms.linearization)


def _squares_by_kind(row: np.ndarray) -> np.ndarray:
    return np.array([row[:3] @ row[:3], row[3:6] @ row[3:6], row[6:] @ row[6:]])


def simulate_full_order(
    system: System,
    times: np.ndarray,
    step: StepControl,
    method: TimeIntegrator,
    tolerances: Tolerances,
    resume: Checkpoint | None,
    progress: Progress,
    record: Recorder,
) -> Solution:
    """`simulate` for systems with full bodies; see there."""
    began = clock.perf_counter()
    prepared = FullOrderSystem(system)
    state = prepared.start(float(times[0]))
    parts: list[Solution] = []
    if resume is None:
        ready = clock.perf_counter()
        first = _as_solution(prepared, [state], Statistics(compile_seconds=ready - began))
        parts.append(first)
        record(first)
        times = times[1:]
    else:
        state = _resumed(prepared, state, resume.solution)
        times = times[times > resume.solution.times[-1] * (1 + 1e-12)]
    size = max(1, int(np.ceil(len(times) / CHUNKS)))
    march = _March(step.first)
    for begin in range(0, len(times), size):
        states: list[FullState] = []
        mark, before = clock.perf_counter(), march
        failure = None
        for end in times[begin : begin + size]:
            state, march, failure = _to_output(prepared, state, float(end), march, step, method, tolerances)
            if failure is not None:
                break
            states.append(state)
        statistics = Statistics(
            steps=march.steps - before.steps,
            iterations=march.iterations - before.iterations,
            rejected_steps=march.rejected_steps - before.rejected_steps,
            seconds=clock.perf_counter() - mark,
        )
        if states:
            parts.append(_as_solution(prepared, states, statistics))
            record(parts[-1])
        if failure is not None:
            raise ConvergenceError(failure_message(state.time, failure))
        progress(min(begin + size, len(times)) / len(times))
    return concatenate(parts)


class _March(NamedTuple):
    """Step size to try next, and the counts so far."""

    h: float
    steps: int = 0
    iterations: int = 0
    rejected_steps: int = 0


def _to_output(
    prepared: FullOrderSystem,
    state: FullState,
    end: float,
    march: _March,
    control: StepControl,
    method: TimeIntegrator,
    tolerances: Tolerances,
) -> tuple[FullState, _March, np.ndarray | None]:
    """Steps up to an output time; the relative_residual instead of None when the smallest step fails."""
    while state.time < end:
        remaining = end - state.time
        # A whole number of equal steps to the output time; 1e-9 forgives the rounding of their quotient.
        h = remaining / max(np.ceil(remaining / march.h * (1 - 1e-9)), 1.0)
        new, relative_residual, iterations, converged = prepared.step(state, h, method, tolerances)
        error = prepared.local_error(state, new, h, method) if converged else np.inf
        proposed = next_step(h, march.h, error, control.tolerance, control.largest) if converged else h / 2
        if converged and error <= control.tolerance:
            if h >= remaining * (1 - 1e-9):
                new = new._replace(time=end)
            state = new
            march = _March(
                float(proposed), march.steps + 1, march.iterations + iterations, march.rejected_steps
            )
        else:
            march = _March(
                float(proposed), march.steps, march.iterations + iterations, march.rejected_steps + 1
            )
            if march.h < control.smallest:
                return state, march, relative_residual
    return state, march, None


def _as_solution(prepared: FullOrderSystem, states: list[FullState], statistics: Statistics) -> Solution:
    configuration = Configuration(
        origins=np.array([s.configuration.origins for s in states]),
        rotations=np.array([s.configuration.rotations for s in states]),
        coordinates=tuple(
            np.array([s.configuration.coordinates[index] for s in states])
            for index in range(len(prepared.slices))
        ),
    )
    return Solution(
        times=np.array([s.time for s in states]),
        bodies=body_motions(
            prepared.system,
            prepared.slices,
            configuration,
            np.array([s.velocity for s in states]),
            np.array([s.acceleration for s in states]),
        ),
        joint_forces=joint_forces(prepared.system, prepared.model, np.array([s.multipliers for s in states])),
        statistics=statistics,
    )


def _resumed(prepared: FullOrderSystem, start: FullState, done: Solution) -> FullState:
    """State at the end of a recorded part; the frame multipliers are found again by the first iteration."""
    last = last_instant(prepared.system, prepared.model, done)
    return start._replace(**last._asdict(), auxiliary=last.acceleration)
