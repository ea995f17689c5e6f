"""Run a case file, and print its results."""

from __future__ import annotations

from pathlib import Path

from supple import cases
from supple.cases.run_files import stored_so_far
from supple.cli.shown_case import shown_case, stated_interruption
from supple.error import SelfCorrectionError, correction_numbers
from supple.results.explicit_numbers import explicit_cost_line
from supple.results.run_start import start_lines
from supple.results.run_tables import (
    correction_table,
    cost_line,
    error_lines,
    error_table,
    motion_tables,
)
from supple.terminal import print_table, say


def run_case(
    path: Path, folder: Path, *, resume: bool, force: bool, strict: bool, errors: bool, allow_code: bool
) -> None:
    """Run the case file at `path` and print its tables; parameters and exceptions as for `cases.run_case`.

    If interrupted, print what is stored.
    """

    def kept(error: BaseException) -> str:
        return "; ".join(getattr(error, "__notes__", [])) or stored_so_far(path, folder)

    with stated_interruption(kept):
        with shown_case(path) as (case, progress):
            try:
                result = cases.run_case(
                    case,
                    folder,
                    resume=resume,
                    force=force,
                    strict=strict,
                    errors=errors,
                    allow_code=allow_code,
                    progress=progress,
                )
            except SelfCorrectionError as error:
                if error.rounds:
                    print_table(*correction_table(correction_numbers(error.rounds), case.units))
                raise
        _print(result, case, folder)


def _print(result: cases.CaseResult, case: cases.Case, folder: Path) -> None:
    numbers = result.numbers
    if result.rounds:
        print_table(*correction_table(result.rounds, case.units))
    for table in motion_tables(numbers):
        print_table(*table)
    for name, body in numbers["bodies"].items():
        if "eigenvalues" in body:
            say(f"{name}: {body['eigenvalues']}")
    if numbers["errors"]:
        print_table(*error_table(numbers))
        for line in error_lines(numbers):
            say(line)
    for line in start_lines(numbers):
        say(line)
    say(explicit_cost_line(numbers) if "steps" in numbers else cost_line(result.solution.statistics))
    say(f"Results are in {folder}/")
