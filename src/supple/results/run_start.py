"""Effects of the start on the results of a run: velocities from drives, and vibration due to gravity."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from supple.equations.start_change import velocities_taken
from supple.integrate import FramedMotion, Solution
from supple.machine import GROUND, ForceElement, System
from supple.machine.forces.sphere_contact import SphereContact
from supple.results.run_tables import Numbers

FALLEN = 0.7
"""A deformation has swung back if it is below this fraction of its previous maximum."""
NOTED = 0.5
"""A first swing is reported if it is at least this fraction of the largest deformation of the run."""


def start_numbers(system: System, solution: Solution) -> dict[str, Any]:
    """Bodies whose initial velocity is that of a drive, and bodies that gravity sets vibrating."""
    if not all(placed.body.has_frame for placed in system.bodies):  # explicit parts start as they are placed
        return {"velocities taken": [], "swings from gravity": {}}
    motions = [solution.motion(placed.body.name, FramedMotion) for placed in system.bodies]
    moving = np.array([[*motion.velocity[0], *motion.angular_velocity[0]] for motion in motions])
    swings, held = {}, _held(system, is_moving=bool(moving.any()))
    for placed, motion in zip(system.bodies, motions, strict=True):
        sizes = np.linalg.norm(motion.coordinates, axis=1)
        hangs = system.gravity.any() and placed.body.name in held and not sizes[0]
        if hangs and (found := first_swing(sizes)):
            share, row = found
            swings[placed.body.name] = {"share of largest": share, "at time": float(solution.times[row])}
    return {
        "velocities taken": [
            {"body": each.body, "speed": each.speed, "angular speed": each.spin}
            for each in velocities_taken(system, moving)
        ],
        "swings from gravity": swings,
    }


def _held(system: System, *, is_moving: bool) -> set[str]:
    """Bodies connected to the ground: gravity does not deform a free body, such as an aircraft in flight.

    is_moving : whether bodies move at the start; contacts then begin with an impact, and do not count
    """
    elements = [load for load in system.loads if isinstance(load, ForceElement)]
    parts: list[Any] = [*system.joints, *(each for each in elements if not each.acts_on_first_alone)]
    if is_moving:
        parts = [each for each in parts if not isinstance(each, SphereContact)]
    links = [{each.first.body, each.second.body} for each in parts]
    found = {GROUND.body}
    while more := [link for link in links if link & found and not link <= found]:
        found.update(*more)
    return found


def first_swing(sizes: np.ndarray) -> tuple[float, int] | None:
    """The maximum of the first swing of sizes (t,), relative to the overall maximum, and its index.

    The first swing ends where the sizes fall below 0.7 of their previous maximum. None if they never do,
    or if the maximum of the first swing is less than half of the overall maximum.
    """
    largest = np.maximum.accumulate(sizes)
    back = np.flatnonzero(sizes < FALLEN * largest)
    if not back.size:
        return None
    row = int(np.argmax(sizes[: back[0]]))
    share = float(sizes[row] / largest[-1])
    return (share, row) if share >= NOTED else None


def start_lines(numbers: Numbers) -> Iterator[str]:
    """The effects of the start as text; numbers from `summarize`."""
    start, units = numbers["start"], numbers["units"]
    time = units.get("time", "")
    taken = ", ".join(
        f"'{each['body']}' (speed {each['speed']:.4g}, angular speed {each['angular speed']:.4g} rad"
        f"{f'/{time}' if time else ' per time'})"
        for each in start["velocities taken"]
    )
    if taken:
        yield f"Bodies without a stated velocity start with that of the joint that drives them: {taken}"
    for name, swing in start["swings from gravity"].items():
        yield (
            f"{name}: gravity acts on the undeformed body from the first instant: the first swing, "
            f"at time {swing['at time']:.4g}, makes {100 * swing['share of largest']:.3g} % of its largest "
            'deformation. To avoid this, start at rest: start = "equilibrium"; in Python, '
            "simulate(equilibrium(system).system, run)"
        )
