"""Run a case file, and say what came out."""

from __future__ import annotations

from pathlib import Path

from supple import cases
from supple.correction import SelfCorrectionError, correction_numbers
from supple.results.run_tables import (
    body_table,
    correction_table,
    cost_line,
    joint_table,
    motion_table,
    place_table,
)
from supple.terminal import Steps, console, print_table, progress_bars


def run_case(path: Path, folder: Path, *, resume: bool = False, strict: bool = False) -> None:
    """Run the case file at `path` and print its tables; parameters and errors as for `cases.run_case`."""
    bars = progress_bars()
    steps = Steps(bars)
    case = cases.read_case(path, steps.show)
    console.print(f"[bold]{case.title}[/bold]", highlight=False)
    with bars:
        try:
            result = cases.run_case(case, folder, resume=resume, strict=strict, progress=steps.share)
        except SelfCorrectionError as error:
            print_table(*correction_table(correction_numbers(error.rounds), case.units))
            raise
        steps.finish()
    numbers = result.numbers
    if result.rounds:
        print_table(*correction_table(result.rounds, case.units))
    print_table(*body_table(numbers))
    print_table(*joint_table(numbers))
    if numbers["tracked"]:
        print_table(*motion_table(numbers))
        deflections = place_table(numbers)
        if deflections.rows:
            print_table(*deflections)
    for name, body in numbers["bodies"].items():
        if "eigenvalues" in body:
            console.print(f"{name}: {body['eigenvalues']}", highlight=False)
    console.print(cost_line(result.solution.statistics), highlight=False)
    console.print(f"Results are in {folder}/", highlight=False)
