"""A machine that goes on from an instant of an earlier motion, under other loads, steps or bases."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from supple.arguments import Positive, check_fields
from supple.body import BodyForm
from supple.errors import BasisWarning, ModelError, StartWarning, did_you_mean
from supple.integrate import FloatingMotion, FramedMotion, Motion, Solution
from supple.machine import Controller, Placed, System
from supple.methods.intrinsic.going_on import placed_as_moved
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion
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

SAME_TIME = 1e-6
"""Of the distance of output times."""


@dataclass(frozen=True, eq=False)
class StartedMachine:
    """A machine as it goes on.

    system : System             its bodies placed, moving and deformed as at the instant; run it with
        `Run(.., start=time)`, for laws go on with their time
    time : float                the instant
    losses : ProjectionLoss     of the bodies that stand on another basis, by name
    """

    system: System
    time: float
    losses: Mapping[str, ProjectionLoss]


@dataclass(frozen=True, eq=False)
class Start:
    """An instant of a motion, from which another machine of the same bodies goes on.

    solution : Solution         also one that was read from a file
    time : float | None         one of its output times; the last where None
    machine : System | None     that moved so: needed where a body goes on in another form or on another basis
    length, duration : float    units of length and time of the motion in those of the machine that goes on;
        the time is in the latter
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
        """Output times (t,) of the motion, in the unit of the machine that goes on."""
        return self.duration * self.solution.times

    @property
    def _is_scaled(self) -> bool:
        return (self.length, self.duration) != (1.0, 1.0)

    @property
    def row(self) -> int:
        """Number of the instant among the output times."""
        times = self.times
        if self.time is None:
            return len(times) - 1
        row = int(np.argmin(abs(times - self.time)))
        step = float(np.min(np.diff(times), initial=np.inf))
        allowed = SAME_TIME * (step if np.isfinite(step) else max(abs(self.time), 1.0))
        if not abs(times[row] - self.time) <= allowed:
            near = times[max(row - 1, 0) : row + 2]
            raise ModelError(
                f"a machine goes on from an output time, where its whole state is kept, and {self.time:g} is "
                f"none of {times[0]:g} to {times[-1]:g}: take one such as "
                + " or ".join(f"{each:.12g}" for each in near)
            )
        return row

    def place(self, system: System) -> StartedMachine:
        """The machine with its bodies as they were at the instant; bodies are matched by their names.

        On the columns that moved, positions, velocities and deformation are those of the instant. Points and
        axes of joints and forces stay those of the machine as it is placed. A body in another form or basis
        is projected in the mass norm, with its interfaces where they were (`carried_deformation`).
        Accelerations and joint forces are made anew, consistent, as a run begins: after that a run differs
        from one without a break by the order of its method.

        Raises
        ------
        ModelError      a body that did not move there, or with another mesh or form; explicit elements, whose
            plastic strain at each point no motion holds
        Warns BasisWarning of a body that loses 1 % or more, StartWarning of controllers that begin anew.
        """
        placed, losses = [], {}
        for each in system.bodies:
            moved, loss = self._placed(each)
            placed.append(moved)
            if loss is not None:
                losses[each.body.name] = loss
        _warn(losses)
        controllers = tuple(self._goes_on(number, own) for number, own in enumerate(system.controllers))
        found = replace(system, bodies=tuple(placed), controllers=controllers)
        return StartedMachine(found, float(self.times[self.row]), losses)

    def _placed(self, placed: Placed) -> tuple[Placed, ProjectionLoss | None]:
        name, known = placed.body.name, self.solution.bodies
        if name not in known:
            raise ModelError(
                f"body '{name}' has no motion to go on from{did_you_mean(name, known)}; there are: "
                f"{', '.join(known)}. Bodies are matched by name"
            )
        motion, body = known[name], placed.body
        same = self._is_same(placed, motion)
        if isinstance(motion, IntrinsicMotion) and body.kind == "intrinsic":
            if not same:
                raise ModelError(
                    f"body '{name}' goes on in the intrinsic modes that moved, and these are others: "
                    "condense it with the same modes, in the same units"
                )
            return placed_as_moved(placed, motion, self.row), None
        if not isinstance(motion, FloatingMotion) or not body.has_frame or body.kind == "intrinsic":
            raise ModelError(
                f"body '{name}' is {body.kind}, and its motion there is {motion.kind}: go on in the form "
                "that moved; explicit elements, whose plastic strain at each point no motion holds, by "
                "--resume"
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
        return replace(moved, coordinates=q, coordinate_rates=dq, **velocities), loss

    def _is_same(self, placed: Placed, motion: Motion) -> bool:
        """Whether coordinates mean the same; ModelError where that is not known."""
        name, here = placed.body.name, placed.body.n_coordinates
        there = motion.coordinates.shape[1] if isinstance(motion, FramedMotion) else -1
        if not here and not there:
            return True
        known = self.solution.columns or (measured_columns(self.machine) if self.machine else {})
        if not known and there == here:
            raise ModelError(
                f"nothing says of which basis the motion of body '{name}' is: name the machine that moved, "
                "Start(solution, time, machine)"
            )
        return there == here and not self._is_scaled and are_same_columns(known.get(name, {}), placed)

    def _state(self, motion: FloatingMotion) -> tuple[PlacedFrame, np.ndarray, np.ndarray]:
        """Pose and velocities of the frame in units of the machine, coordinates and rates in their own."""
        row, speed = self.row, self.length / self.duration
        state = PlacedFrame(
            self.length * motion.position[row],
            motion.rotation[row],
            speed * motion.velocity[row],
            motion.angular_velocity[row] / self.duration,
        )
        return state, motion.coordinates[row], motion.coordinate_rates[row]

    def _scaled(self, deformation: Deformation, dofs_per_node: int) -> Deformation:
        """In units of the machine: translations, and rotations, which have none."""
        units = np.ones(dofs_per_node)
        units[:3] = self.length
        nodal, rates = (each.reshape(-1, dofs_per_node) * units for each in deformation)
        return Deformation(nodal.ravel(), rates.ravel() / self.duration)

    def _body_that_moved(self, placed: Placed, size: int) -> BodyForm:
        name = placed.body.name
        if not (size and placed.body.n_coordinates):
            words = ("rigid", "elastic") if not size else ("elastic", "rigid")
            raise ModelError(
                f"body '{name}' was {words[0]} and is {words[1]} now: its deformation has nothing to go on "
                "from; keep its form"
            )
        if self.machine is None:
            raise ModelError(
                f"body '{name}' moved on {size} columns that are not those that it has now "
                f"({placed.body.n_coordinates}): name the machine that moved, Start(solution, time, "
                "machine), whose shapes are then projected on the new ones"
            )
        then = self.machine.placed(name, "start")
        if not then.body.has_frame or then.body.n_coordinates != size:
            raise ModelError(
                f"the motion of body '{name}' has {size} coordinates, and the machine that is named for it "
                f"{then.body.n_coordinates}: name the one that moved"
            )
        if self.solution.columns and not are_same_columns(self.solution.columns.get(name, {}), then):
            raise ModelError(
                f"the motion of body '{name}' is not of the columns that the machine named for it has: "
                "name the one that moved; reduced again, columns may have other signs"
            )
        return then.body

    def _goes_on(self, number: int, controller: Any) -> Any:
        """With the states of the motion's end, where it is gone on from there; else as it begins."""
        known = self.solution.engine_state if self.row == len(self.solution.times) - 1 else {}
        states = known.get(f"control.states.{number}")
        is_traced = isinstance(controller, Controller)
        if is_traced and states is not None and len(states) >= len(controller.initial):
            return replace(controller, initial=np.asarray(states)[: len(controller.initial)])
        if not is_traced or len(controller.initial):
            warnings.warn(
                f"controller '{controller.name}' begins anew: what it remembers is kept at the end of a run "
                "alone, and of sampled ones for --resume alone",
                StartWarning,
                stacklevel=4,
            )
        return controller


def _warn(losses: Mapping[str, ProjectionLoss]) -> None:
    for name, loss in losses.items():
        if max(loss.relative, loss.rate) >= LARGEST_ERROR:
            warnings.warn(
                f"body '{name}': its basis loses {100 * loss.relative:.2g} % of the deformation that it goes "
                f"on from ({loss.rms:.2g} RMS) and {100 * loss.rate:.2g} % of its rates, in the mass norm: "
                "keep more modes, or the basis that moved",
                BasisWarning,
                stacklevel=4,
            )
