"""Report of the corrections that the joints made to an initial state."""

from __future__ import annotations

from collections.abc import Sequence

from supple.equations.checks.strictness import warn_or_raise
from supple.equations.start_change import ConstraintViolation, StartChange, VelocityCorrection
from supple.errors import StartWarning
from supple.integrate import Validity

MOST_NAMES = 3
"""Largest number of bodies or joints in a message."""
ROUNDING = 1e-9
"""Largest rotation, rad, or relative change of a speed that is not reported."""


def report_start(change: StartChange, validity: Validity) -> None:
    """Warn (StartWarning) of open joints, velocities that joints do not allow, and deformation rates.

    Raises ValidityError instead in a strict run.
    """
    if change.open:
        worst = change.open[0]
        others = _others(change.open[1:])
        bodies = ", ".join(
            f"body '{moved.body}' was moved by {moved.distance:.3g}"
            + (f" and rotated by {moved.angle:.3g} rad" if moved.angle > ROUNDING else "")
            for moved in change.moved[:MOST_NAMES]
        )
        message = (
            f"joint '{worst.joint}' is open by {worst.gap:.3g} in the initial configuration ({worst.row})"
            f"{others}: {bodies} to close it. Place the bodies so that both ends meet"
        )
        warn_or_raise(message, StartWarning, validity)
    if change.slowed:
        before, after = change.energies
        bodies = ", ".join(map(_slowed, change.slowed[:MOST_NAMES]))
        percent = f" ({100 * (after / before - 1):+.3g} %)" if before else ""
        if change.is_impact:
            what = "the velocities of the earlier motion, which an impact without rebound changes"
            remedy = "If no latch is meant, give the joints of that motion, with their points and axes"
        else:
            what = "the initial velocities, which were changed"
            remedy = "Give velocities that the joints allow, or none to a body that joints drive"
        message = (
            f"the joints do not allow {what}: the kinetic energy is {after:.4g} instead of "
            f"{before:.4g}{percent}; {bodies}; violated: {_joints(change.against)}. {remedy}"
        )
        warn_or_raise(message, StartWarning, validity)
    if change.deforming:
        bodies = ", ".join(
            f"body '{each.body}' deforms at a rate of kinetic energy {each.energy:.3g}"
            for each in change.deforming[:MOST_NAMES]
        )
        message = (
            f"no rigid motion of the bodies has the velocities that the joints prescribe at the start: "
            f"{bodies}; joints: {_joints(change.unmet)}. Let the prescribed motion begin from rest, or "
            "prescribe a motion that the bodies can follow without deformation"
        )
        warn_or_raise(message, StartWarning, validity)


def _joints(joints: Sequence[ConstraintViolation]) -> str:
    return ", ".join(f"'{each.joint}' ({each.row})" for each in joints[:MOST_NAMES])


def _others(joints: Sequence[ConstraintViolation]) -> str:
    if not joints:
        return ""
    names = ", ".join(f"'{each.joint}'" for each in joints[:MOST_NAMES])
    return (
        f"; {len(joints)} others are open as well ({names})"
        if len(joints) > 1
        else f"; {names} is open as well"
    )


def _slowed(body: VelocityCorrection) -> str:
    (speed, new_speed), (spin, new_spin) = body.speeds, body.spins
    changes = [
        f"{what} of {new:.4g} instead of {old:.4g}"
        for old, new, what in ((speed, new_speed, "a speed"), (spin, new_spin, "an angular velocity"))
        if abs(new - old) > ROUNDING * (speed + new_speed + spin + new_spin)
    ]
    return f"body '{body.body}' starts with {' and '.join(changes) or 'another direction of motion'}"
