"""Search for a static equilibrium: a damped way downhill that ends as Newton's method.

At rest the equations of motion leave `f(q) + G(q)^T lambda = Q(t, q)`, `g(q, t) = 0`. Each iteration takes
one implicit step of length `k` down the potential, in the mass norm,

    ( M / k + K(q) ) dq + G^T dlambda = - residual,      G dq = - g,

in the form of a time step: with `dq = k x`, `M + k K` is the tangent of a step whose factors are `(k, 0)`.
States of controllers, whose rates vanish at rest, take a step of `sqrt(k)` in time,

    ( 1 / sqrt(k) - E_z ) dz - ( E_p + E_v / sqrt(k) ) dq = f(q, z),

and their forces `H dz` stand in the first equation.
Small k follow the fall into the next stable equilibrium, large k are Newton's method. The step is so long
that no point moves far at once, and that the matrix of a body that nothing else holds can be factored.

Where that leads nowhere, as with shells whose walls wrinkle on the way, load and spin come up in steps: at a
share s the machine turns at s times its rate, and a part 1 - s of what is unbalanced at the start, without
spin, is held back. The equilibrium of one share is where the search at the next begins.
Source: pseudo-transient continuation, [KelleyKeyes1998]; natural parameter continuation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol, Self

import numpy as np

from supple.equations.configuration import AnyArray, Configuration
from supple.equations.machine_model import Model
from supple.errors import AccuracyError, ConvergenceError
from supple.integrate import Solution

__all__ = ["StaticSearch"]

_KINDS = ("forces", "moments", "deformation")

_NONE = np.zeros(0)

_LONGEST = 1e100
"""Step of Newton's method."""

_FASTEST = 100.0
"""What a step may be over the one before."""
_LOST = 30.0
"""What a residual may be over the smallest before: more, and the search has left the equilibrium near by."""
_FAR = 0.3
"""A residual below which no search is lost."""
_WORSE = 10.0
"""What it may be over the one before, of a step that is refused otherwise, on the way up in steps."""
_SHORTEST = 1e-4
"""Of the first step: no step is refused that is shorter."""
_ARRIVAL = 20
"""Iterations for what is left after a whole turn in the largest moves, as of a beam that a moment rolls up: a
direct search that takes more has lost its way, and load and spin are followed up in steps instead."""
_OF_A_SHARE = 12
"""Iterations with one share of them."""
_FIRST_SHARE, _SMALLEST_SHARE = 0.25, 1 / 256
_WANTED = 5
"""Iterations that a step should take: the next one is longer or shorter in proportion."""
_SLOWER, _FASTER = 0.5, 1.5
"""What the next step is at least and at most over one that was found."""
_ON_THE_WAY = 1e-6
"""Residual of equilibria that are only on the way."""

ROUND_OFF = 1e-4
"""Where all terms of a kind vanish, as the moments of a hanging rod do, rounding of the others is left: what
residuals are compared with is no less than this part of the largest kind, both as work in a large motion. Of
a machine that turns, all its inertia forces may be balanced: it is no less than this part of theirs."""


@dataclass(frozen=True)
class StaticSearch:
    """When an equilibrium is found, and how far an iteration may move.

    residual        : unbalanced force, moment and deformation, over the largest term in balance
    largest_move    : of any point in an iteration, over the size of the system; of any turn, rad
    max_iterations  : before giving up
    """

    residual: float = 1e-9
    largest_move: float = 0.1
    max_iterations: int = 200

    def __post_init__(self) -> None:
        for name in ("residual", "largest_move", "max_iterations"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise ValueError(f"{name} of a static search must be positive, got {value}")


class StaticState(NamedTuple):
    """A configuration and the forces that hold it."""

    configuration: Any
    """In the machine's own form"""
    multipliers: AnyArray
    frame_multipliers: tuple[np.ndarray, ...] = ()
    """Of full bodies, (6,) each"""
    control: np.ndarray = _NONE
    """States of all controllers, one after the other"""


class EquilibriumResidual(NamedTuple):
    """What is missing to an equilibrium."""

    relative: np.ndarray
    """Forces, moments, deformation, over the largest term of each, (3,)"""
    gap: float
    """Largest of the joints' and frames' equations, over the size of the system"""
    terms: Any
    """What the correction needs of it"""
    size: float = 0.0
    """Largest term in balance, as work in a large motion"""
    unrest: Mapping[str, float] = MappingProxyType({})
    """States of controllers, in words: their rates over the largest part of each"""


class StaticStep(NamedTuple):
    """One implicit step."""

    increment: np.ndarray
    """Of the configuration, (n,)"""
    multipliers: np.ndarray
    frame_multipliers: tuple[np.ndarray, ...] = ()
    control: np.ndarray = _NONE
    """Of the controllers' states"""
    climbs: bool = False
    """Known to go uphill: the tangent of the step has negative directions"""


class Equations(Protocol):
    """The equations of a machine at rest, or turning steadily, as one method has them.

    Its vectors (n,) are the method's own. Statics, modes and batches ask for nothing else.
    """

    @property
    def model(self) -> Model:
        """What joints and forces see of it."""
        ...

    @property
    def slices(self) -> tuple[slice, ...]:
        """Where the motions of each body stand in its linear equations."""
        ...

    @property
    def is_discrete(self) -> bool:
        """Whether forces act on velocities that differ from those that have mass, by what a mesh leaves."""
        ...

    def start(self) -> StaticState:
        """As its bodies are placed, without any force in the joints."""
        ...

    def unbalance(self, state: StaticState, time: float) -> EquilibriumResidual:
        """The residuals at rest."""
        ...

    def residual(self, state: StaticState, time: float) -> np.ndarray:
        """What is unbalanced in all freedoms, (n,)."""
        ...

    def correction(
        self, state: StaticState, time: float, unbalance: EquilibriumResidual, k: float
    ) -> StaticStep:
        """One implicit step of length k."""
        ...

    def at_rest(self) -> Self:
        """The machine without its spin."""
        ...

    def eased(self, share: float, held: np.ndarray) -> Self:
        """The machine at a share of its spin's rate, with forces (n,) held back."""
        ...

    def moved(self, configuration: Any, increment: np.ndarray) -> Any:
        """The configuration after an increment (n,)."""
        ...

    def bodies_at(self, configuration: Any) -> Configuration:
        """Where the bodies are, in their order."""
        ...

    def linear_equations(self, state: StaticState, time: float) -> Any:
        """The equations of motion, linearised about a state."""
        ...

    def constraint_rows(self, state: StaticState, time: float) -> np.ndarray:
        """Derivatives of the equations of joints, then of frames, by increments, (m, n)."""
        ...

    def solution(self, state: StaticState, time: float, iterations: int) -> Solution:
        """The steady motion at one instant."""
        ...

    @property
    def position_scale(self) -> np.ndarray:
        """What counts as a large change of each freedom, (n,)."""
        ...


def search_equilibrium(
    machine: Equations,
    state: StaticState,
    time: float,
    search: StaticSearch,
    progress: Callable[[int, float], None] = lambda *_: None,
) -> tuple[StaticState, int]:
    """The equilibrium downhill from a configuration whose joints are closed, and the iterations it took.

    Load and spin are followed up in steps where the direct search finds none in the iterations that a whole
    turn takes.
    progress : called with the iteration and the largest relative residual
    Raises ConvergenceError   none was found: nothing holds a body, or loads beyond what the bodies can bear
    """
    enough = int(2 * np.pi / search.largest_move) + _ARRIVAL
    if search.max_iterations <= enough:
        return _downhill(machine, state, time, search, progress)
    tried: list[int] = []

    def counted(iteration: int, residual: float) -> None:
        tried.append(iteration)
        progress(iteration, residual)

    try:
        direct_only = replace(search, max_iterations=enough)
        return _downhill(machine, state, time, direct_only, counted, lost=_LOST)
    except ConvergenceError as error:
        direct = error
    begun, held = state, machine.at_rest().residual(state, time)
    share, step, iterations = 0.0, _FIRST_SHARE, len(tried)
    while share < 1 and step >= _SMALLEST_SHARE and iterations < search.max_iterations:
        asked = min(share + step, 1.0)
        eased = machine.eased(asked, (1 - asked) * held)
        most = min(_OF_A_SHARE, search.max_iterations - iterations)
        residual = search.residual if asked == 1 else max(search.residual, _ON_THE_WAY)
        own = replace(search, residual=residual, max_iterations=most)
        report = partial(_counted, progress, iterations)
        try:
            state, used = _downhill(eased, state, time, own, report, careful=True)
        except ConvergenceError:
            step, iterations = step / 2, iterations + most
            continue
        faster = min(max(_WANTED / max(used, 1), _SLOWER), _FASTER)
        share, step, iterations = asked, faster * (asked - share), iterations + used
    if share == 1:
        return state, iterations
    # A free body that spins falls outwards before Newton's method brings it back: then only patience helps.
    try:
        return _downhill(machine, begun, time, search, progress)
    except ConvergenceError:
        raise ConvergenceError(
            f"{direct}. Load and spin, followed up in steps, came to {share:.3g} of what they are"
        ) from None


def _counted(progress: Callable[[int, float], None], before: int, iteration: int, residual: float) -> None:
    progress(before + iteration, residual)


def _downhill(
    machine: Equations,
    state: StaticState,
    time: float,
    search: StaticSearch,
    progress: Callable[[int, float], None],
    *,
    careful: bool = False,
    lost: float = np.inf,
) -> tuple[StaticState, int]:
    """The equilibrium downhill by implicit steps; errors as above.

    lost : what a residual may be over the smallest before, without giving up
    careful : shorten steps that leave far more than there was, as where membranes stiffen on the way, and
        those that go uphill, as Newton's method does where walls are about to wrinkle
    """
    found = machine.unbalance(state, time)
    # Without stiffness a step moves by k times the acceleration from rest: the first no further than allowed.
    scale = machine.position_scale
    fall = machine.correction(state, time, found, 1e-12).increment * 1e12
    k = search.largest_move / max(float(np.max(abs(fall) / scale, initial=0.0)), 1 / _LONGEST)
    first, move, longest, growth, best = k, np.inf, _LONGEST, _FASTEST, np.inf
    iteration = 0
    for iteration in range(search.max_iterations):
        largest = _largest(found)
        progress(iteration, largest)
        best = min(best, largest)
        if not np.isfinite(largest) or largest > max(lost * best, _FAR):
            break
        # A move that arithmetic cannot tell from none, in a step that went far from the start, is none too:
        # where the terms of a kind all vanish, what is left of them has no size to be compared with.
        stagnant = move <= 1e-13 and k >= first and _restless(found, search) is None
        if found.gap <= 1e-12 and (largest <= search.residual or stagnant):
            return state, iteration
        while True:
            try:
                change = machine.correction(state, time, found, k)
            except AccuracyError:
                k = longest = 0.1 * k
                continue
            if careful and change.climbs and k > _SHORTEST * first:
                k, growth = 0.3 * k, 1.0
                continue
            move = float(np.max(abs(change.increment) / scale))
            if move <= search.largest_move:
                moved = moved_state(machine, state, change)
                after = machine.unbalance(moved, time)
                worse = _largest(after) > _WORSE * max(largest, search.residual)
                if not (careful and worse and k > _SHORTEST * first):
                    break
                k, growth = 0.1 * k, 1.0
                continue
            k *= 0.5 * search.largest_move / move if np.isfinite(move) else 0.1
            if not k >= first / _LONGEST:
                raise ConvergenceError(
                    f"no equilibrium at t = {time:g}: derivatives of the forces are not finite in iteration "
                    f"{iteration}. A law of one's own with a square root or a division at zero is the usual "
                    "cause: jnp.where takes the other branch, before the root"
                )
        state, found = moved, after
        growth = min(3 * growth, _FASTEST)
        k = min(k * float(np.clip(search.largest_move / max(move, 1e-300), 1.2, growth)), longest)
    if restless := _restless(found, search):
        raise ConvergenceError(
            f"no equilibrium at t = {time:g}: {restless}. An integrator rests only where its input vanishes: "
            "let it follow what the machine can reach, let it leak (add -z / T to its rate), leave the "
            "controller out, replace(system, controllers=()), or simulate the motion"
        )
    worst = int(np.argmax(np.where(np.isfinite(found.relative), found.relative, np.inf)))
    raise ConvergenceError(
        f"no equilibrium at t = {time:g} after {iteration + 1} iterations: relative residual "
        f"{found.relative[worst]:.2g} in the {_KINDS[worst]}, last move {move:.2g} of the size. A body that "
        "nothing holds, loads that no deformation can bear (buckling, a follower load that does work on a "
        "round trip), or a basis without the nonlinear terms it needs are the usual causes"
    )


def moved_state(machine: Equations, state: StaticState, change: StaticStep) -> StaticState:
    """The state after a correction."""
    frames = zip(state.frame_multipliers, change.frame_multipliers, strict=True)
    return StaticState(
        machine.moved(state.configuration, change.increment),
        state.multipliers + change.multipliers,
        tuple(own + more for own, more in frames),
        state.control + change.control,
    )


def carried_state(machine: Equations, time: float) -> tuple[StaticState, float]:
    """As the bodies are placed, the joints carrying what is unbalanced; and what part they cannot."""
    state, weights = machine.start(), machine.position_scale
    found = machine.unbalance(state, time)
    unbalanced = weights * machine.residual(state, time)
    carried = weights[:, None] * machine.constraint_rows(state, time).T
    forces = np.linalg.lstsq(carried, -unbalanced, rcond=None)[0]
    left = float(np.linalg.norm(unbalanced + carried @ forces)) / (found.size or 1.0)
    joints, frames = np.split(forces, [len(state.multipliers)])
    state = state._replace(multipliers=joints, frame_multipliers=tuple(frames.reshape(-1, 6)))
    return state, max(left, *found.unrest.values(), 0.0)


def _largest(found: EquilibriumResidual) -> float:
    """Relative residual, of controllers too."""
    return float(np.max([*found.relative, *found.unrest.values()]))


def _restless(found: EquilibriumResidual, search: StaticSearch) -> str | None:
    """The state of a controller that is farthest from rest, in words; None where all rest."""
    worst = max(found.unrest, key=lambda name: np.nan_to_num(found.unrest[name], nan=np.inf), default=None)
    return worst if worst and not found.unrest[worst] <= search.residual else None
