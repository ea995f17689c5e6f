"""Equilibrium of the full equations at a time of a reduced run, by modified Newton's method.

With the residual r of the full equations at the run's expanded state (`residual_correction`), the frame
conditions D and the joint equations g, the missing motion delta satisfies

    r( q + delta, accelerations + delta / p ) = 0,      D delta = 0,      g( q + delta ) = 0

with the run's velocities and time; p is the ratio of displacement to acceleration. One Newton step is enough
where the body responds linearly. Elsewhere one step can be wrong by 100 % and even have the wrong sign.
An example is the wall of a shell that is pulled straight or about to buckle. Wrong directions do not improve
a basis.

The solution at one time is the start value at the next: missing motion grows from zero and is followed as it
grows. A shell whose walls buckle has several equilibria close together, and the motion follows one of them.
If sample times are far apart, the search leaves this equilibrium (61.5 m blade at 8 rad/s: at intervals of
0.6 s, but not of 0.2 s). At intermediate times a relative correction of a tenth is accurate enough, because
the search at the next sample time has the strict tolerance again. A tangent is used again at later times
while it reduces every correction to 0.3 of the previous one or less.

Not all sample times need intermediate times. The iteration from the last solution is a contraction if one
tangent reduces every correction to 0.3 of the previous one or less. Its limit is then the only solution
nearby, which the search along intermediate times would also find. Otherwise the motion is followed along the
intermediate times.
Source: original to this project.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from supple.errors import AccuracyError
from supple.integrate import StepFactors
from supple.methods.floating.full.frozen_tangent import FrozenTangent, frozen_tangent
from supple.methods.floating.full.full_state import Evaluation, FullState
from supple.methods.floating.full.full_system import FullSystem

CONVERGED = 1e-3
"""Convergence tolerance: ratio of the last correction to the motion found."""
FOLLOWED = 0.1
"""Convergence tolerance at intermediate times: the same ratio."""
IRRELEVANT = 1e-7
"""Ratio of a correction to the deformation; a smaller correction is always the last."""
FAST, SLOW = 0.3, 0.8
"""Ratios of a correction to the previous one. Above `FAST` the frozen tangent is discarded. Above `SLOW` a
correction with an old tangent is repeated with a new one; the second correction above `SLOW` with a new
tangent ends the search."""
MOST_CORRECTIONS = 12
MOST_RELAXATIONS = 4
"""Largest number of searches by `_relaxed` in one run: each needs many factorisations."""
MOST_STEPS_DOWNHILL = 16
HEAVIER = 1e4
"""Factor on the inertia M / p in the first downhill step."""
LARGEST_MOVE = 0.02
"""Largest ratio of a downhill step to the deformation."""


@dataclass(frozen=True, eq=False)
class MissingMotion:
    """Change of a state that leads to equilibrium.

    displacement : (n,)                     of all degrees of freedom; for each body those of its frame first
    multipliers, frame_multipliers :        changes of the joint forces and of the frame forces of full bodies
    """

    displacement: np.ndarray
    multipliers: np.ndarray
    frame_multipliers: tuple[np.ndarray, ...]

    def __add__(self, more: MissingMotion) -> MissingMotion:
        """The sum of two changes."""
        frames = zip(self.frame_multipliers, more.frame_multipliers, strict=True)
        return MissingMotion(
            self.displacement + more.displacement,
            self.multipliers + more.multipliers,
            tuple(own + other for own, other in frames),
        )


Search = Callable[[FullState, MissingMotion, float], MissingMotion | None]


class MissingMotionSearch:
    """Finds the missing motion at ascending times; each search starts from the last solution and tangent.

    machine : FullSystem
    by_position : float     p, the ratio of displacement to acceleration; large for slow motion
    """

    def __init__(self, machine: FullSystem, by_position: float) -> None:
        self._machine = machine
        self._by_position = by_position
        self._last: MissingMotion | None = None
        self._tangent: FrozenTangent | None = None
        self._relaxations = 0
        self.factorizations = 0
        self.singular: AccuracyError | None = None
        """The error of the last tangent that could not be factored."""

    def at(self, state: FullState, tolerance: float = CONVERGED) -> MissingMotion | None:
        """Missing motion at a state; None where no search converges, or the tangents are singular.

        tolerance : float     largest last correction, relative to the motion found
        """
        for search, begin in self._searches(state):
            try:
                found = search(state, begin, tolerance)
            except AccuracyError as error:
                self.singular, self._tangent = error, None
                continue
            if found is not None:
                self._last = found
                return found
        return None

    def directly(self, state: FullState, tolerance: float = CONVERGED) -> MissingMotion | None:
        """Missing motion by iteration from the last solution; None if it does not contract or is singular."""
        begin = self._beginning(state)
        for _ in range(2 if self._tangent is not None else 1):
            try:
                found = self._contracted(state, begin, tolerance)
            except AccuracyError:
                # The search at the intermediate times then reports the singular tangent.
                found = None
            if found is not None:
                self._last = found
                return found
            self._tangent = None
        return None

    def response(self, state: FullState, forces: Mapping[str, np.ndarray]) -> MissingMotion:
        """Linear response to forces (n,) on full bodies, by name; joint and frame constraints hold.

        The existing residual of the state is not included.
        """
        evaluation = self._evaluated(state, self._none(state))
        tangent = self._factored(evaluation, self._by_position)
        left = []
        for interior in self._machine.interiors:
            own = forces.get(interior.full.name, np.zeros(interior.full.n_coordinates))
            left.append(np.concatenate([np.zeros(6), own]))
        on_border = np.zeros_like(evaluation.border.inertia)
        return self._more(evaluation.left_with(on_border, tuple(left)), tangent)

    def _searches(self, state: FullState) -> Iterator[tuple[Search, MissingMotion]]:
        begin = self._beginning(state)
        if self._last is not None:
            yield self._corrected, begin
        yield self._corrected, self._none(state)
        if self._relaxations < MOST_RELAXATIONS:
            self._relaxations += 1
            yield self._relaxed, begin

    def _none(self, state: FullState) -> MissingMotion:
        return MissingMotion(
            np.zeros(self._machine.n),
            np.zeros_like(state.multipliers),
            tuple(np.zeros(6) for _ in self._machine.interiors),
        )

    def _beginning(self, state: FullState) -> MissingMotion:
        """Start value: the last deformation, with zero motion and forces of frames: they have moved since."""
        none = self._none(state)
        if self._last is None:
            return none
        deformation = self._last.displacement.copy()
        for part in self._machine.slices:
            deformation[part.start : part.start + 6] = 0.0
        return replace(none, displacement=deformation)

    def _contracted(self, state: FullState, begin: MissingMotion, tolerance: float) -> MissingMotion | None:
        """Modified Newton's method with one tangent; None where corrections shrink too slowly."""
        at, before = begin, np.inf
        for _ in range(MOST_CORRECTIONS):
            more = self._by_frozen_tangent(self._evaluated(state, at))
            size = self._size(more)
            rate, before = size / before, size
            if not rate <= FAST:
                return None
            at = at + more
            # The next correction is smaller by the same ratio; after the first one, `FAST` is assumed.
            if (rate or FAST) * size <= self._last_correction(state, at, tolerance):
                return at
        return None

    def _corrected(self, state: FullState, begin: MissingMotion, tolerance: float) -> MissingMotion | None:
        """Modified Newton's method; None where it does not converge."""
        at, before, strikes = begin, np.inf, 0
        for _ in range(MOST_CORRECTIONS):
            new = self._tangent is None
            more = self._by_frozen_tangent(self._evaluated(state, at))
            size = self._size(more)
            rate, before = size / before, size
            if not np.isfinite(size):
                return None
            if rate > FAST:
                self._tangent = None
                strikes += new and rate > SLOW
                if strikes > 1:
                    return None
                if not new and rate > SLOW:
                    # The frozen tangent is too old: repeat from the same state with a new one.
                    before = np.inf
                    continue
            at = at + more
            # Where corrections shrink fast, the next one would be smaller by the same ratio, which is unknown
            # after the first one.
            left = rate * size if 0.0 < rate < FAST else size
            if left <= self._last_correction(state, at, tolerance):
                return at
        return None

    def _relaxed(self, state: FullState, begin: MissingMotion, tolerance: float) -> MissingMotion | None:
        """Implicit steps that reduce the energy, become Newton steps and end in a stable equilibrium."""
        limit = LARGEST_MOVE * self._deformation(state)
        at, by_position = begin, self._by_position / HEAVIER
        self._tangent = None
        for _ in range(MOST_STEPS_DOWNHILL):
            evaluation = self._evaluated(state, at)
            more = self._more(evaluation, self._factored(evaluation, by_position))
            size = self._size(more)
            if not np.isfinite(size):
                return None
            if size > limit:
                by_position *= 0.5 * limit / size
                continue
            at = at + more
            if by_position == self._by_position and size <= self._last_correction(state, at, tolerance):
                return at
            by_position = min(by_position * float(np.clip(limit / size, 2.0, 100.0)), self._by_position)
        return None

    def moved(self, state: FullState, by: MissingMotion) -> FullState:
        """A state with missing motion added, and the corresponding accelerations."""
        frame_multipliers = tuple(
            own + more for own, more in zip(state.frame_multipliers, by.frame_multipliers, strict=True)
        )
        return state._replace(
            configuration=self._machine.moved(state.configuration, by.displacement),
            acceleration=state.acceleration + by.displacement / self._by_position,
            multipliers=state.multipliers + by.multipliers,
            frame_multipliers=frame_multipliers,
        )

    def _evaluated(self, state: FullState, by: MissingMotion) -> Evaluation:
        return self._machine.evaluate(self.moved(state, by), 0.0)

    def _by_frozen_tangent(self, evaluation: Evaluation) -> MissingMotion:
        """A correction with the frozen tangent, or with a new one at this state, which is then frozen."""
        if self._tangent is None:
            self._tangent = self._factored(evaluation, self._by_position)
        return self._more(evaluation, self._tangent)

    def _more(self, evaluation: Evaluation, tangent: FrozenTangent) -> MissingMotion:
        """A correction of the missing motion."""
        by_position = tangent.factors.by_position
        targets = evaluation.closing(by_position)
        step, multipliers, frame_multipliers = self._machine.correction_behind(
            tangent.eliminations, evaluation, targets, np.zeros(self._machine.n), tangent.factors
        )
        return MissingMotion(by_position * step, multipliers, frame_multipliers)

    def _size(self, motion: MissingMotion) -> float:
        return float(np.linalg.norm(motion.displacement / self._machine.position_scale))

    def _last_correction(self, state: FullState, found: MissingMotion, tolerance: float) -> float:
        """Largest size of a correction that counts as converged."""
        return max(tolerance * self._size(found), IRRELEVANT * self._deformation(state))

    def _factored(self, at: Evaluation, by_position: float) -> FrozenTangent:
        """Frozen symmetric part of the tangent; the whole tangent if that part cannot be factored."""
        factors = StepFactors(by_position=by_position, by_velocity=0.0)
        still = np.zeros((len(self._machine.interiors), 3))
        self.factorizations += 1
        try:
            return frozen_tangent(self._machine, at.interior_states, still, factors, symmetric=True)
        except AccuracyError:
            self.factorizations += 1
            return frozen_tangent(self._machine, at.interior_states, still, factors, symmetric=False)

    def _deformation(self, state: FullState) -> float:
        machine = self._machine
        parts = zip(machine.slices, machine.coordinate_slices, strict=True)
        scaled = [
            state.configuration.coordinates[own] / machine.position_scale[part][6:] for part, own in parts
        ]
        return float(np.linalg.norm(np.concatenate(scaled)))
