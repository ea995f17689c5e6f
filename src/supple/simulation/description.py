"""A machine and its run in a line, which tells two of them apart."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import fields

import jax
import numpy as np

from supple.integrate import Run
from supple.machine import System

__all__ = ["description"]


def description(system: System, run: Run) -> str:
    """Names of bodies and joints, the span of the run, and a hash of the numbers of both.

    Numbers of reduced bodies are left out, for reducing again moves their last digits and signs: result files
    know their columns otherwise. A function of time counts by its name.
    """
    digest = hashlib.sha256()
    for part in _parts(system, run):
        digest.update(part)
    bodies = ", ".join(f"{placed.body.name} ({placed.body.kind})" for placed in system.bodies)
    joints = ", ".join(joint.name for joint in system.joints) or "none"
    span = f"{run.duration:g} from {run.start:g}, every {run.output_step:g}"
    return f"bodies {bodies}; joints {joints}; {span}; {digest.hexdigest()[:16]}"


def _parts(system: System, run: Run) -> Iterator[bytes]:
    for placed in system.bodies:
        yield f"{placed.body.name} {placed.body.kind} {placed.body.n_coordinates}".encode()
        for item in ("position", "rotation", "velocity", "angular_velocity"):
            yield np.asarray(getattr(placed, item)).tobytes()
    yield np.asarray(system.gravity).tobytes()
    for element in (*system.joints, *system.loads):
        yield type(element).__name__.encode()
        for item in fields(element):
            value = getattr(element, item.name)
            yield item.name.encode()
            yield from _numbers(value)
        yield from _numbers(element.law)
    numbers = (run.step_control, run.method, run.tolerances, run.duration, run.output_step, run.start)
    yield repr(numbers).encode()


def _numbers(value: object) -> Iterator[bytes]:
    """A value of an element: a law, a function by its name, numbers or words."""
    for leaf in jax.tree.leaves(value):
        if callable(leaf):
            yield getattr(leaf, "__qualname__", type(leaf).__name__).encode()
        elif isinstance(leaf, str):
            yield leaf.encode()
        else:
            yield np.asarray(leaf, dtype=float).tobytes()
