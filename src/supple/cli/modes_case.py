"""Find the modes of the machine of a case file, and list them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from supple import cases
from supple.cli.shown_case import shown_case
from supple.errors import ArgumentError, CaseError
from supple.results.mode_tables import mode_tables, speed_tables
from supple.terminal import print_table, say


def modes_case(
    path: Path, folder: Path, *, n_modes: int, time: float, rates: str | None, errors: bool, allow_code: bool
) -> None:
    """Print the modes of the case at `path`, or its frequencies over speed.

    rates : "FROM:TO:NUMBER" of a Campbell diagram, rad per unit of time; None: modes at the rate of `[spin]`
    time : time at which loads and laws are evaluated; not used for a Campbell diagram
    Errors as for `cases.modes_case` and `cases.campbell_case`; ArgumentError for `rates` and a `time`.
    """
    if rates is not None and time:
        raise ArgumentError(
            "--time is for the modes at one speed; a Campbell diagram (--rates) is computed at time 0: "
            "remove one of them"
        )
    speeds = None if rates is None else _speeds(rates)
    with shown_case(path) as (case, progress):
        if speeds is None:
            _, numbers = cases.modes_case(
                case,
                folder,
                n_modes=n_modes,
                time=time,
                errors=errors,
                allow_code=allow_code,
                progress=progress,
            )
            tables = mode_tables(numbers)
        else:
            diagram = cases.campbell_case(
                case,
                folder,
                speeds.tolist(),
                n_modes=n_modes,
                errors=errors,
                allow_code=allow_code,
                progress=progress,
            )
            tables = speed_tables(diagram, case.units)
    for table in tables:
        print_table(*table)
    say(f"Results are in {folder}/")


def _speeds(text: str) -> np.ndarray:
    try:
        first, last, number = text.split(":")
        if not 2 <= int(number) <= 10_000:
            raise ValueError
        return np.linspace(float(first), float(last), int(number))
    except ValueError as error:
        raise CaseError(
            f"--rates '{text}' is not FROM:TO:NUMBER, such as 0:2:9 (two speeds or more)"
        ) from error
