"""The engine of a machine, chosen by the run's method or by the form of its bodies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from supple.body import FullBody
from supple.errors import ModelError
from supple.integrate import AdaptiveStep, Engine, ExplicitRule, Kinematic, Run
from supple.machine import System
from supple.methods.explicit import ExplicitEngine
from supple.methods.floating import CompiledEngine, FullEngine, FullKinematicEngine, KinematicEngine
from supple.methods.intrinsic import intrinsic_engine
from supple.methods.intrinsic.line_in_frame import lines_in_frames
from supple.methods.intrinsic.stable_step import with_chosen_step
from supple.methods.intrinsic.supported_root import is_joined

__all__ = ["register_engine"]

EngineFactory = Callable[[System, Run], Engine[Any]]
"""Prepares a machine for one method."""


def _sparse_engine(system: System, run: Run) -> FullEngine:
    """The engine of machines with full bodies; intrinsic bodies have floating frames."""
    return FullEngine(lines_in_frames(system), with_chosen_step(system, run))


def _intrinsic_engine(system: System, run: Run) -> Engine[Any]:
    """The engine of intrinsic bodies: sparse with full bodies, or with joints and adaptive steps."""
    if system.bodies_of(FullBody) or (is_joined(system) and isinstance(run.step_control, AdaptiveStep)):
        return _sparse_engine(system, run)
    return intrinsic_engine(system, run)


_ENGINES: dict[str, EngineFactory] = {}
"""Engines by kind of body; the first of these kinds that occurs in a machine determines its engine."""


def register_engine(kind: str, factory: EngineFactory) -> None:
    """Simulate machines with bodies of a kind (`BodyForm.kind`) by the engine from `factory`.

    The engine must also support bodies of other kinds in the same machine.
    """
    _ENGINES[kind] = factory


def engine_for(system: System, run: Run) -> Engine[Any]:
    """The machine prepared for the run's method or, by default, for the form of its bodies.

    Raises ModelError for controllers that the machine's engine does not support.
    """
    kinds = {placed.body.kind for placed in system.bodies}
    if isinstance(run.method, Kinematic):
        sparse = kinds & {"full", "intrinsic"}
        return FullKinematicEngine(lines_in_frames(system), run) if sparse else KinematicEngine(system, run)
    if is_explicit(system, run):
        return ExplicitEngine(system, run)
    factory = next((factory for kind, factory in _ENGINES.items() if kind in kinds), CompiledEngine)
    _check_controllers(system, factory)
    return factory(system, run)


def is_explicit(system: System, run: Run) -> bool:
    """Whether a run is explicit: because of its method, or of a body that no other method supports."""
    kinds = {placed.body.kind for placed in system.bodies}
    return isinstance(run.method, ExplicitRule) or any(_ENGINES.get(kind) is ExplicitEngine for kind in kinds)


def refuse_explicit(system: System, run: Run, what: str) -> None:
    """Raise ModelError for an explicit march, which `what`, such as "a batch", does not support."""
    if is_explicit(system, run):
        system.check_has_frames()
        raise ModelError(
            f"{what} does not support explicit marches: simulate the machine alone, or reduce its modal parts"
        )


def _check_controllers(system: System, factory: EngineFactory) -> None:
    if not system.controllers or factory in (CompiledEngine, _sparse_engine, _intrinsic_engine):
        return
    other = next(placed.body for placed in system.bodies if placed.body.kind in _ENGINES)
    raise ModelError(
        "controllers act in machines of rigid, reduced, full and intrinsic bodies, and body "
        f"'{other.name}' is {other.kind}: reduce it, or leave out the controllers"
    )


register_engine("modal", ExplicitEngine)
register_engine("explicit", ExplicitEngine)
register_engine("intrinsic", _intrinsic_engine)
register_engine("full", _sparse_engine)
