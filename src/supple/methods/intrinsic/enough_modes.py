"""As many modes as a run needs: doubled until what they leave out is small enough."""

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
from supple.methods.intrinsic.truncation_error import TruncationError, truncation_error

__all__ = ["enough_modes"]

FEWEST = 6


class EnoughModes(NamedTuple):
    """A machine whose bodies have modes enough, its run, and the error that it has.

    errors : by body name; empty where all modes are kept, which leave nothing out
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
    """The machine with as many modes as bring the truncation error of its run within a tolerance.

    Their number doubles, in these bodies alike, until `truncation_error` allows it or all are kept.

    Parameters
    ----------
    system : a machine with intrinsic bodies; the modes that they have do not count
    run : its simulation, such as `lambda system: simulate(system, Run(..))`
    tolerance : of the error of the stations' places over the deflection
    first : elastic modes to begin with
    bodies : names of those whose modes are counted; all when omitted

    Raises ModelError as `truncation_error`, and for a tolerance or a number that cannot be.
    """
    if not 0 < tolerance < 1:
        raise ModelError(f"a tolerance of modes left out lies between 0 and 1, not {tolerance}")
    if first < 1:
        raise ModelError(f"a search for modes begins with one at least, not {first}")
    names = [placed.body.name for placed in intrinsic_of(system)] if bodies is None else bodies

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
        with warnings.catch_warnings():  # of modes left out: the search is for enough of them
            warnings.simplefilter("ignore", ValidityWarning)
            solution = run(fewer)
        errors = truncation_error(fewer, solution)
        if max(error.largest for name, error in errors.items() if name in names) <= tolerance:
            return EnoughModes(fewer, solution, errors)
        number *= 2
    return EnoughModes(whole, run(whole), {})
