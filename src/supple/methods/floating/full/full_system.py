"""Full-order equations: bodies with all finite-element freedoms, solved by sparse bordered Newton steps.

The interior of the linear system of a step is the sparse matrix `S` of each full body, factored by itself.
The border has a few dozen unknowns: those of the frames, the reduced and rigid bodies, the joint multipliers
and, per full body, the six multipliers `mu` of its frame conditions `D q = 0`. Joints and forces depend on
the motion of a full body's interfaces, `w = B q`. The compiled equations treat these motions as coordinates
of a massless body (`build_model`). Eliminating the interior,

    x = - S^-1 ( r + B^T c + F y + D^T dmu ),      w = B x,      D x = - D q / k,

with `c` the generalised interface forces, `y` the frame's accelerations, `dmu` the changes of `mu`, and `k`
the step's factor by position, leaves a small dense system. The loop over time steps is in Python, because
each iteration solves with sparse factors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Self

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.rotation import rotation_exp, rotation_right_jacobian
from supple.body import FullBody
from supple.equations.balance import Balance, Linearization, balance, tangent
from supple.equations.build_model import is_on_full_nodes, station_model
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import Configuration, ControlStep, SystemMotion
from supple.equations.control_start import control_after, fresh_control
from supple.equations.inertia import mass_matrix
from supple.equations.joint_force import constraint_rows
from supple.equations.machine_model import Model, adjacent_slices
from supple.equations.starting_machine import JointTerms, converged_reactions, joint_terms
from supple.equations.station_body import BodyState, MachineWithStations, Stations
from supple.equations.step_size import position_rounding
from supple.errors import ModelError
from supple.integrate import StepFactors
from supple.machine import NodalLoad, System
from supple.methods.floating.full.bordered_solve import Border, solve_bordered
from supple.methods.floating.full.elimination import Elimination
from supple.methods.floating.full.full_interior import (
    FullInterior,
    prepare_interior,
)
from supple.methods.floating.full.full_state import (
    Evaluation,
    FullState,
    InteriorState,
    LineEvaluation,
    Targets,
    Unknowns,
)
from supple.methods.floating.full.full_tangent import Factored, FullTangent
from supple.programs.program_cache import CachedProgram


def _matrices(
    model: Model,
    motion: SystemMotion,
    linearization: Linearization,
    increments: jax.Array,
    factors: StepFactors,
) -> tuple[jax.Array, jax.Array, jax.Array]:
    return (
        tangent(model, motion, linearization, increments, factors),
        constraint_rows(model, linearization.joints),
        constraint_rows(model, linearization.joints, increments),
    )


_border_terms = CachedProgram(balance)
_border_matrices = CachedProgram(_matrices)


class FullSystem:
    """A system with full bodies, prepared for stepping, without the state of the motion.

    It is also the `StartingMachine` of its engine.

    Bodies with stations are dense parts of the border. With P = diag(I, J) from their velocities to those of
    the stations, the border's matrix becomes P^T B P + diag(0, S), with S the tangents of these bodies.

    active : the independent constraint equations; all equations until the start has found the redundant ones
    """

    def __init__(self, system: System | MachineWithStations, active: tuple[int, ...] | None = None) -> None:
        seen = system if isinstance(system, MachineWithStations) else MachineWithStations(system, system, ())
        self.system = system = seen.system
        self.seen, self.lines = seen.seen, seen.bodies
        sizes = [placed.body.n_coordinates for placed in system.bodies]
        self.slices = adjacent_slices([6 + r for r in sizes])
        self.coordinate_slices = adjacent_slices(sizes)
        self.n = self.slices[-1].stop
        self.interiors = tuple(
            prepare_interior(system.body_index(name), full, _loads_on(system, full))
            for name, full in system.bodies_of(FullBody).items()
        )
        self.model = station_model(self.seen, len(system.bodies) - len(self.lines), active)
        self.interior_of = {interior.index: interior for interior in self.interiors}
        self.line_of = {line.index: number for number, line in enumerate(self.lines)}
        self.border_slices = self._slices_with([6 * line.n_stations for line in self.lines])
        """Numbers in the border of each body's velocities: of frame and interfaces, or of stations"""
        self.joint_slices = self._slices_with([6 + sizes[line.index] for line in self.lines])
        """`border_slices` with the velocities of bodies with stations instead of those of the stations"""

    def _slices_with(self, sizes: Sequence[int]) -> tuple[slice, ...]:
        """Slices of all bodies, where bodies with stations have these sizes and follow the others."""
        parts = dict(zip(self._others, self.model.slices, strict=False))
        first = max((part.stop for part in parts.values()), default=0)
        for line, size in zip(self.lines, sizes, strict=True):
            parts[line.index] = slice(first, first + size)
            first += size
        return tuple(parts[index] for index in range(len(self.system.bodies)))

    @property
    def _others(self) -> list[int]:
        """Bodies without stations."""
        return [index for index in range(len(self.system.bodies)) if index not in self.line_of]

    def restricted(self, active: tuple[int, ...]) -> Self:
        """The system with the given constraint equations only."""
        other = copy(self)
        other.model = replace(self.model, active=active)
        return other

    def stations(self, configuration: Configuration, velocity: np.ndarray) -> tuple[Stations, ...]:
        """Motions of the stations, for each body that has them."""
        at = 0.0, configuration, velocity, np.zeros_like(velocity)
        return tuple(line.stations(self._body_state(line.index, *at)) for line in self.lines)

    def _body_state(
        self,
        index: int,
        time: float,
        configuration: Configuration,
        velocity: np.ndarray,
        acceleration: np.ndarray,
    ) -> BodyState:
        part = self.slices[index]
        return BodyState(
            np.asarray(float(time)),
            configuration.origins[index],
            configuration.rotations[index],
            configuration.coordinates[self.coordinate_slices[index]],
            velocity[part],
            acceleration[part],
        )

    def body_states(self, index: int, states: Sequence[FullState]) -> list[BodyState]:
        """States of one body at several instants."""
        return [
            self._body_state(index, each.time, each.configuration, each.velocity, each.acceleration)
            for each in states
        ]

    def to_border(self, vector: np.ndarray, stations: tuple[Stations, ...]) -> np.ndarray:
        """Velocities (or accelerations) of the compiled part, with the motions of interfaces and stations."""
        seen = np.empty(self.model.n_velocities)
        for index, (part, border) in enumerate(zip(self.slices, self.border_slices, strict=True)):
            own, interior = vector[part], self.interior_of.get(index)
            if interior is not None:
                own = np.concatenate([own[:6], interior.interface_rows @ own[6:]])
            elif index in self.line_of:
                own = stations[self.line_of[index]].motion @ own
            seen[border] = own
        return seen

    def border_configuration(
        self, configuration: Configuration, stations: tuple[Stations, ...]
    ) -> Configuration:
        """Configuration of the compiled part."""
        others, coordinates = self._others, []
        for index in others:
            own = configuration.coordinates[self.coordinate_slices[index]]
            interior = self.interior_of.get(index)
            coordinates.append(own if interior is None else interior.interface_rows @ own)
        return Configuration(
            np.concatenate([configuration.origins[others], *(each.positions for each in stations)]),
            np.concatenate([configuration.rotations[others], *(each.rotations for each in stations)]),
            np.concatenate(coordinates) if coordinates else np.zeros(0),
        )

    def _by_line(self, stations: tuple[Stations, ...]) -> np.ndarray:
        """The map P from velocities in `joint_slices` to those of the border."""
        found = np.zeros((self.model.n_velocities, max(part.stop for part in self.joint_slices)))
        for index in self._others:
            part = self.border_slices[index]
            found[part, part] = np.eye(part.stop - part.start)
        for line, each in zip(self.lines, stations, strict=True):
            found[self.border_slices[line.index], self.joint_slices[line.index]] = each.motion
        return found

    def moved(self, configuration: Configuration, increment: np.ndarray) -> Configuration:
        """The configuration after an increment (n,)."""
        frames = np.array([increment[part.start : part.start + 6] for part in self.slices])
        turns = np.asarray(_rotations_exp(frames[:, 3:]))
        return Configuration(
            origins=configuration.origins + frames[:, :3],
            rotations=configuration.rotations @ turns,
            coordinates=configuration.coordinates
            + np.concatenate([increment[part.start + 6 : part.stop] for part in self.slices]),
        )

    def border_motion(self, state: FullState, stations: tuple[Stations, ...] | None = None) -> SystemMotion:
        """Motion of the compiled part; stations are massless, so their accelerations have no effect."""
        if stations is None:
            stations = self.stations(state.configuration, state.velocity)
        return SystemMotion(
            np.float64(state.time),
            self.border_configuration(state.configuration, stations),
            self.to_border(state.velocity, stations),
            self.to_border(state.acceleration, stations),
            np.asarray(state.multipliers),
            state.control,
        )

    def ended(self, state: FullState) -> FullState:
        """The state at the end of a step, with its controllers at the start of the next one."""
        if state.control is None:
            return state
        control = control_after(self.model, self.border_motion(state))
        return state._replace(control=ControlStep(control, np.zeros(())))

    def evaluate(self, state: FullState, by_position: float) -> Evaluation:
        """All residuals at a state; the factor `by_position` of the step scales constraint residuals."""
        stations = self.stations(state.configuration, state.velocity)
        motion = self.border_motion(state, stations)
        terms = jax.tree.map(np.asarray, _border_terms(self.model, motion))
        states, residuals, gaps = [], [], []
        lines = [self._evaluated_line(number, state, each, terms) for number, each in enumerate(stations)]
        # Squared norms by term (inertia, internal, applied, joint) and kind (force, moment, deformation).
        squares = np.zeros((4, 3))
        unbalanced = np.zeros(3)
        own_terms = (terms.inertia, terms.internal, terms.applied, terms.joint)
        for index, part in enumerate(self.border_slices):
            interior = self.interior_of.get(index)
            rows = [term[part] for term in own_terms]
            if index in self.line_of:
                rows = lines[self.line_of[index]][1]
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
                gaps.append(forces.frame_residual)
            squares += np.array([_squares_by_kind(row) for row in rows])
            unbalanced += _squares_by_kind(np.sum(rows, axis=0))
        scale = np.sqrt(squares.max(axis=0))
        relative = np.sqrt(unbalanced) / np.where(scale > 0, scale, 1.0)
        of_joints = terms.constraint_residual
        constraint = self._relative_constraint(
            state, np.concatenate([self.model.as_lengths(of_joints), *gaps]), by_position
        )
        return Evaluation(
            motion,
            terms,
            of_joints,
            tuple(states),
            tuple(residuals),
            tuple(gaps),
            np.append(relative, constraint),
            np.where(scale > 0, scale, 1.0),
            state.configuration.rotations,
            tuple(line for line, _ in lines),
        )

    def _evaluated_line(
        self, number: int, state: FullState, stations: Stations, terms: Balance
    ) -> tuple[LineEvaluation, list[np.ndarray]]:
        """A body with stations, and its inertia, internal, applied and joint forces, (6 + r,)."""
        line = self.lines[number]
        part = self.border_slices[line.index]
        at = self._body_state(line.index, state.time, state.configuration, state.velocity, state.acceleration)
        inertia, internal, applied = line.forces(at)
        rows = [
            inertia,
            internal,
            applied + stations.motion.T @ terms.applied[part],
            stations.motion.T @ terms.joint[part],
        ]
        return LineEvaluation(at, stations, np.sum(rows, axis=0), terms.residual[part]), rows

    def _relative_constraint(self, state: FullState, residual: np.ndarray, by_position: float) -> float:
        largest = float(np.max(abs(residual), initial=0.0))
        floor = self.model.length * float(position_rounding(self.model.length, state.configuration.origins))
        if largest <= floor or by_position == 0:
            return 0.0
        accelerations = self.model.length * np.max(abs(state.acceleration) / self.position_scale)
        return largest / by_position / (accelerations + floor / by_position)

    @cached_property
    def position_scale(self) -> np.ndarray:
        """Size of a large change of each freedom, (n,)."""
        length = self.model.length
        parts = []
        for index, (placed, part) in enumerate(zip(self.system.bodies, self.slices, strict=True)):
            r = part.stop - part.start - 6
            scale = length if index in self.interior_of else length * np.sqrt(placed.body.mass)
            parts += [np.full(3, length), np.ones(3), np.full(r, scale)]
        return np.concatenate(parts)

    @cached_property
    def border_scale(self) -> np.ndarray:
        """`position_scale` of the freedoms of the border, with those of interfaces and stations."""
        of_frame = [self.model.length] * 3 + [1.0] * 3
        found = np.empty(self.model.n_velocities)
        for index, part in enumerate(self.border_slices):
            if index in self.interior_of or index in self.line_of:
                found[part] = np.tile(of_frame, (part.stop - part.start) // 6)
            else:
                found[part] = self.position_scale[self.slices[index]]
        return found

    def under(self, evaluation: Evaluation, forces: np.ndarray) -> Evaluation:
        """The evaluation with its unbalanced forces replaced by `forces` on the border."""
        interiors = []
        for interior in self.interiors:
            own = -forces[self.border_slices[interior.index]]
            interiors.append(np.concatenate([own[:6], interior.interface_rows.T @ own[6:]]))
        return evaluation.left_with(-forces, tuple(interiors))

    def residual_of(self, evaluation: Evaluation) -> np.ndarray:
        """Residual of all freedoms (n,); for frames, a global force and a moment in body axes."""
        parts = [evaluation.border.residual[part] for part in self.border_slices]
        for interior, own in zip(self.interiors, evaluation.interior_residuals, strict=True):
            parts[interior.index] = own
        for body, line in zip(self.lines, evaluation.lines, strict=True):
            parts[body.index] = line.residual
        return np.concatenate(parts)

    def norms(self, residual: np.ndarray) -> np.ndarray:
        """Norms (3,) of forces, moments and deformation forces in a residual (n,)."""
        return np.sqrt(np.sum([_squares_by_kind(residual[part]) for part in self.slices], axis=0))

    def without(self, evaluation: Evaluation, forces: np.ndarray) -> Evaluation:
        """The evaluation minus forces (n,); its relative residual is unchanged."""
        border = np.zeros(self.model.n_velocities)
        for index, (part, own) in enumerate(zip(self.border_slices, self.slices, strict=True)):
            if index not in self.interior_of and index not in self.line_of:
                border[part] = forces[own]
        interiors = tuple(
            residual - forces[self.slices[interior.index]]
            for interior, residual in zip(self.interiors, evaluation.interior_residuals, strict=True)
        )
        terms = evaluation.border._replace(applied=evaluation.border.applied - border)
        lines = tuple(
            line._replace(residual=line.residual - forces[self.slices[body.index]])
            for body, line in zip(self.lines, evaluation.lines, strict=True)
        )
        return evaluation._replace(border=terms, interior_residuals=interiors, lines=lines)

    def _interior_state(self, interior: FullInterior, state: FullState) -> InteriorState:
        part = self.slices[interior.index]
        velocity, acceleration = state.velocity[part], state.acceleration[part]
        return InteriorState(
            rotation=state.configuration.rotations[interior.index],
            coordinates=state.configuration.coordinates[self.coordinate_slices[interior.index]],
            rates=velocity[6:],
            accelerations=acceleration[6:],
            angular_velocity=velocity[3:6],
            angular_acceleration=acceleration[3:6],
            acceleration=acceleration[:3] - np.asarray(self.model.gravity_at(state.time)),
            frame_multipliers=state.frame_multipliers[self.interiors.index(interior)],
            time=state.time,
        )

    def correction(
        self,
        evaluation: Evaluation,
        targets: Targets,
        increments: np.ndarray,
        factors: StepFactors,
    ) -> Unknowns:
        """Solve the bordered system for the change of accelerations, multipliers and frame multipliers.

        targets : required values of the constraint rows and the frame conditions of each full body
        """
        turns = self.turns(increments)
        eliminations = self.eliminated(evaluation.interior_states, turns, factors, FullTangent.serving)
        return self.correction_behind(eliminations, evaluation, targets, increments, factors)

    def turns(self, increments: np.ndarray) -> np.ndarray:
        """Rotations of the full bodies' frames in increments (n,), (b, 3)."""
        return np.array([increments[self.slices[each.index]][3:6] for each in self.interiors])

    def eliminated(
        self,
        states: tuple[InteriorState, ...],
        turns: np.ndarray,
        factors: StepFactors,
        factor: Callable[[FullTangent, InteriorState, StepFactors], Factored],
    ) -> tuple[Elimination, ...]:
        """Eliminations of all interiors, with the `factor` of their tangents."""
        return tuple(
            interior.eliminate(state, turn, factors, factor(interior.tangent, state, factors))
            for interior, state, turn in zip(self.interiors, states, turns, strict=True)
        )

    def correction_behind(
        self,
        eliminations: tuple[Elimination, ...],
        evaluation: Evaluation,
        targets: Targets,
        increments: np.ndarray,
        factors: StepFactors,
    ) -> Unknowns:
        """`correction` for interiors that are already eliminated."""
        model = self.model
        stations = tuple(line.stations for line in evaluation.lines)
        # Tangents of stations depend on their positions, not on the increments that led there.
        still = tuple(each._replace(motion=np.zeros_like(each.motion)) for each in stations)
        matrix, rows, rows_by_increment = (
            np.asarray(x)
            for x in _border_matrices(
                model,
                evaluation.border_motion,
                evaluation.border.linearization,
                self.to_border(increments, still),
                StepFactors(*map(np.float64, factors)),
            )
        )
        residual = evaluation.border.residual
        if self.lines:
            matrix, rows, rows_by_increment, residual = self._with_lines(
                matrix, rows, rows_by_increment, evaluation, increments, factors
            )
        joint_targets, frame_targets = targets
        border = Border(matrix, rows, rows_by_increment, residual, joint_targets, float(model.mass))
        behind = [
            elimination.loaded(self.border_slices[interior.index], unbalanced, target, state.rotation)
            for interior, elimination, unbalanced, state, target in zip(
                self.interiors,
                eliminations,
                evaluation.interior_residuals,
                evaluation.interior_states,
                frame_targets,
                strict=True,
            )
        ]
        moved, multipliers, interiors, frame_multipliers = solve_bordered(border, behind)
        parts = [moved[part] for part in self.joint_slices]
        for interior, own in zip(self.interiors, interiors, strict=True):
            parts[interior.index] = np.concatenate([parts[interior.index][:6], own])
        return Unknowns(np.concatenate(parts), multipliers, frame_multipliers)

    def _with_lines(
        self,
        matrix: np.ndarray,
        rows: np.ndarray,
        rows_by_increment: np.ndarray,
        evaluation: Evaluation,
        increments: np.ndarray,
        factors: StepFactors,
    ) -> tuple[np.ndarray, ...]:
        """Matrices and residual of the border for `joint_slices`, with the tangents of the lines included.

        The derivative of the stations' velocities by their positions is neglected in Newton's iteration.
        """
        by_line = self._by_line(tuple(line.stations for line in evaluation.lines))
        matrix, rows, by_increment = by_line.T @ matrix @ by_line, rows @ by_line, rows_by_increment @ by_line
        residual = np.empty(len(matrix))
        for index in self._others:
            part = self.border_slices[index]
            residual[part] = evaluation.border.residual[part]
        for body, line in zip(self.lines, evaluation.lines, strict=True):
            part = self.joint_slices[body.index]
            mass, damping, stiffness = body.tangent(line.state, line.station_forces)
            turned = slice(part.start + 3, part.start + 6)
            turn = np.asarray(_right_jacobian(increments[self.slices[body.index]][3:6]))
            stiffness = np.hstack([stiffness[:, :3], stiffness[:, 3:6] @ turn, stiffness[:, 6:]])
            by_increment[:, turned] = by_increment[:, turned] @ turn
            matrix[part, part] += mass + factors.by_velocity * damping + factors.by_position * stiffness
            residual[part] = line.residual
        return matrix, rows, by_increment, residual

    def joint_terms(self, time: float, configuration: Configuration, velocity: np.ndarray) -> JointTerms:
        """Constraints and their derivatives, for velocities in `joint_slices`."""
        stations = self.stations(configuration, velocity)
        border = self.border_configuration(configuration, stations)
        at, moving = jnp.asarray(float(time)), jnp.asarray(self.to_border(velocity, stations))
        found = JointTerms(*map(np.asarray, joint_terms(self.model, at, border, moving)))
        if not self.lines:
            return found
        bias = np.zeros(self.model.n_velocities)
        for line, each in zip(self.lines, stations, strict=True):
            bias[self.border_slices[line.index]] = each.bias
        return found._replace(
            jacobian=found.jacobian @ self._by_line(stations),
            acceleration_bias=found.acceleration_bias + found.jacobian @ bias,
        )

    def metric(self, configuration: Configuration) -> np.ndarray:  # noqa: ARG002
        """Unit matrix, because the interface motions in the rows have no mass of their own."""
        return np.eye(max(part.stop for part in self.joint_slices))

    def _border_mass(self, configuration: Configuration) -> np.ndarray:
        stations = self.stations(configuration, np.zeros(self.n))
        return np.asarray(
            _mass_matrix(self.model.bodies_alone, self.border_configuration(configuration, stations))
        )

    def frame_masses(self, configuration: Configuration) -> np.ndarray:
        """Mass matrices (nb, 6, 6) of the bodies for motion of their frames."""
        border = self._border_mass(configuration)
        masses = np.zeros((len(self.slices), 6, 6))
        at_rest = self.state_at(0.0, configuration, np.zeros(self.n))
        for index in self._others:
            frame = slice(self.border_slices[index].start, self.border_slices[index].start + 6)
            masses[index] = border[frame, frame]
        for interior in self.interiors:
            masses[interior.index] = interior.frame_mass(self._interior_state(interior, at_rest))
        for line, mass in zip(self.lines, self._line_masses(configuration), strict=True):
            masses[line.index] = mass[:6, :6]
        return masses

    def _line_masses(self, configuration: Configuration) -> list[np.ndarray]:
        at = 0.0, configuration, np.zeros(self.n), np.zeros(self.n)
        forces = [np.zeros(6 * line.n_stations) for line in self.lines]
        return [
            line.tangent(self._body_state(line.index, *at), none)[0]
            for line, none in zip(self.lines, forces, strict=True)
        ]

    def kinetic_energies(self, configuration: Configuration, velocity: np.ndarray) -> np.ndarray:
        """Kinetic energies (nb,) of the bodies."""
        border = self.to_border(velocity, self.stations(configuration, velocity))
        products = border * (self._border_mass(configuration) @ border)
        energies = np.array([products[part].sum() / 2 for part in self.border_slices])
        state = self.state_at(0.0, configuration, velocity)
        for interior in self.interiors:
            moving = velocity[self.slices[interior.index]][:3]
            energies[interior.index] = interior.kinetic_energy(self._interior_state(interior, state), moving)
        for line, mass in zip(self.lines, self._line_masses(configuration), strict=True):
            own = velocity[self.slices[line.index]]
            energies[line.index] = own @ mass @ own / 2
        return energies

    def least_change(
        self,
        configuration: Configuration,
        velocity: np.ndarray,
        terms: JointTerms,  # noqa: ARG002 - the border evaluates them again
        joint_residual: np.ndarray,
    ) -> np.ndarray:
        """Solution x of `M x + G^T y + D^T z = 0`, `G x = - residual`, `D x = - D velocity`."""
        drifts = tuple(
            -interior.frame_rows @ velocity[self.slices[interior.index]][6:] for interior in self.interiors
        )
        ((change, _),) = self._pushed(configuration, [(-joint_residual, drifts)])
        return change

    def joint_masses(self, configuration: Configuration, terms: JointTerms) -> np.ndarray:
        """The multipliers of `least_change` for a unit residual of each equation."""
        none = tuple(np.zeros(6) for _ in self.interiors)
        units = -np.eye(len(terms.residual))
        return np.array([own for _, own in self._pushed(configuration, [(unit, none) for unit in units])])

    def _pushed(
        self, configuration: Configuration, targets: Sequence[Targets]
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """Motions (n,) of bodies at rest under joint forces alone, and their multipliers, for each target."""
        still = self.evaluate(self.state_at(0.0, configuration, np.zeros(self.n)), 0.0)
        balanced = self.under(still, np.zeros(self.model.n_velocities))
        none, factors = np.zeros(self.n), StepFactors(0.0, 0.0)
        eliminations = self.eliminated(
            balanced.interior_states, self.turns(none), factors, FullTangent.serving
        )
        return [
            self.correction_behind(eliminations, balanced, target, none, factors)[:2] for target in targets
        ]

    def check_frames(self, configuration: Configuration) -> None:
        """Raise ModelError for an initial deformation that moves the frame of its body."""
        for interior in self.interiors:
            moved = interior.frame_rows @ configuration.coordinates[self.coordinate_slices[interior.index]]
            if np.max(abs(moved)) > 1e-9 * self.model.length:
                raise ModelError(
                    f"the initial deformation of body '{interior.full.name}' moves its frame by "
                    f"{np.max(abs(moved)):.3g}: subtract the rigid motion (frame_projector) first"
                )

    def state_at(self, time: float, configuration: Configuration, velocity: np.ndarray) -> FullState:
        """A state with zero accelerations and multipliers, and controllers in their initial states."""
        none = np.zeros(self.n)
        control = fresh_control(self.system)
        return FullState(
            float(time),
            configuration,
            velocity,
            none,
            none,
            np.zeros(len(self.model.active)),
            tuple(np.zeros(6) for _ in self.interiors),
            None if control is None else ControlStep(control, np.zeros(())),
        )

    def accelerated(self, state: FullState) -> FullState:
        """The state with the accelerations and multipliers that belong to its positions and velocities."""
        bias = self.joint_terms(state.time, state.configuration, state.velocity).acceleration_bias
        none = tuple(np.zeros(6) for _ in self.interiors)
        still, targets = np.zeros(self.n), (-bias, none)
        # The correction from zero acceleration is the acceleration; the state may contain another one.
        begun = state._replace(acceleration=still, frame_multipliers=none)

        def solved(carried: np.ndarray) -> Unknowns:
            at = self.evaluate(begun._replace(multipliers=carried), 0.0)
            change = self.correction(at, targets, still, StepFactors(0.0, 0.0))
            return change._replace(multipliers=carried + change.multipliers)

        found = solved(np.zeros(len(bias)))
        if self.model.reads_reactions:
            found = converged_reactions(solved, found)
        return state._replace(**found._asdict(), auxiliary=found.acceleration)


_mass_matrix = CachedProgram(mass_matrix, STARTING)
_right_jacobian = jax.jit(rotation_right_jacobian)
_rotations_exp = jax.jit(jax.vmap(rotation_exp))


def _loads_on(system: System, full: FullBody) -> tuple[NodalLoad, ...]:
    given = (load for load in system.loads if isinstance(load, NodalLoad) and load.body == full.name)
    return tuple(load for load in given if is_on_full_nodes(system, load))


def _squares_by_kind(row: np.ndarray) -> np.ndarray:
    """Squared norms of forces, moments and deformation forces in one body's row (6 + r,)."""
    return np.array([row[:3] @ row[:3], row[3:6] @ row[3:6], row[6:] @ row[6:]])
