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
Source: pseudo-transient continuation, Kelley & Keyes (1998).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np

from supple.errors import AccuracyError, ConvergenceError
from supple.multibody.equations.configuration import AnyArray, Configuration

__all__ = [
    "ROUND_OFF",
    "StaticCorrection",
    "StaticMachine",
    "StaticSearch",
    "StaticState",
    "Unbalance",
    "search_equilibrium",
]

_KINDS = ("forces", "moments", "deformation")

_NONE = np.zeros(0)

_LONGEST = 1e100
"""Step of Newton's method."""

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

    configuration: Configuration
    multipliers: AnyArray
    frame_multipliers: tuple[np.ndarray, ...] = ()
    """Of full bodies, (6,) each"""
    control: np.ndarray = _NONE
    """States of all controllers, one after the other"""


class Unbalance(NamedTuple):
    """What is missing to an equilibrium."""

    relative: np.ndarray
    """Forces, moments, deformation, over the largest term of each, (3,)"""
    gap: float
    """Largest of the joints' and frames' equations, over the size of the system"""
    terms: Any
    """What the correction needs of it"""
    unrest: Mapping[str, float] = MappingProxyType({})
    """States of controllers, in words: their rates over the largest part of each"""


class StaticCorrection(NamedTuple):
    """One implicit step."""

    increment: np.ndarray
    """Of the configuration, (n,)"""
    multipliers: np.ndarray
    frame_multipliers: tuple[np.ndarray, ...] = ()
    control: np.ndarray = _NONE
    """Of the controllers' states"""


M = TypeVar("M", bound="StaticMachine")


class StaticMachine(Protocol):
    """A machine at rest in the hands of one engine."""

    def unbalance(self, state: StaticState, time: float) -> Unbalance:
        """The residuals at rest."""
        ...

    def correction(self, state: StaticState, time: float, unbalance: Unbalance, k: float) -> StaticCorrection:
        """One implicit step of length k."""
        ...

    def moved(self, configuration: Configuration, increment: np.ndarray) -> Configuration:
        """The configuration after an increment (n,)."""
        ...

    @property
    def position_scale(self) -> np.ndarray:
        """What counts as a large change of each freedom, (n,)."""
        ...


def search_equilibrium(
    machine: StaticMachine,
    state: StaticState,
    time: float,
    search: StaticSearch,
    progress: Callable[[int, float], None] = lambda *_: None,
) -> tuple[StaticState, int]:
    """The equilibrium downhill from a configuration whose joints are closed, and the iterations it took.

    progress : hears of the iteration, and of the largest relative residual
    Raises ConvergenceError   none was found: nothing holds a body, or loads beyond what the bodies can bear
    """
    found = machine.unbalance(state, time)
    # Without stiffness a step moves by k times the acceleration from rest: the first no further than allowed.
    scale = machine.position_scale
    fall = machine.correction(state, time, found, 1e-12).increment * 1e12
    k = search.largest_move / max(float(np.max(abs(fall) / scale, initial=0.0)), 1 / _LONGEST)
    first, move, longest = k, np.inf, _LONGEST
    for iteration in range(search.max_iterations):
        largest = float(np.max([*found.relative, *found.unrest.values()]))
        progress(iteration, largest)
        if not np.isfinite(largest):
            break
        # A move that arithmetic cannot tell from none, in a step that went far from the start, is none too:
        # where the terms of a kind all vanish, what is left of them has no size to be compared with.
        settled = move <= 1e-13 and k >= first and _restless(found, search) is None
        if found.gap <= 1e-12 and (largest <= search.residual or settled):
            return state, iteration
        while True:
            try:
                change = machine.correction(state, time, found, k)
            except AccuracyError:
                k = longest = 0.1 * k
                continue
            move = float(np.max(abs(change.increment) / scale))
            if move <= search.largest_move:
                break
            k *= 0.5 * search.largest_move / move if np.isfinite(move) else 0.1
            if not k >= first / _LONGEST:
                raise ConvergenceError(
                    f"no equilibrium at t = {time:g}: derivatives of the forces are not finite in iteration "
                    f"{iteration}. A law of one's own with a square root or a division at zero is the usual "
                    "cause: jnp.where takes the other branch, before the root"
                )
        state = StaticState(
            machine.moved(state.configuration, change.increment),
            state.multipliers + change.multipliers,
            tuple(a + b for a, b in zip(state.frame_multipliers, change.frame_multipliers, strict=True)),
            state.control + change.control,
        )
        found = machine.unbalance(state, time)
        k = min(k * float(np.clip(search.largest_move / max(move, 1e-300), 1.2, 100.0)), longest)
    if restless := _restless(found, search):
        raise ConvergenceError(
            f"no equilibrium at t = {time:g}: {restless}. An integrator rests only where its input vanishes: "
            "let it follow what the machine can reach, let it leak (add -z / T to its rate), leave the "
            "controller out, replace(system, controllers=()), or simulate the motion"
        )
    worst = int(np.argmax(np.where(np.isfinite(found.relative), found.relative, np.inf)))
    raise ConvergenceError(
        f"no equilibrium at t = {time:g} after {search.max_iterations} iterations: relative residual "
        f"{found.relative[worst]:.2g} in the {_KINDS[worst]}, last move {move:.2g} of the size. A body that "
        "nothing holds, loads that no deformation can bear (buckling, a follower load that does work on a "
        "round trip), or a basis without the nonlinear terms it needs are the usual causes"
    )


def _restless(found: Unbalance, search: StaticSearch) -> str | None:
    """The state of a controller that is farthest from rest, in words; None where all rest."""
    worst = max(found.unrest, key=lambda name: np.nan_to_num(found.unrest[name], nan=np.inf), default=None)
    return worst if worst and not found.unrest[worst] <= search.residual else None
