"""Check of prescribed motions for jumps of speed or acceleration: impacts, or jumping joint forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from supple.equations.checks.strictness import warn_or_raise
from supple.errors import ResolutionWarning
from supple.integrate import Run
from supple.machine import Constant, System, TimeLaw
from supple.machine.laws.instants import KnownLaw, instants_of_law, shortest_scale_of
from supple.machine.laws.sampled_law import N_SAMPLES, Jumps, jumps, law_samples

SPEED, ACCELERATION = 1e-6, 1e-3
"""Smallest reported jumps. SPEED is the smallest jump of the motion, relative to its range, and of the speed,
relative to the largest speed. ACCELERATION is that of the acceleration, relative to the largest one."""
BESIDE = 1e-7
"""Distance of the samples before and after a possible jump of a `KnownLaw`, relative to the shortest time
scale of the law."""


@dataclass(frozen=True)
class RateJump:
    """Jumps of a prescribed motion, its speed and its acceleration at a time; 0 without a jump."""

    time: float
    motion: float
    speed: float
    acceleration: float


def rate_jumps(law: TimeLaw, begin: float, end: float) -> tuple[list[RateJump], float, float]:
    """Jumps of a scalar law between two times, its largest speed, and its largest acceleration.

    No jumps are returned for a law with values that are not finite.
    """
    times = np.linspace(begin, end, N_SAMPLES + 1)

    def of_times(at: np.ndarray) -> np.ndarray:
        return np.hstack(law_samples(law, at, order=2))

    samples = of_times(times)
    _, fastest, hardest = np.abs(samples).max(axis=0)
    if not np.isfinite(samples).all():
        return [], fastest, hardest  # the run reports where it fails
    if isinstance(law, KnownLaw):
        instants = instants_of_law(law, begin, end)
        beside = BESIDE * min(shortest_scale_of(law, begin, end), end - begin)
        sides = Jumps(np.maximum(instants - beside, begin), np.minimum(instants + beside, end))
    else:
        found = [jumps(lambda at, i=i: of_times(at)[:, [i]], times, samples[:, [i]]) for i in range(3)]
        sides = Jumps(*(np.concatenate(each) for each in zip(*found, strict=True)))
    if not sides.before.size:
        return [], float(fastest), float(hardest)
    steps = np.abs(of_times(sides.after) - of_times(sides.before))
    steps[:, 0] -= (sides.after - sides.before) * fastest  # the change of a smooth motion between the two
    size = np.ptp(samples[:, 0])
    sized = [
        RateJump(
            float((before + after) / 2),
            float(motion) if motion > SPEED * size else 0.0,
            float(speed) if speed > SPEED * fastest else 0.0,
            float(acceleration) if acceleration > ACCELERATION * hardest else 0.0,
        )
        for before, after, (motion, speed, acceleration) in zip(*sides, steps, strict=True)
    ]
    return [each for each in sized if each.motion or each.speed or each.acceleration], fastest, hardest


def warn_of_rate_jumps(system: System, run: Run) -> set[str]:
    """Warn (ResolutionWarning) of joints whose prescribed motion jumps in the run; returns their names.

    Raises ValidityError instead in a strict run.
    """
    begin, end = float(run.times[0]), float(run.times[-1])
    named = set()
    for joint in system.joints:
        if joint.law is None or isinstance(joint.law, Constant):
            continue
        found, _, _ = rate_jumps(joint.law, begin, end)
        if found:
            named.add(joint.name)
            warn_or_raise(_message(joint.name, found), ResolutionWarning, run.validity)
    return named


def _message(joint: str, found: Sequence[RateJump]) -> str:
    for what, size, consequence in (
        ("", "motion", "bodies cannot follow a jump: the joint opens there, or the step does not converge"),
        (
            "speed of its ",
            "speed",
            "the force is infinite at that instant, and its computed value depends on the step size",
        ),
        ("acceleration of its ", "acceleration", "the forces of the joint jump, and oscillate after it"),
    ):
        own = [each for each in found if getattr(each, size)]
        if own:
            worst = max(own, key=lambda each: getattr(each, size))
            more = f" (and at {len(own) - 1} other times)" if len(own) > 1 else ""
            return (
                f"joint '{joint}': the {what}prescribed motion jumps by {getattr(worst, size):.3g} at "
                f"t = {worst.time:.6g}{more}: {consequence}. Use a smooth law (Ramp, SpinUp, or a Spline "
                "through rows)"
            )
    raise AssertionError("a RateJump without a jump")
