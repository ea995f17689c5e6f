"""Start of a machine from a time of an earlier motion, with other loads, steps or bases."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from supple.arguments import Positive, check_fields
from supple.body import BodyForm
from supple.equations.control_start import kept_states
from supple.errors import BasisWarning, ModelError, StartWarning, did_you_mean
from supple.integrate import FloatingMotion, FramedMotion, Motion, Solution
from supple.machine import (
    Contact,
    Controller,
    JointReading,
    Placed,
    SampledController,
    SurfaceContact,
    System,
)
from supple.machine.obstacles import is_moving, moved
from supple.methods.explicit import OBSTACLES
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.methods.intrinsic.machine_of_lines import placed_at_instant
from supple.simulation.carried_deformation import (
    Deformation,
    PlacedFrame,
    ProjectionLoss,
    carried_deformation,
    deformation_of,
)
from supple.simulation.equilibrium import LARGEST_ERROR
from supple.simulation.recorded_columns import are_same_columns, measured_columns

__all__ = ["Start", "StartedMachine"]

AnyController = Controller | SampledController

SAME_TIME = 1e-6
"""Largest difference of the start time from an output time, relative to the smallest output step."""


@dataclass(frozen=True, eq=False)
class StartedMachine:
    """A machine in the state of an earlier motion.

    system : System             the machine, with poses, velocities and deformation of its bodies at `time`;
        run it with `Run(.., start=time)`, so that the laws of time continue
    time : float                the start time
    losses : ProjectionLoss     by name of the body, for bodies whose form or basis differs from the motion
    """

    system: System
    time: float
    losses: Mapping[str, ProjectionLoss]


@dataclass(frozen=True, eq=False)
class Start:
    """A time of an earlier motion, from which a machine with the same bodies starts.

    solution : Solution         the earlier motion, computed or read from a file
    time : float | None         one of its output times, in the time unit of the new machine; None: the last
    machine : System | None     the machine of the earlier motion, needed for bodies in another form or basis
    length, duration : float    units of length and time of the earlier motion, in those of the new machine:
        length is 0.001 for a motion in mm and a machine in m
    Raises ModelError for a time that is not among the output times.
    """

    solution: Solution
    time: float | None = None
    machine: System | None = None
    length: Positive = 1.0
    duration: Positive = 1.0

    def __post_init__(self) -> None:
        check_fields(self)
        _ = self.row

    @property
    def times(self) -> np.ndarray:
        """Output times (t,) of the earlier motion, in the time unit of the new machine."""
        return self.duration * self.solution.times

    @property
    def row(self) -> int:
        """Index of the start time among the output times."""
        times = self.times
        if self.time is None:
            return len(times) - 1
        row = int(np.argmin(abs(times - self.time)))
        step = float(np.min(np.diff(times), initial=np.inf))
        allowed = SAME_TIME * (step if np.isfinite(step) else max(abs(self.time), 1.0))
        if not abs(times[row] - self.time) <= allowed:
            near = times[max(row - 1, 0) : row + 2]
            raise ModelError(
                f"a machine starts from an output time, because the state is stored there; {self.time:g} is "
                f"not among those from {times[0]:g} to {times[-1]:g}: use "
                + " or ".join(f"{each:.12g}" for each in near)
            )
        return row

    def place(self, system: System) -> StartedMachine:
        """The machine `system` with the state of the earlier motion at the start time.

        Bodies and controllers are matched by name, moving rigid obstacles by the order of their contacts.
        Bodies and obstacles have the positions and velocities, and bodies the deformation, of the motion. The
        deformation of a body in another form or basis is projected in the mass norm, with its interfaces
        at their positions (`carried_deformation`). Points and axes of joints and forces remain those of
        `system`. Accelerations and joint forces are recomputed at the start of the run. The run therefore
        differs from an uninterrupted run by errors of the order of the integration error.
        Joints that do not allow the velocities, such as a latch that the motion lacks, act as an impact
        without rebound (`start_velocity`).

        Raises
        ------
        ModelError      a body without a motion, with another mesh, or in a form to which its motion cannot
                        be transferred; a body of explicit elements, because plastic strain is not stored;
                        moving obstacles, if the earlier motion has another number of contacts
        Warns BasisWarning if the projection of a body loses 1 % or more of its deformation or rates, and
        StartWarning if a controller restarts.
        """
        placed, losses = [], {}
        for each in system.bodies:
            moved, loss = self._placed(each)
            placed.append(moved)
            if loss is not None:
                losses[each.body.name] = loss
        _warn(losses)
        controllers = tuple(self._goes_on(own) for own in system.controllers)
        found = replace(
            system, bodies=tuple(placed), controllers=controllers, contacts=self._contacts(system)
        )
        return StartedMachine(found, float(self.times[self.row]), losses)

    def _placed(self, placed: Placed) -> tuple[Placed, ProjectionLoss | None]:
        name, known = placed.body.name, self.solution.bodies
        if name not in known:
            raise ModelError(
                f"body '{name}' has no motion to start from{did_you_mean(name, known)}. "
                "Bodies are matched by name"
            )
        motion, body = known[name], placed.body
        same = self._is_same(placed, motion)
        if isinstance(motion, IntrinsicMotion) and body.kind == "intrinsic":
            if not same:
                raise ModelError(
                    f"body '{name}' has other intrinsic modes than the motion: condense it with the same "
                    "modes, in the same units"
                )
            return replace(placed_at_instant(placed, motion, self.row), is_moving=True), None
        if not isinstance(motion, FloatingMotion) or not body.has_frame or body.kind == "intrinsic":
            raise ModelError(
                f"body '{name}' is {body.kind}, and its motion is {motion.kind}: keep the form "
                "of the motion; explicit elements continue only by --resume, because their plastic strain "
                "is not stored"
            )
        state, q, dq = self._state(motion)
        loss = None
        if not same:
            then = self._body_that_moved(placed, len(q))
            deformation = self._scaled(deformation_of(then, q, dq), then.dofs_per_node)
            nodes = self.length * then.nodes
            state, q, dq, loss = carried_deformation(then, state, deformation, body, nodes)
        moved = placed.moved_to(state.position, state.rotation)
        velocities = {"velocity": state.velocity, "angular_velocity": state.angular_velocity}
        return replace(moved, coordinates=q, coordinate_rates=dq, is_moving=True, **velocities), loss

    def _is_same(self, placed: Placed, motion: Motion) -> bool:
        """Whether body and motion have the same coordinates; ModelError if that cannot be determined."""
        name, here = placed.body.name, placed.body.n_coordinates
        there = motion.coordinates.shape[1] if isinstance(motion, FramedMotion) else -1
        if not here and not there:
            return True
        known = self.solution.columns or (measured_columns(self.machine) if self.machine else {})
        if not known and there == here:
            raise ModelError(
                f"the basis of the motion of body '{name}' is unknown: give the machine of the motion, "
                "Start(solution, time, machine)"
            )
        unscaled = (self.length, self.duration) == (1.0, 1.0)
        return there == here and unscaled and are_same_columns(known.get(name, {}), placed)

    def _state(self, motion: FloatingMotion) -> tuple[PlacedFrame, np.ndarray, np.ndarray]:
        """Frame in units of the new machine; coordinates and rates in units of the earlier motion."""
        row, speed = self.row, self.length / self.duration
        state = PlacedFrame(
            self.length * motion.position[row],
            motion.rotation[row],
            speed * motion.velocity[row],
            motion.angular_velocity[row] / self.duration,
        )
        return state, motion.coordinates[row], motion.coordinate_rates[row]

    def _scaled(self, deformation: Deformation, dofs_per_node: int) -> Deformation:
        """The deformation in units of the new machine: translations are scaled, rotations are not."""
        units = np.ones(dofs_per_node)
        units[:3] = self.length
        nodal, rates = (each.reshape(-1, dofs_per_node) * units for each in deformation)
        return Deformation(nodal.ravel(), rates.ravel() / self.duration)

    def _body_that_moved(self, placed: Placed, size: int) -> BodyForm:
        name = placed.body.name
        if not (size and placed.body.n_coordinates):
            words = ("rigid", "elastic") if not size else ("elastic", "rigid")
            raise ModelError(
                f"body '{name}' was {words[0]} and is {words[1]} now: its deformation cannot be "
                "transferred; keep its form"
            )
        if self.machine is None:
            raise ModelError(
                f"the motion of body '{name}' is in a basis of {size} columns, the body in another basis "
                f"({placed.body.n_coordinates} columns): for a projection give the machine of the motion, "
                "Start(solution, time, machine)"
            )
        then = self.machine.placed(name, "start")
        if not then.body.has_frame or then.body.n_coordinates != size:
            raise ModelError(
                f"the motion of body '{name}' has {size} coordinates, but the body in Start(.., machine) has "
                f"{then.body.n_coordinates}: give the machine of the motion"
            )
        if self.solution.columns and not are_same_columns(self.solution.columns.get(name, {}), then):
            raise ModelError(
                f"the motion of body '{name}' has other columns than the machine given for it: "
                "give the machine of the motion itself; if its bodies are reduced again, columns can have "
                "other signs"
            )
        return then.body

    def _contacts(self, system: System) -> tuple[Contact | SurfaceContact, ...]:
        """The contacts, with moving obstacles at their positions and velocities at the start time."""
        rigid = system.rigid_contacts
        if not any(is_moving(each.obstacle) for each in rigid):
            return tuple(system.contacts)
        known = self.solution.series.get(OBSTACLES, np.zeros((len(self.times), 0)))[self.row].reshape(
            -1, 2, 3
        )
        if len(known) != len(rigid):
            raise ModelError(
                f"the machine has {len(rigid)} contacts with rigid obstacles, of which some move, and the "
                f"motion to start from has {len(known)}: give the contacts of the motion in their order, so "
                "that the obstacles continue from their positions"
            )
        states = iter(known * np.array([[self.length], [self.length / self.duration]]))
        return tuple(
            replace(each, obstacle=moved(each.obstacle, *next(states))) if isinstance(each, Contact) else each
            for each in system.contacts
        )

    def _goes_on(self, controller: AnyController) -> AnyController:
        """The controller with its states and joint angles at the end of the motion, if the start is there.

        If the start is at an earlier time, the controller is unchanged.
        """
        is_traced = isinstance(controller, Controller)
        kept = kept_states(self.solution.engine_state, controller) if is_traced else None
        if kept is not None and self.row == len(self.solution.times) - 1:
            states, angles = kept[0], iter(kept[1].tolist())
            reads = {
                name: replace(each, near=next(angles)) if isinstance(each, JointReading) else each
                for name, each in controller.reads.items()
            }
            return replace(controller, initial=states, reads=reads)
        revolved = kept is not None and bool(np.any(np.abs(kept[1]) > np.pi))
        if not is_traced or len(controller.initial) or revolved:
            warnings.warn(
                f"controller '{controller.name}' restarts from its initial state: controller states, and "
                "revolutions of the joint angles that controllers read, are stored by the names of the "
                "controllers, at the end of a run only. A sampled controller continues by --resume only",
                StartWarning,
                stacklevel=4,
            )
        return controller


def _warn(losses: Mapping[str, ProjectionLoss]) -> None:
    for name, loss in losses.items():
        if max(loss.relative, loss.rate) >= LARGEST_ERROR:
            warnings.warn(
                f"body '{name}': its basis lacks {100 * loss.relative:.2g} % of the initial "
                f"deformation ({loss.rms:.2g} RMS) and {100 * loss.rate:.2g} % of its rates, in the mass "
                "norm: keep more modes, or the basis of the motion",
                BasisWarning,
                stacklevel=4,
            )
