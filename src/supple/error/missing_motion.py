"""The motion that balances the full equations at an instant of a reduced run: modified Newton's method.

Of the residual r at the run's expanded state (`residual_correction`), the missing motion delta is that which

    r( q + delta, accelerations + delta / p ) = 0,      D delta = 0,      g( q + delta ) = 0

with the run's velocities and time. One Newton step is enough where the body answers linearly. Where it does
not, as the wall of a shell that is pulled straight or about to buckle, one step can be wrong by its own size
and even point the other way; a basis enriched by such directions does not get better.

The answer at one instant is where the search at the next begins: missing motion grows from nothing, and is
followed as it grows. A shell whose walls buckle has several equilibria close together, of which the motion
takes one; instants far apart lose it (on the 61.5 m blade at 8 rad/s those 0.6 s apart do, 0.2 s do not).
Where it is only followed, a tenth is near enough: the next search begins from there and ends as strictly.
Tangents are kept from instant to instant while a correction with them leaves less than a third.

Not all instants need the others between. Where every correction from the last answer on, by one tangent, is
less than a third of the one before, the iteration contracts all the way, and the answer is the only one in
reach: the one that following would have led to. Otherwise the motion is followed from there.
Source: this project's own.
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

__all__ = ["CONVERGED", "FOLLOWED", "MissingMotion", "MissingMotionSearch"]

CONVERGED = 1e-3
"""A correction over the motion found, below which it is the last."""
FOLLOWED = 0.1
"""The same at instants that are only on the way to others."""
IRRELEVANT = 1e-7
"""Of the deformation itself: a correction as small is the last, whatever the motion found."""
FAST, SLOW = 0.3, 0.8
"""What a correction may be over the one before, with a frozen tangent and with a new one."""
MOST_CORRECTIONS = 12
MOST_RELAXATIONS = 4
"""Of one run: they take many factors, and a run that needs more is far off."""
MOST_STEPS_DOWNHILL = 16
HEAVIER = 1e4
"""How much more inertia the first step downhill has."""
LARGEST_MOVE = 0.02
"""Of a step downhill, over the deformation."""


@dataclass(frozen=True, eq=False)
class MissingMotion:
    """What balances a state.

    displacement : (n,)                     of all freedoms of the machine, in each body its frame's first
    multipliers, frame_multipliers :        changes of the forces of joints and of full bodies' frames
    """

    displacement: np.ndarray
    multipliers: np.ndarray
    frame_multipliers: tuple[np.ndarray, ...]

    def __add__(self, more: MissingMotion) -> MissingMotion:
        """Both together."""
        frames = zip(self.frame_multipliers, more.frame_multipliers, strict=True)
        return MissingMotion(
            self.displacement + more.displacement,
            self.multipliers + more.multipliers,
            tuple(own + other for own, other in frames),
        )


Search = Callable[[FullState, MissingMotion, float], MissingMotion | None]


class MissingMotionSearch:
    """Finds the missing motion at instant after instant, ascending; keeps the last answer and tangent.

    machine : FullSystem
    by_position : float     p: accelerations times it are displacements slow against any vibration
    """

    def __init__(self, machine: FullSystem, by_position: float) -> None:
        self._machine = machine
        self._by_position = by_position
        self._last: MissingMotion | None = None
        self._tangent: FrozenTangent | None = None
        self._relaxations = 0
        self.factorizations = 0
        self.singular: AccuracyError | None = None
        """What the last tangent that could not be factored was refused for."""

    def at(self, state: FullState, tolerance: float = CONVERGED) -> MissingMotion | None:
        """What balances a state; None where no search converges, or the tangents are singular.

        tolerance : float     part of the motion found that the last correction may have
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
        """The same where the iteration contracts all the way from the last answer; None where it does not."""
        begin = self._beginning(state)
        for _ in range(2 if self._tangent is not None else 1):
            try:
                found = self._contracted(state, begin, tolerance)
            except AccuracyError:
                # The search that follows the loads finds whether the tangent is singular on the way, too.
                found = None
            if found is not None:
                self._last = found
                return found
            self._tangent = None
        return None

    def response(self, state: FullState, forces: Mapping[str, np.ndarray]) -> MissingMotion:
        """What further forces (n,) on full bodies, by name, do to first order; joints and frames are held.

        What is out of balance besides is left so.
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
        """The last deformation alone: frames have moved on since, and the directions of forces with them."""
        none = self._none(state)
        if self._last is None:
            return none
        deformation = self._last.displacement.copy()
        for part in self._machine.slices:
            deformation[part.start : part.start + 6] = 0.0
        return replace(none, displacement=deformation)

    def _contracted(self, state: FullState, begin: MissingMotion, tolerance: float) -> MissingMotion | None:
        """Modified Newton's method with one tangent; None where corrections do not shrink fast at once."""
        at, before = begin, np.inf
        for _ in range(MOST_CORRECTIONS):
            more = self._by_frozen_tangent(self._evaluated(state, at))
            size = self._size(more)
            rate, before = size / before, size
            if not rate <= FAST:
                return None
            at = at + more
            # The next correction is smaller by the same rate; of the first none is known.
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
                    # The old tangent led astray: the same place once more with its own.
                    before = np.inf
                    continue
            at = at + more
            # Where corrections shrink fast, the next one would be smaller by the same rate; of the first, no
            # rate is known.
            left = rate * size if 0.0 < rate < FAST else size
            if left <= self._last_correction(state, at, tolerance):
                return at
        return None

    def _relaxed(self, state: FullState, begin: MissingMotion, tolerance: float) -> MissingMotion | None:
        """Downhill, by implicit steps that grow into Newton's: into an equilibrium that is stable."""
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
        """A state with missing motion added, and the accelerations of that."""
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
        """A correction by the tangent that is kept, or by that of this place, which is kept from then on."""
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
        """Size of a correction that is the last."""
        return max(tolerance * self._size(found), IRRELEVANT * self._deformation(state))

    def _factored(self, at: Evaluation, by_position: float) -> FrozenTangent:
        """The symmetric part, all but the whole at rest; that, where it has no factor without pivots."""
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
