"""Run a case file, and say what came out."""

from __future__ import annotations

import signal
from pathlib import Path

import typer
from rich.markup import escape

from supple import cases
from supple.cases.remains import kept_so_far
from supple.correction import SelfCorrectionError, correction_numbers
from supple.results.run_tables import (
    body_table,
    correction_table,
    cost_line,
    joint_table,
    motion_table,
    place_table,
)
from supple.simulation.interruption import INTERRUPTIONS, Terminated, raising_terminated
from supple.terminal import Steps, console, error_console, print_table, progress_bars


def run_case(
    path: Path, folder: Path, *, resume: bool = False, force: bool = False, strict: bool = False
) -> None:
    """Run the case file at `path` and print its tables; parameters and errors as for `cases.run_case`.

    Stopped by Ctrl-C (SIGINT) or by the system (SIGTERM), it says what is kept, and exits with 130 or 143.
    """
    with raising_terminated():
        try:
            _run(path, folder, resume=resume, force=force, strict=strict)
        except INTERRUPTIONS as error:
            kept = "; ".join(getattr(error, "__notes__", [])) or kept_so_far(path, folder)
            error_console.print(
                f"[bold red]stopped:[/bold red] {escape(kept)}", highlight=False, soft_wrap=True
            )
            number = signal.SIGTERM if isinstance(error, Terminated) else signal.SIGINT
            raise typer.Exit(128 + number) from error


def _run(path: Path, folder: Path, *, resume: bool, force: bool, strict: bool) -> None:
    bars = progress_bars()
    steps = Steps(bars)
    case = cases.read_case(path, steps.show)
    console.print(f"[bold]{case.title}[/bold]", highlight=False)
    with bars:
        try:
            result = cases.run_case(
                case, folder, resume=resume, force=force, strict=strict, progress=steps.share
            )
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
