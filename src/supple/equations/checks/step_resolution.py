"""Checks that fixed steps resolve loads and prescribed motions, before a run, and the motion, after it.

A step evaluates a load at its two ends. The error of the linear interpolation between steps is found by
evaluating the load also within the steps: at uneven times, and at the instants of the law (given, or found by
sampling). A sine of n steps a period has an error of (2 pi / n)^2 / 8 of its amplitude; for n < 2 the error
is the whole amplitude. A jump at the start or the end of a step does not count as an error. The load of a
prescribed motion is its acceleration.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from supple.equations.checks.strictness import warn_or_raise
from supple.errors import ResolutionWarning
from supple.integrate import FixedStep, Kinematic, Run, Statistics
from supple.machine import Constant, System, TimeLaw
from supple.machine.laws.instants import instants_of_law, shortest_scale_of, uneven_times
from supple.machine.laws.sampled_law import MOST_NUMBERS, law_samples

MISSED = 0.2
"""Largest error within a step without a warning, relative to the largest load; a sine of five steps a period
has this error."""
MOST_STEPS = 2**13
"""Largest number of steps checked, spread over the run; as many with an instant are checked in addition."""
WITHIN = np.array([0.5, 0.07, 0.21, 0.37, 0.62, 0.78, 0.91])
"""Sampling points within a step; uneven, because a periodic load may vanish at evenly spaced points."""
BESIDE, JUMPS = 0.1, 0.3
"""A change of JUMPS times the largest load within BESIDE steps before and after an instant is a jump."""
LARGEST_ERROR = 1e-2
"""Largest local error of a step without a warning, as defined for `AdaptiveStep`."""
LARGEST_TURN = 0.5
"""rad, largest rotation of a body within a step without a warning."""
NEAR = 1e-6
"""Distance of the samples before and after an instant, relative to the step."""


@dataclass(frozen=True)
class UnresolvedShare:
    """Largest interpolation error within a step, relative to the largest value, and the time of its step."""

    share: float
    time: float


def fixed_step(run: Run) -> float:
    """The fixed step in use: each output interval is a whole number of steps."""
    interval = float(run.times[1] - run.times[0])
    return interval / np.ceil(interval / run.step_control.largest * (1 - 1e-9))


def jumps_in_steps(system: System, run: Run) -> bool:
    """Whether a load, or the acceleration of a prescribed motion, jumps within a fixed step or at its end.

    False for adaptive steps.
    A step replaces the jump by a straight line, as if the jump were up to half a step earlier or later.
    """
    if not isinstance(run.step_control, FixedStep):
        return False
    begin, end, step = float(run.times[0]), float(run.times[-1]), fixed_step(run)
    loads = [(load.law, 0) for load in system.acting]
    motions = [(joint.law, 2) for joint in system.joints]
    return any(
        law is not None and not isinstance(law, Constant) and _jumps_in(law, begin, end, step, derivative)
        for law, derivative in loads + motions
    )


def _jumps_in(law: TimeLaw, begin: float, end: float, step: float, derivative: int) -> bool:
    instants = instants_of_law(law, begin, end)
    instants = instants[:MOST_STEPS]
    if not len(instants):
        return False
    beside = np.clip(instants[:, None] + BESIDE * step * np.array([-1.0, 1.0]), begin, end)
    sides = law_samples(law, beside.ravel(), order=derivative)[derivative]
    sides = sides.reshape(len(instants), 2, -1)
    size = np.abs(law_samples(law, np.linspace(begin, end, 257), order=derivative)[derivative]).max()
    return bool(np.abs(sides[:, 1] - sides[:, 0]).max() > JUMPS * max(size, np.abs(sides).max()))


def missed_between_steps(
    law: TimeLaw, begin: float, step: float, n_steps: int, instants: np.ndarray, *, derivative: int = 0
) -> UnresolvedShare:
    """The interpolation error in `n_steps` equal steps of a time function of any shape, or its derivative.

    instants : (k,)     times of kinks or extremes; steps that contain them are checked in addition
    """
    shape = jax.eval_shape(lambda time: jnp.asarray(law(time)), jnp.zeros(())).shape
    numbers = max(1, int(np.prod(shape)))
    most = max(8, min(MOST_STEPS, MOST_NUMBERS // (numbers * (len(WITHIN) + 2))))
    broken = np.clip(np.floor((instants - begin) / step).astype(int), 0, n_steps - 1)[:most]
    spread = np.unique(np.linspace(0, n_steps - 1, min(most, n_steps)).astype(int))
    chosen = np.concatenate([spread, broken])
    start = begin + chosen * step
    inner = start[:, None] + WITHIN * step
    # A step that contains an instant is sampled there: a pulse may be shorter than the sampling interval.
    nearby = instants[:most, None] + NEAR * step * np.array([0.0, -1.0, 1.0])
    if len(nearby):
        low, high = start[len(spread) :, None], start[len(spread) :, None] + step
        inner[len(spread) :, :3] = np.clip(nearby, low + NEAR * step / 2, high - NEAR * step / 2)
    ends = begin + (chosen + 1) * step
    at = np.concatenate([start[:, None], inner, ends[:, None]], axis=1)
    values = law_samples(law, at.ravel(), order=derivative)[derivative].reshape(*at.shape, -1)
    size = float(np.abs(values).max())
    first, within, last = values[:, :1], values[:, 1:-1], values[:, -1:]
    where = ((inner - start[:, None]) / step)[..., None]
    # With a jump at one end of the step, the quantity has the value of the other end within the step.
    missed = np.minimum.reduce(
        [np.abs(within - guess).max(axis=(1, 2)) for guess in (first + where * (last - first), first, last)]
    )
    worst = int(np.argmax(missed))
    share = float(missed[worst]) / size if size > 0 else 0.0
    return UnresolvedShare(share, float(start[worst]))


def warn_of_missed_loads(system: System, run: Run, *, besides: Collection[str] = ()) -> None:
    """Warn (ResolutionWarning) of each load and prescribed motion that fixed steps do not resolve.

    Raises ValidityError instead in a strict run.

    besides : names of joints for which another warning was given
    """
    if not isinstance(run.step_control, FixedStep):
        return
    for joint in system.joints:
        if joint.name not in besides:
            _warn(f"joint '{joint.name}'", joint.law, run, of_motion=True)
    for load in system.acting:
        _warn(load.label, load.law, run, of_motion=False)


def _warn(what: str, law: TimeLaw | None, run: Run, *, of_motion: bool) -> None:
    if law is None or isinstance(law, Constant):
        return
    step, begin, end = fixed_step(run), float(run.times[0]), float(run.times[-1])
    instants = instants_of_law(law, begin, end)
    if of_motion and _hardly_accelerated(law, begin, end, step):
        return
    n_steps, derivative = round((end - begin) / step), 2 if of_motion else 0
    missed = missed_between_steps(law, begin, step, n_steps, instants, derivative=derivative)
    if missed.share > MISSED:
        scale = shortest_scale_of(law, begin, end)
        briefest = f", whose shortest time is {scale:.3g}" if np.isfinite(scale) else ""
        needed = f"a step of {scale / 10:.2g}" if scale < 5 * step else "a shorter step"
        quantity = "the acceleration of its prescribed motion" if of_motion else "the load"
        message = (
            f"{what}: within a step of {step:.3g}, at t = {missed.time:.6g}, {quantity} differs from "
            f"a straight line by {100 * missed.share:.0f} % of its largest value{briefest}: the steps miss "
            f"or alias it. Take {needed}, or adaptive steps, which stop at kinks and jumps"
        )
        warn_or_raise(message, ResolutionWarning, run.validity)


def _hardly_accelerated(law: TimeLaw, begin: float, end: float, step: float) -> bool:
    """Whether the change of a motion's speed within a step is at most rounding."""
    times = uneven_times(begin, end, 257)
    _, fastest, hardest = (np.abs(each).max() for each in law_samples(law, times, order=2))
    return bool(hardest * step <= 1e-9 * fastest)


def report_step_length(statistics: Statistics, run: Run) -> None:
    """Warn (ResolutionWarning) of a fixed step with a large local error, or a large rotation of a body.

    Raises ValidityError instead in a strict run.
    """
    step = run.step_control
    if not isinstance(step, FixedStep):
        return
    found, shorter = [], 1.0
    if statistics.largest_error > LARGEST_ERROR:
        found.append(f"its local error reaches {statistics.largest_error:.2g} of the machine's size, or rad")
        shorter = (LARGEST_ERROR / statistics.largest_error) ** (1 / 3)  # the local error is of third order
    if statistics.largest_turn > LARGEST_TURN:
        found.append(f"a body rotates by {statistics.largest_turn:.2g} rad within it")
        shorter = min(shorter, LARGEST_TURN / statistics.largest_turn)
    if found:
        instead = "" if isinstance(run.method, Kinematic) else ", or adaptive steps"
        message = (
            f"the fixed step of {step.size:.3g} is too long for this motion: {' and '.join(found)}. Take "
            f"{step.size * shorter:.1g} or less{instead}"
        )
        warn_or_raise(message, ResolutionWarning, run.validity)
