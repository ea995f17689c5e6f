"""Static equilibrium and steady rotation of machines with intrinsic bodies."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import jax
import numpy as np
from scipy.linalg import block_diag

from supple.algebra.rotation import euler_parameters
from supple.equations.build_model import system_length
from supple.equations.configuration import Configuration
from supple.equations.control_linearization import LinearControl
from supple.equations.coordinate_scales import kinds_of_rows, known_position_scale
from supple.equations.machine_model import Model, adjacent_slices
from supple.equations.static_search import ROUND_OFF, EquilibriumResidual, StaticState, StaticStep
from supple.equations.steady_motion import LinearEquations, SteadyEquations, SteadyRotation, frame_axes
from supple.errors import AccuracyError, ModelError
from supple.integrate import Solution, Statistics
from supple.machine import Placed, System
from supple.machine.laws.constant_rate import ConstantRate
from supple.methods.intrinsic.intrinsic_body import body_of
from supple.methods.intrinsic.joined_engine import joined_solution
from supple.methods.intrinsic.joined_equations import JoinedInstant
from supple.methods.intrinsic.joined_machine import (
    JoinedArrays,
    JoinedMachine,
    joined_machine,
    supported_machine,
)
from supple.methods.intrinsic.joined_start import closed_machine
from supple.methods.intrinsic.line_model import LineState
from supple.methods.intrinsic.line_steady import (
    LineSmallMotions,
    moved_by,
    small_motions,
    steady,
    unbalanced_at,
)
from supple.methods.intrinsic.line_system import RootDrive
from supple.methods.intrinsic.machine_of_lines import MachineOfLines
from supple.methods.intrinsic.strain_integration import rotation_of
from supple.methods.intrinsic.supported_root import is_joined, supported_root

SAME_AXIS = 1e-9
"""Largest part of a root twist that the root support excludes, relative to the twist; more is an error."""


@dataclass(frozen=True, eq=False)
class LineStatics(SteadyEquations):
    """`Equations` of intrinsic bodies, from the residuals of the time integration and their derivatives.

    Vectors (N,) have the entries of floating bodies, then of the lines' velocity amplitudes.
    """

    machine: JoinedMachine
    begin: JoinedInstant

    @property
    def model(self) -> Model:
        """Model of its joints and forces."""
        return self.machine.arrays.model

    @property
    def slices(self) -> tuple[slice, ...]:
        """Slice of each body's motions."""
        return adjacent_slices([6 + placed.body.n_coordinates for placed in self.machine.system.bodies])

    is_discrete: ClassVar[bool] = True
    """True: forces refer to time derivatives of positions, inertia to velocities of the modes."""

    def start(self) -> StaticState:
        """The bodies as placed, with zero joint forces."""
        return StaticState(self.begin, np.zeros(len(self.model.active)))

    def residual(self, state: StaticState, time: float) -> np.ndarray:
        """Residual of all freedoms, (N,)."""
        return self.unbalance(state, time).terms

    def unbalance(self, state: StaticState, time: float) -> EquilibriumResidual:  # noqa: ARG002 - drives are fixed
        """The residuals at rest or in steady rotation, relative and absolute."""
        found = jax.device_get(unbalanced_at(*self._terms, state.configuration, state.multipliers))
        residual = found.residual - self.held
        works = self.position_scale[:, None] * np.column_stack([residual, found.terms])
        norms = np.sqrt(self._kinds @ works**2)
        scale = norms[:, 1:].max(axis=1)
        scale = np.maximum(scale, ROUND_OFF * max(scale.max(), self._work_of_turning))
        relative = norms[:, 0] / np.where(scale > 0, scale, 1.0)
        gap = float(np.max(abs(found.gaps), initial=0.0)) / self._length
        return EquilibriumResidual(relative, gap, residual, float(scale.max()))

    def correction(
        self, state: StaticState, time: float, unbalance: EquilibriumResidual, k: float
    ) -> StaticStep:
        """One implicit step of length k; AccuracyError if its matrix is singular."""
        linear = self._small_motions(state)
        matrix, rows = linear.mass + k * linear.stiffness, linear.jacobian
        n, m = len(matrix), len(rows)
        size = float(np.max(abs(np.diag(matrix))))
        bordered = np.block([[matrix, size * rows.T], [size * rows, np.zeros((m, m))]])
        gaps = unbalanced_at(*self._terms, state.configuration, state.multipliers).gaps
        try:
            change = -np.linalg.solve(
                bordered, np.concatenate([unbalance.terms, size / k * np.asarray(gaps)])
            )
        except np.linalg.LinAlgError as error:
            raise AccuracyError(
                f"no equilibrium at t = {time:g}: the tangent is singular. Check for motions that no joint, "
                "stiffness or gravity determines"
            ) from error
        return StaticStep(k * change[:n], size * change[n:])

    def moved(self, configuration: JoinedInstant, increment: np.ndarray) -> JoinedInstant:
        """The machine after an increment (N,)."""
        return moved_by(self.machine.arrays, configuration, increment)

    @property
    def position_scale(self) -> np.ndarray:
        """Change (N,) of each freedom that rotates a body by 1 rad or moves it by the size of the machine."""
        arrays = self.machine.arrays
        found = [np.asarray(known_position_scale(arrays.model))[: arrays.n_floating]]
        for model in arrays.lines:
            motions = np.asarray(model.velocities).reshape(-1, 6, np.shape(model.velocities)[1])
            sizes = np.linalg.norm(motions.reshape(len(motions), 2, 3, -1), axis=2).max(axis=0)
            found.append(1 / np.maximum(sizes[0] / self._length, sizes[1]))
        return np.concatenate(found)

    def linear_equations(self, state: StaticState, time: float) -> LinearEquations:  # noqa: ARG002
        """Equations of motion linearised about a state, for motions p of bodies in their order.

        p is the translation and rotation of each body's axes, along these axes, and its elastic amplitudes.
        The constraint equations include the motions that the support of a root fixes.
        """
        linear, arrays = self._small_motions(state), self.machine.arrays
        rotations = np.asarray(state.configuration.floating.rotations)[: arrays.n_bodies]
        axes = frame_axes(arrays.n_floating, arrays.model.frames.starts[: arrays.n_bodies], rotations)
        parts = [
            body_of(placed).freedoms(np.asarray(own.q2))
            for placed, own in zip(self.machine.lines, state.configuration.lines, strict=True)
        ]
        # After the amplitudes of each line, motions fixed by its support: rows and columns of zeros.
        chosen = _blocks(axes, *(np.eye(part.m, len(part.shapes)) for part in parts))
        held = _blocks(np.zeros((0, len(axes))), *(np.eye(len(part.shapes))[part.m :] for part in parts))
        extra = _blocks(np.zeros_like(axes), *(part.held_mass for part in parts))
        back = np.linalg.inv(_blocks(np.eye(len(axes)), *(part.shapes for part in parts)))
        back = back[:, self._order]

        def of_bodies(matrix: np.ndarray) -> np.ndarray:
            return back.T @ (chosen.T @ matrix @ chosen) @ back

        n = len(back)
        rows = np.vstack([linear.jacobian @ chosen, held]) @ back
        return LinearEquations(
            mass=of_bodies(linear.mass) + back.T @ extra @ back,
            damping=of_bodies(linear.damping),
            stiffness=of_bodies(linear.stiffness),
            constraint=rows,
            control=LinearControl(np.zeros((n, 0)), np.zeros((0, n)), np.zeros((0, n)), np.zeros((0, 0))),
        )

    def constraint_rows(self, state: StaticState, time: float) -> np.ndarray:  # noqa: ARG002
        """Derivatives of the joints' equations, (m, N)."""
        return self._small_motions(state).jacobian

    def bodies_at(self, configuration: JoinedInstant) -> Configuration:
        """Configuration of the bodies, in their order."""
        known, first = {}, 0
        floating = configuration.floating
        for index, placed in enumerate(self.machine.others):
            after = first + placed.body.n_coordinates
            own = floating.origins[index], floating.rotations[index], floating.coordinates[first:after]
            known[placed.body.name], first = own, after
        for placed, state in zip(self.machine.lines, configuration.lines, strict=True):
            body = body_of(placed)
            rotation = np.asarray(rotation_of(state.quaternion))
            origin = np.asarray(state.position) - rotation @ body.line.tree.points[0]
            omega = body.modes.omega[body.modes.n_rigid :]
            known[placed.body.name] = origin, rotation, -np.asarray(state.q2) / omega
        parts = zip(*(known[placed.body.name] for placed in self.machine.system.bodies), strict=True)
        origins, rotations, coordinates = parts
        return Configuration(np.array(origins), np.array(rotations), np.concatenate(coordinates))

    def solution(self, state: StaticState, time: float, iterations: int) -> Solution:
        """The steady motion at one instant."""
        arrays = self._terms[0]
        found = steady(*self._terms, state.configuration)
        now, rates, velocities = jax.tree.map(lambda leaf: np.asarray(leaf)[None], found)
        statistics = Statistics(iterations=iterations)
        if not is_joined(self.machine.system):
            system = self.machine.system
            roots = tuple(supported_root(system, placed) for placed in system.bodies)
            machine = MachineOfLines(system, arrays.line_system, found[0].lines, roots)
            own_rates = [rate.q1 for rate in rates.lines]
            return machine.solution(np.array([time]), now.lines, statistics, own_rates)
        machine, multipliers = self.machine._replace(arrays=arrays), np.asarray(state.multipliers)[None]
        return joined_solution(machine, now, velocities, rates, multipliers, statistics)

    @cached_property
    def _order(self) -> np.ndarray:
        """Permutation of motions: from floating bodies, then lines, to the bodies in their order."""
        starts, first = {}, 0
        for placed in (*self.machine.others, *self.machine.lines):
            starts[placed.body.name] = np.arange(first, first + 6 + placed.body.n_coordinates)
            first += 6 + placed.body.n_coordinates
        return np.concatenate([starts[placed.body.name] for placed in self.machine.system.bodies])

    @cached_property
    def _terms(self) -> tuple[JoinedArrays, SteadyRotation | None]:
        """Arrays of the machine with its rotating drives, and its steady rotation, floating bodies first."""
        arrays, time = self.machine.arrays, float(self.begin.time)
        names = [placed.body.name for placed in self.machine.system.bodies]
        order = [names.index(placed.body.name) for placed in (*self.machine.others, *self.machine.lines)]
        turning = self.turning
        if turning is not None:
            turning = turning._replace(angular_velocities=np.asarray(turning.angular_velocities)[order])
        rates = np.zeros((len(names), 3)) if turning is None else turning.angular_velocities
        point = np.zeros(3) if turning is None else turning.point
        drives = tuple(
            _steady_drive(placed, drive, np.asarray(state.position), w, point, time)
            for placed, drive, state, w in zip(
                self.machine.lines,
                arrays.drives,
                self.begin.lines,
                rates[len(self.machine.others) :],
                strict=True,
            )
        )
        return replace(arrays, drives=drives), turning

    @property
    def _kinds(self) -> np.ndarray:
        """(3, N) 1 where a row is a force, a moment or a deformation; the rows of lines are deformations."""
        arrays = self.machine.arrays
        lines = sum(np.shape(model.velocities)[1] for model in arrays.lines)
        of_lines = np.repeat([[0.0], [0.0], [1.0]], lines, axis=1)
        return np.hstack([kinds_of_rows(arrays.model)[:, : arrays.n_floating], of_lines])

    @cached_property
    def _length(self) -> float:
        return system_length(self.machine.system)

    @property
    def _work_of_turning(self) -> float:
        if self.turning is None:
            return 0.0
        mass = sum(placed.body.mass for placed in self.machine.system.bodies)
        rate = np.linalg.norm(self.turning.angular_velocities, axis=1).max()
        return float(mass * (rate * self._length) ** 2)

    def _small_motions(self, state: StaticState) -> LineSmallMotions:
        return jax.device_get(small_motions(*self._terms, state.configuration, state.multipliers))


def _blocks(*parts: np.ndarray) -> np.ndarray:
    return np.asarray(block_diag(*parts))


def line_statics(
    system: System, turning: SteadyRotation | None, time: float, known: tuple[int, ...] | None = None
) -> LineStatics:
    """Steady equations of a machine with intrinsic bodies and closed joints.

    known : numbers of the independent equations of joints; None: they are computed
    """
    machine = joined_machine(system, time) if is_joined(system) else supported_machine(system, time)
    drives = zip(machine.states, machine.arrays.drives, strict=True)
    machine = machine._replace(states=tuple(_driven(state, drive, time) for state, drive in drives))
    closed = closed_machine(machine, time, known)
    lines = tuple(replace(state, q1=0.0 * state.q1) for state in closed.now.lines)
    now = closed.now._replace(lines=lines, velocity=0.0 * closed.now.velocity)
    now = jax.tree.map(np.asarray, now)
    return LineStatics(machine._replace(arrays=closed.arrays), now, turning)


def _driven(state: LineState, drive: RootDrive | None, time: float) -> LineState:
    """The state with its root at the position of its drive."""
    if drive is None:
        return state
    rotation, position = drive.pose(time)
    return replace(state, quaternion=euler_parameters(rotation), position=position)


def _steady_drive(
    placed: Placed, drive: RootDrive | None, root: np.ndarray, w: np.ndarray, point: np.ndarray, time: float
) -> RootDrive | None:
    """A drive that is fixed, or that continues at the rate of the steady rotation.

    Raises ModelError for a root that cannot follow the rotation.
    """
    rotation = placed.rotation if drive is None else np.asarray(drive.pose(time)[0])
    twist = np.concatenate([np.cross(w, root - point) @ rotation, w @ rotation])
    ways = body_of(placed).support.free if drive is None else np.asarray(drive.screw)[:, None]
    along = np.linalg.lstsq(ways, twist, rcond=None)[0] if ways.size else np.zeros(0)
    if np.abs(twist - ways @ along).max() > SAME_AXIS * max(np.abs(twist).max(), 1e-300):
        raise ModelError(
            f"intrinsic body '{placed.body.name}' cannot rotate with the spin: its root support prevents it. "
            "Give a joint about the axis of the spin (Revolute, PrescribedRotation), through its root; "
            "release the body (released(body); in a case file released = true) if its support rotates too; "
            "or name the rotating bodies, Spin(bodies=..)"
        )
    if drive is None:
        return None
    rate = float(along[0])
    return replace(drive, law=ConstantRate(rate, float(drive.law(time)) - rate * time))
