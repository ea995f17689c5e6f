"""Outputs of controllers along a run, stored with its motion."""

from __future__ import annotations

import jax
import numpy as np

from supple.arrays import FloatArray
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import ControlState, ControlStep, SystemMotion
from supple.equations.control_force import outputs
from supple.equations.machine_model import Model
from supple.errors import ModelError
from supple.integrate import Solution
from supple.machine import ForceElement, System
from supple.programs.program_cache import CachedProgram


def series_name(controller: str) -> str:
    """Name in `Solution.series` of the outputs of a controller."""
    return f"controller {controller}"


def control_series(model: Model, motion: SystemMotion, control: ControlState | None) -> dict[str, FloatArray]:
    """Outputs (t, c) of each controller, by `series_name`; the c values are in the order of its `drives`.

    motion, control : states at t times, stacked along the first axis; `control` is None without controllers
    """
    if control is None:
        return {}
    n = len(np.asarray(motion.time))
    # Padded to a power of two: the program is compiled again for each new length.
    more = (1 << (n - 1).bit_length()) - n if n else 1

    def padded(leaf: np.ndarray) -> np.ndarray:
        return np.pad(leaf, ((0, more), *((0, 0),) * (np.ndim(leaf) - 1)), mode="edge")

    seen = motion._replace(control=ControlStep(control, np.zeros(n)))
    values = jax.device_get(_along(model, jax.tree.map(lambda leaf: padded(np.asarray(leaf)), seen)))
    return {series_name(law.name): own[:n] for law, own in zip(model.controllers, values, strict=True)}


def added_to_law(system: System, solution: Solution, element: ForceElement) -> FloatArray | None:
    """Outputs (t, ..) that a controller adds to the law of an element; None if no controller drives it.

    Raises ModelError for a solution without the outputs.
    """
    for own in system.controllers:
        first = 0
        for each in own.drives.values():
            after = first + int(np.prod(each.value_shape))
            if each is element:
                name = series_name(own.name)
                if name not in solution.series:
                    raise ModelError(
                        f"{element.label} is driven by controller '{own.name}', but this solution does not "
                        "contain the outputs of this controller: simulate the machine"
                    )
                return solution.series[name][:, first:after].reshape(-1, *each.value_shape)
            first = after
    return None


def _outputs_along(model: Model, motion: SystemMotion) -> tuple[jax.Array, ...]:
    return jax.vmap(lambda now: outputs(model, now))(motion)


_along = CachedProgram(_outputs_along, STARTING)
