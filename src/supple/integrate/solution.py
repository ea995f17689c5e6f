"""Result of a simulation: the motion of every body at the output times, and its cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from supple.errors import ModelError
from supple.integrate.error_statement import ErrorPart, ErrorStatement
from supple.integrate.motion import FloatingMotion, Motion
from supple.summary import Summarized, Summary, listed

__all__ = ["JOINT_AXES", "JOINT_COMPONENTS", "Solution", "Statistics", "concatenate"]

_M = TypeVar("_M", bound=Motion)

JOINT_COMPONENTS = ("force x", "force y", "force z", "moment x", "moment y", "moment z")
"""Columns of the forces of a joint."""
JOINT_AXES = "joint axes that rotate with the first end, z along the axis of the joint"
"""Axes of `JOINT_COMPONENTS`."""


@dataclass(frozen=True)
class Statistics:
    """Cost of a run, and measures of its step size.

    steps, iterations, rejected_steps : numbers of accepted steps, Newton iterations and rejected steps
    seconds, compile_seconds : run time without compilation, and compilation time
    largest_error : largest local error of an accepted step, as defined for `AdaptiveStep`
    largest_turn : largest rotation of a body within an accepted step, rad
    factorizations : number of factored tangents; 0 if the engine does not count them
    decades : reduction of the residual by all iterations together, in powers of ten; 0 if not counted
    """

    steps: int = 0
    iterations: int = 0
    rejected_steps: int = 0
    seconds: float = 0.0
    compile_seconds: float = 0.0
    largest_error: float = 0.0
    largest_turn: float = 0.0
    factorizations: int = 0
    decades: float = 0.0

    @property
    def contraction(self) -> float | None:
        """Geometric mean of the residual ratio of two successive iterates; None if not counted."""
        return 10 ** (-self.decades / self.iterations) if self.iterations and self.decades else None

    def __add__(self, other: Statistics) -> Statistics:
        def joined(name: str) -> Any:
            own, others = getattr(self, name), getattr(other, name)
            return max(own, others) if name in LARGEST else own + others

        return Statistics(*(joined(f.name) for f in fields(self)))


LARGEST = ("largest_error", "largest_turn")
"""Statistics whose maximum over the parts of a run is taken; all other statistics are summed."""


@dataclass(frozen=True, repr=False)
class Solution(Summarized):
    """Results of a simulation, or of a completed part of it."""

    times: np.ndarray
    """(t,) output times."""
    bodies: Mapping[str, Motion]
    """Motion of each body by name; its type depends on the form of the body (see `motion`)."""
    joint_forces: Mapping[str, np.ndarray]
    """Joint name to (t, 6) force and moment on the joint's second end, at that end's point: x, y, z of the
    force, then of the moment, along the joint axes that rotate with the first end (z is the joint's axis)."""
    statistics: Statistics
    stopped: str | None = None
    """Cause if the run ended before its last output time; None for a complete run."""
    engine_state: Mapping[str, np.ndarray] = field(default_factory=lambda: MappingProxyType({}))
    """State of the engine beyond the motion, to continue exactly from the last output time; empty if
    unknown."""
    multipliers: Mapping[str, np.ndarray] = field(default_factory=lambda: MappingProxyType({}))
    """Joint name to (t, m) Lagrange multipliers of its constraint equations, with the order, signs and units
    of the engine. Empty for an engine without multipliers."""
    series: Mapping[str, np.ndarray] = field(default_factory=lambda: MappingProxyType({}))
    """Name to (t, c) quantities of the whole machine, such as its energies; the method determines which."""
    errors: Mapping[str, ErrorStatement] = field(default_factory=lambda: MappingProxyType({}))
    """Error of the run, by body or by quantity of interest; empty if it was not estimated."""
    truncation: Mapping[str, ErrorPart] = field(default_factory=lambda: MappingProxyType({}))
    """By intrinsic body: the error due to its omitted modes, estimated at the end of the run; empty after
    `read_solution`, because result files do not contain the machine."""
    columns: Mapping[str, Mapping[str, Sequence[float]]] = field(default_factory=lambda: MappingProxyType({}))
    """By elastic body: numbers that identify the columns of its basis; empty if unknown."""

    def summary(self) -> Summary:
        """Times, bodies, joints, cost and error."""
        cost = self.statistics
        span = f"{self.times[0]:g} to {self.times[-1]:g}" if self.times.size else "none"
        rows = [
            ("times", f"{self.times.size}, {span}"),
            ("bodies", listed(f"{name} ({motion.kind})" for name, motion in self.bodies.items())),
            ("joints", listed(self.joint_forces)),
            ("cost", f"{cost.steps} steps, {cost.iterations} iterations, {cost.seconds:.3g} s"),
        ]
        rows += [] if self.stopped is None else [("stopped", self.stopped)]
        rows += [
            (f"error of {name}", f"{'at least ' if error.missing else ''}{error.at_least:.2g}, of {error.of}")
            for name, error in self.errors.items()
        ]
        return Summary(f"Solution of {len(self.bodies)} bodies at {self.times.size} times", rows)

    def motion(self, body: str, expected: type[_M]) -> _M:
        """The motion of a body with its type: `solution.motion("blade", FloatingMotion).coordinates`.

        Raises ModelError for a body that the solution does not have, and for a motion of another type.
        """
        if body not in self.bodies:
            raise ModelError(f"no body '{body}' in the solution; it has {', '.join(self.bodies) or 'none'}")
        return self.bodies[body].of_type(expected, f"body '{body}'")

    def with_errors(self, errors: Mapping[str, ErrorStatement]) -> Solution:
        """A copy with the given error estimates, also stored as `error` in the floating motions of bodies."""

        def assessed(name: str, motion: Motion) -> Motion:
            known = isinstance(motion, FloatingMotion) and name in errors
            return motion.with_error(errors[name]) if known else motion

        return replace(
            self,
            bodies={name: assessed(name, motion) for name, motion in self.bodies.items()},
            errors=dict(errors),
        )

    def at(self, rows: slice | np.ndarray) -> Solution:
        """The solution at the output times with the indices `rows`.

        The statistics are those of the whole run; `stopped`, `engine_state` and `truncation` are omitted.
        """
        return Solution(
            times=self.times[rows],
            bodies={name: motion.at(rows) for name, motion in self.bodies.items()},
            joint_forces={name: forces[rows] for name, forces in self.joint_forces.items()},
            statistics=self.statistics,
            multipliers={name: own[rows] for name, own in self.multipliers.items()},
            series={name: own[rows] for name, own in self.series.items()},
            errors=self.errors,
            columns=self.columns,
        )


def concatenate(parts: Sequence[Solution]) -> Solution:
    """One solution from consecutive parts with the same bodies and joints and without repeated times.

    `stopped` and `engine_state` are those of the last part; errors, truncation and columns are omitted.
    Raises ValueError if there are no parts.
    """
    if not parts:
        raise ValueError("no parts to join: a solution needs at least one chunk of output times")

    def joined(name: str) -> Motion:
        motions = [part.bodies[name] for part in parts]
        arrays = [motion.arrays() for motion in motions]
        return type(motions[0])(**{key: np.concatenate([own[key] for own in arrays]) for key in arrays[0]})

    def stacked(of: str) -> dict[str, np.ndarray]:
        return {
            name: np.concatenate([getattr(part, of)[name] for part in parts])
            for name in getattr(parts[0], of)
        }

    first, last = parts[0], parts[-1]
    return Solution(
        times=np.concatenate([part.times for part in parts]),
        bodies={name: joined(name) for name in first.bodies},
        joint_forces=stacked("joint_forces"),
        statistics=sum((part.statistics for part in parts), Statistics()),
        stopped=last.stopped,
        engine_state=last.engine_state,
        multipliers=stacked("multipliers"),
        series=stacked("series"),
    )
