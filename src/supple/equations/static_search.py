"""Search for a static equilibrium: damped descent that becomes Newton's method.

At rest the equations of motion are `f(q) + G(q)^T lambda = Q(t, q)`, `g(q, t) = 0`. Each iteration is one
implicit step of length `k` down the potential, in the mass norm,

    ( M / k + K(q) ) dq + G^T dlambda = - residual,      G dq = - g,

in the form of a time step: with `dq = k x`, `M + k K` is the tangent of a step whose factors are `(k, 0)`.
States of controllers, whose rates vanish at rest, take a step of `sqrt(k)` in time,

    ( 1 / sqrt(k) - E_z ) dz - ( E_p + E_v / sqrt(k) ) dq = f(q, z),

and their forces `H dz` enter the first equation.
Small k follow the descent to the next stable equilibrium, large k are Newton's method. The step is limited so
that no point moves far at once, and so that the matrix of an unsupported body can be factored.

If the search fails, as for shells whose walls wrinkle on the way, load and rotation are increased in steps.
At a share s the machine rotates at s times its rate, and 1 - s times the unbalanced forces at the start, at
rest, are subtracted. Each search begins at the equilibrium of the share before.
Source: pseudo-transient continuation, [KelleyKeyes1998]; natural parameter continuation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol, Self

import numpy as np

from supple.arguments import check_fields
from supple.arrays import AnyArray
from supple.equations.configuration import Configuration
from supple.equations.machine_model import Model
from supple.errors import AccuracyError, ConvergenceError
from supple.integrate import Solution

__all__ = ["StaticSearch"]

_KINDS = ("forces", "moments", "deformation")
"""Kinds of residuals, in the order of `EquilibriumResidual.relative`."""

_NONE = np.zeros(0)

_LONGEST = 1e100
"""Step of Newton's method."""

_FASTEST = 100.0
"""Largest ratio of a step to the one before."""
_LOST = 30.0
"""Ratio of a residual to the smallest earlier one, above which a search is stopped."""
_FAR = 0.3
"""Residual below which a search is not stopped."""
_WORSE = 10.0
"""Largest growth of the residual in an accepted step of the continuation."""
_SHORTEST = 1e-4
"""Length of a step, relative to the first step, below which steps are not rejected."""
_AFTER_REVOLUTION = 20
"""Iterations in addition to those of a full revolution by the largest moves (a beam rolled up by a moment). A
direct search that needs more is stopped, and load and rotation are increased in steps instead."""
_OF_A_SHARE = 12
"""Largest number of iterations per share."""
_FIRST_SHARE, _SMALLEST_SHARE = 0.25, 1 / 256
"""First increase of the share of load and rotation; increase below which the continuation is stopped."""
_WANTED = 5
"""Target number of iterations per share: the next increase is larger or smaller in proportion."""
_SLOWER, _FASTER = 0.5, 1.5
"""Smallest and largest ratio of the next increase to a successful one."""
_ON_THE_WAY = 1e-6
"""Relative residual of intermediate equilibria, unless `StaticSearch.residual` is larger."""

ROUND_OFF = 1e-4
"""Smallest reference of a residual of one kind, relative to the largest terms of all kinds, and to the
inertia forces of a rotating machine; all are expressed as work in a large motion. The limit applies where all
terms of a kind are rounding errors, such as the moments of a hanging rod."""


@dataclass(frozen=True)
class StaticSearch:
    """Convergence criteria and step limits of an equilibrium search.

    residual        : unbalanced force, moment and deformation, relative to the largest term in balance
    largest_move    : largest motion of a point in an iteration, relative to the size of the system; rotations
                      in rad
    max_iterations  : largest number of iterations of a search, before ConvergenceError
    Raises ValueError for a number that is not positive and finite, ArgumentError for a `max_iterations` that
    is not a whole number.
    """

    residual: float = 1e-9
    largest_move: float = 0.1
    max_iterations: int = 200

    def __post_init__(self) -> None:
        check_fields(self)
        for name in ("residual", "largest_move", "max_iterations"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise ValueError(f"{name} of a static search must be positive, got {value}")


class StaticState(NamedTuple):
    """A configuration and the forces in equilibrium with it."""

    configuration: Any
    """Configuration in the form of the method"""
    multipliers: AnyArray
    frame_multipliers: tuple[np.ndarray, ...] = ()
    """Multipliers of the frames of full bodies, (6,) each"""
    control: np.ndarray = _NONE
    """States of all controllers, one after the other"""


class EquilibriumResidual(NamedTuple):
    """Residuals of equilibrium."""

    relative: np.ndarray
    """Forces, moments, deformation, relative to the largest term of each, (3,)"""
    gap: float
    """Largest of the joints' and frames' equations, relative to the size of the system"""
    terms: Any
    """Data of the correction"""
    size: float = 0.0
    """Largest term in balance, as work in a large motion"""
    unrest: Mapping[str, float] = MappingProxyType({})
    """Relative rates of controller states, by a description of the state"""


class StaticStep(NamedTuple):
    """One implicit step."""

    increment: np.ndarray
    """Increment of the configuration, (n,)"""
    multipliers: np.ndarray
    frame_multipliers: tuple[np.ndarray, ...] = ()
    control: np.ndarray = _NONE
    """Change of the controllers' states"""
    climbs: bool = False
    """True if the tangent is known to have negative directions, so that the step may ascend"""


class Equations(Protocol):
    """The equations of a machine at rest, or in steady rotation, by one method.

    Vectors (n,) are those of the method. Statics, modes and batches use these members only.
    """

    @property
    def model(self) -> Model:
        """The model for joints and forces."""

    @property
    def slices(self) -> tuple[slice, ...]:
        """Positions of the motions of each body in the linear equations."""

    @property
    def is_discrete(self) -> bool:
        """Whether forces and inertia refer to different velocities, equal up to a discretisation error."""

    def start(self) -> StaticState:
        """The state with bodies as placed and without joint forces."""

    def unbalance(self, state: StaticState, time: float) -> EquilibriumResidual:
        """The residuals of equilibrium."""

    def residual(self, state: StaticState, time: float) -> np.ndarray:
        """Unbalanced forces of all freedoms, (n,)."""

    def correction(
        self, state: StaticState, time: float, unbalance: EquilibriumResidual, k: float
    ) -> StaticStep:
        """One implicit step of length k."""

    def at_rest(self) -> Self:
        """The machine without its rotation."""

    def eased(self, share: float, held: np.ndarray) -> Self:
        """The machine at a share of its angular velocity; the forces `held` (n,) are subtracted."""

    def moved(self, configuration: Any, increment: np.ndarray) -> Any:
        """The configuration after an increment (n,)."""

    def bodies_at(self, configuration: Any) -> Configuration:
        """Poses of the bodies, in their order."""

    def linear_equations(self, state: StaticState, time: float) -> Any:
        """The equations of motion, linearised about a state."""

    def constraint_rows(self, state: StaticState, time: float) -> np.ndarray:
        """Derivatives of the equations of joints, then of frames, by increments, (m, n)."""

    def solution(self, state: StaticState, time: float, iterations: int) -> Solution:
        """The steady motion at one instant."""

    @property
    def position_scale(self) -> np.ndarray:
        """Scale of a large change of each freedom, (n,)."""


def search_equilibrium(
    machine: Equations,
    state: StaticState,
    time: float,
    search: StaticSearch,
    progress: Callable[[int, float], None] = lambda *_: None,
) -> tuple[StaticState, int]:
    """The equilibrium reached by descent from a configuration with closed joints; number of iterations.

    If the direct search fails within the iterations of a full revolution, load and rotation are increased in
    steps. If this fails, too, the direct search is repeated with all iterations. Only the direct search is
    made if `max_iterations` does not exceed the iterations of a full revolution.

    progress : called with the iteration and the largest relative residual
    Raises ConvergenceError   no equilibrium found: an unsupported body, or loads beyond the strength of a
    body
    """
    enough = int(2 * np.pi / search.largest_move) + _AFTER_REVOLUTION
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
        try:
            report = partial(lambda before, i, left: progress(before + i, left), iterations)
            state, used = _downhill(eased, state, time, own, report, careful=True)
        except ConvergenceError:
            step, iterations = step / 2, iterations + most
            continue
        faster = min(max(_WANTED / max(used, 1), _SLOWER), _FASTER)
        share, step, iterations = asked, faster * (asked - share), iterations + used
    if share == 1:
        return state, iterations
    # A free rotating body first moves outwards before Newton's method converges, which needs all iterations.
    try:
        return _downhill(machine, begun, time, search, progress)
    except ConvergenceError:
        raise ConvergenceError(
            f"{direct}. Load and rotation, increased in steps, reached {share:.3g} of their values"
        ) from None


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
    """The equilibrium by descent in implicit steps; errors as for `search_equilibrium`.

    lost : ratio of a residual to the smallest earlier one above which the search stops
    careful : shorten steps after which the residual is far larger, as where membranes stiffen, and steps that
        ascend, as in Newton's method where walls are about to wrinkle
    """
    found = machine.unbalance(state, time)
    # Without stiffness a step moves by k times the initial acceleration: the first one is limited.
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
        # A move within rounding, in a step longer than the first, counts as converged as well: where all
        # terms of a kind vanish, the residual has no reference.
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
                    f"{iteration}. A user-defined law with a square root or a division at zero is the usual "
                    "cause: use jnp.where to replace its argument before the root"
                )
        state, found = moved, after
        growth = min(3 * growth, _FASTEST)
        k = min(k * float(np.clip(search.largest_move / max(move, 1e-300), 1.2, growth)), longest)
    if restless := _restless(found, search):
        raise ConvergenceError(
            f"no equilibrium at t = {time:g}: {restless}. An integrator rests only where its input vanishes: "
            "give it a reachable setpoint, add a leak (-z / T) to its rate, leave the "
            "controller out, replace(system, controllers=()), or simulate the motion"
        )
    worst = int(np.argmax(np.where(np.isfinite(found.relative), found.relative, np.inf)))
    raise ConvergenceError(
        f"no equilibrium at t = {time:g} after {iteration + 1} iterations: relative residual "
        f"{found.relative[worst]:.2g} in the {_KINDS[worst]}, last move {move:.2g} of the size. A body that "
        "is not supported, loads that no deformation can bear (buckling, a follower load with work on a "
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


def carried_state(machine: Equations, time: float, least_size: float = 0.0) -> tuple[StaticState, float]:
    """The state with bodies as placed and balancing joint forces, and the largest relative unbalance.

    least_size : least size of the forces, as work in a large motion, to which the unbalance is relative
    """
    state, weights = machine.start(), machine.position_scale
    found = machine.unbalance(state, time)
    unbalanced = weights * machine.residual(state, time)
    carried = weights[:, None] * machine.constraint_rows(state, time).T
    forces = np.linalg.lstsq(carried, -unbalanced, rcond=None)[0]
    left = float(np.linalg.norm(unbalanced + carried @ forces)) / (max(found.size, least_size) or 1.0)
    joints, frames = np.split(forces, [len(state.multipliers)])
    state = state._replace(multipliers=joints, frame_multipliers=tuple(frames.reshape(-1, 6)))
    return state, max(left, *found.unrest.values(), 0.0)


def _largest(found: EquilibriumResidual) -> float:
    """Largest relative residual, those of controllers included."""
    return float(np.max([*found.relative, *found.unrest.values()]))


def _restless(found: EquilibriumResidual, search: StaticSearch) -> str | None:
    """Description of the controller state farthest from rest; None if all are at rest."""
    worst = max(found.unrest, key=lambda name: np.nan_to_num(found.unrest[name], nan=np.inf), default=None)
    return worst if worst and not found.unrest[worst] <= search.residual else None
