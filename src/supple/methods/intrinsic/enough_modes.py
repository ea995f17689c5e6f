"""Number of modes that a run needs: doubled until the truncation error is small enough."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import NamedTuple

from supple.errors import ModelError, ValidityWarning
from supple.integrate import Solution
from supple.machine import System
from supple.methods.intrinsic.complete_motion import intrinsic_of, with_modes
from supple.methods.intrinsic.intrinsic_body import body_of
from supple.methods.intrinsic.truncation_error import (
    TruncationError,
    check_without_controllers,
    truncation_error,
)

__all__ = ["enough_modes"]

FEWEST = 6
"""Default initial number of elastic modes."""


class EnoughModes(NamedTuple):
    """A machine whose bodies have enough modes, its run, and its truncation error.

    errors : truncation error by body name; empty if the bodies of the search retain all modes
    """

    system: System
    solution: Solution
    errors: Mapping[str, TruncationError]


def enough_modes(
    system: System,
    run: Callable[[System], Solution],
    *,
    tolerance: float,
    first: int = FEWEST,
    bodies: Collection[str] | None = None,
) -> EnoughModes:
    """The machine with enough modes for a tolerance of the truncation error, its run, and its error.

    The number of modes, equal in all bodies of the search, doubles until `truncation_error` is within the
    tolerance or all modes are retained.

    Parameters
    ----------
    system : a machine with intrinsic bodies; their present numbers of modes have no effect
    run : function that simulates a machine, such as `lambda system: simulate(system, Run(..))`
    tolerance : limit of `TruncationError.largest`: error of station positions, or drift of centre of mass,
        relative to the deflection
    first : initial number of elastic modes
    bodies : names of the bodies in the search; default all

    Raises ModelError as `truncation_error`, for an invalid tolerance or number, and for a released body whose
    root has no mass, which cannot retain all modes.
    """
    if not 0 < tolerance < 1:
        raise ModelError(f"a truncation tolerance must be between 0 and 1, not {tolerance}")
    if first < 1:
        raise ModelError(f"a search for the number of modes starts at 1 or more, not {first}")
    check_without_controllers(system)
    names = [placed.body.name for placed in intrinsic_of(system)] if bodies is None else bodies

    for body in (body_of(placed) for placed in intrinsic_of(system) if placed.body.name in names):
        if body.supported is not None and body.supported.complete is not None and body.complete is None:
            raise ModelError(
                f"body '{body.name}': its number of modes is not determined: a released body with all modes "
                "needs a root with mass. Give its root station a mass (root_mass), or choose n_modes"
            )

    def of(number: int | None) -> System:
        return replace(
            system,
            bodies=[
                with_modes(placed, number) if placed.body.name in names else placed
                for placed in system.bodies
            ],
        )

    whole = of(None)
    most = max(body_of(placed).n_coordinates for placed in intrinsic_of(whole))
    number = first
    while number < most:
        fewer = of(number)
        if not any(body_of(placed).complete for placed in intrinsic_of(fewer) if placed.body.name in names):
            break
        with warnings.catch_warnings():  # trial runs issue no ValidityWarning
            warnings.simplefilter("ignore", ValidityWarning)
            solution = run(fewer)
        errors = truncation_error(fewer, solution)
        if max(error.largest for name, error in errors.items() if name in names) <= tolerance:
            return EnoughModes(fewer, solution, errors)
        number *= 2
    return EnoughModes(whole, run(whole), {})
