"""Find the equilibrium of a case file, and print it."""

from __future__ import annotations

from pathlib import Path

from supple import cases
from supple.cli.shown_case import shown_case
from supple.reduction import ReducedBody
from supple.results.rest_tables import rest_error_table, rest_tables
from supple.terminal import print_table, say

_STABILITY = {True: "Stable", False: "Unstable", None: "An"}
"""First word of the printed line, by the stability of the equilibrium; None: unknown stability."""


def static_case(path: Path, folder: Path, *, time: float, errors: bool, allow_code: bool) -> None:
    """Print the equilibrium of the case at `path`; parameters and errors as for `cases.static_case`."""
    with shown_case(path) as (case, progress):
        result = cases.static_case(
            case, folder, time=time, errors=errors, allow_code=allow_code, progress=progress
        )
    numbers = result.numbers
    for table in rest_tables(numbers):
        print_table(*table)
    if result.found.errors:
        print_table(*rest_error_table(numbers))
    found = result.found
    unknown = [name for name in found.system.bodies_of(ReducedBody) if name not in found.errors]
    if errors and unknown:
        say(f"Basis error not estimated for bodies without finite elements in the case: {', '.join(unknown)}")
    kind = _STABILITY[found.stable]
    say(f"{kind} equilibrium after {found.iterations} iterations. Results are in {folder}/")
