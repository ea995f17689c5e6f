"""Closing of open joints by the least rigid motion of the bodies, in the mass norm."""

from __future__ import annotations

import numpy as np

from supple.equations.build_model import row_scales
from supple.equations.configuration import Configuration
from supple.equations.starting_machine import JointTerms, StartingMachine
from supple.equations.step_size import at_rounding
from supple.errors import ConvergenceError, ModelError
from supple.machine import System

_LARGEST_TURN = 0.3
"""Largest component of a body's rotation (rad), and of its translation relative to the machine's size, in an
iteration."""
_MOST_ITERATIONS = 200
"""Largest number of iterations of `joints_assembled`."""
_UNCLOSED = 1e-10
"""Largest residual of a joint that counts as closed, relative to the machine's size or in rad."""


def joints_closed(
    machine: StartingMachine, time: float, configuration: Configuration, velocity: np.ndarray
) -> Configuration:
    """The configuration projected on the joints by Newton's method, to rounding accuracy.

    Raises ConvergenceError if the residual is not at rounding level after 20 iterations.
    """
    still = np.zeros_like(velocity)
    largest, before = 0.0, np.inf
    for _ in range(20):
        terms = machine.joint_terms(time, configuration, velocity)
        gaps = machine.model.as_lengths(np.asarray(terms.residual))
        largest = float(np.max(abs(gaps), initial=0.0))
        if at_rounding(machine.model.length, configuration.origins, largest, before):
            return configuration
        before = largest
        rigid, left = _least_rigid_change(machine, configuration, terms)
        if left <= 1e-6 * np.linalg.norm(terms.residual):  # rigid motions close the joints to first order
            change = _of_bodies(machine, rigid)
        else:
            change = machine.least_change(configuration, still, terms, terms.residual)
        configuration = machine.moved(configuration, change)
    raise ConvergenceError(
        f"the joints could not be closed at the start: largest residual {largest:.3g} after 20 iterations. "
        "Place the bodies closer to a configuration in which every joint is closed"
    )


def _least_rigid_change(
    machine: StartingMachine, configuration: Configuration, terms: JointTerms
) -> tuple[np.ndarray, float]:
    """The least rigid motion (nb, 6) in the mass norm that best closes the joints, and the remaining gaps.

    The second result is the norm of the remaining residual, to first order.
    """
    frames = [slice(part.start, part.start + 6) for part in machine.joint_slices]
    whitening = [np.linalg.inv(np.linalg.cholesky(own)).T for own in machine.frame_masses(configuration)]
    jacobian = np.hstack([terms.jacobian[:, part] @ own for part, own in zip(frames, whitening, strict=True)])
    change, *_ = np.linalg.lstsq(jacobian, -terms.residual, rcond=1e-9)
    left = float(np.linalg.norm(jacobian @ change + terms.residual))
    return np.array([own @ each for own, each in zip(whitening, change.reshape(-1, 6), strict=True)]), left


def _of_bodies(machine: StartingMachine, change: np.ndarray) -> np.ndarray:
    """An increment (n,) from the frames' motions (nb, 6)."""
    increment = np.zeros(machine.slices[-1].stop)
    for part, own in zip(machine.slices, change, strict=True):
        increment[part.start : part.start + 6] = own
    return increment


def joints_assembled(machine: StartingMachine, time: float, configuration: Configuration) -> Configuration:
    """The configuration near the given one in which all joints are closed, however far they are open.

    Gauss-Newton iteration on the rows of all joints. Each step is the least rigid motion. It is scaled down
    until no component of a body's rotation exceeds 0.3 rad, and none of its translation 0.3 of the machine's
    size.

    Raises
    ------
    ModelError          a law without a finite value at this time
    ConvergenceError    joints cannot be closed; the message names the worst one and its residual
    """
    system, length = machine.system, float(machine.model.length)
    scales, still = row_scales(system), np.zeros(machine.slices[-1].stop)
    sizes = np.array([length, length, length, 1.0, 1.0, 1.0])
    left = np.array([np.inf])
    for _ in range(_MOST_ITERATIONS):
        terms = machine.joint_terms(time, configuration, still)
        check_joints_finite(system, terms.residual, terms.rate)
        before, left = np.max(abs(left), initial=0.0), np.asarray(terms.residual) / scales
        largest = np.max(abs(left), initial=0.0)
        if (largest <= _UNCLOSED and largest > 0.1 * before) or not largest:
            return configuration
        change, _ = _least_rigid_change(machine, configuration, terms)
        farthest = np.max(abs(change) / sizes)
        change *= min(1.0, _LARGEST_TURN / farthest) if farthest else 1.0
        configuration = machine.moved(configuration, _of_bodies(machine, change))
    worst = int(np.argmax(abs(left)))
    raise ConvergenceError(
        f"the machine cannot be assembled: joint {row_labels(system)[worst]} stays open by "
        f"{abs(left[worst]) * scales[worst]:.3g} after {_MOST_ITERATIONS} iterations. Correct lengths and "
        "positions of the bodies; a law must begin with a value that they can reach"
    )


def check_joints_finite(system: System, residuals: np.ndarray, rates: np.ndarray) -> None:
    """Raise ModelError for a law of a joint whose value or rate is not finite, such as sin(t) / t at 0."""
    for joint in (each for each in system.joints if each.law is not None):
        rows = system.constraint_slices[joint.name]
        for what, values in (("value", residuals[rows]), ("rate", rates[rows])):
            if not np.isfinite(values).all():
                raise ModelError(
                    f"joint '{joint.name}': its law has no finite {what} at the start: write it without a "
                    "division by zero there, for example jnp.sinc(t / jnp.pi) instead of jnp.sin(t) / t"
                )


def row_labels(system: System) -> list[str]:
    """Labels of the constraint equations."""
    return [f"'{joint.name}' ({row})" for joint in system.joints for row in joint.rows]
