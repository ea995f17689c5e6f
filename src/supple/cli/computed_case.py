"""The commands that compute one case (run, equilibrium, modes, reduce): progress bars and printed tables."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import typer

from supple import cases
from supple.blas_threads import one_blas_thread
from supple.cases.run_files import check_not_an_input, stored_so_far
from supple.error import SelfCorrectionError, correction_numbers
from supple.errors import ArgumentError, CaseError
from supple.integrate import StepProgress
from supple.reduction import ReducedBody
from supple.results import body_numbers, unit_names
from supple.results.descriptions import describe_reduction
from supple.results.explicit_numbers import explicit_cost_line
from supple.results.mode_tables import mode_tables, speed_tables
from supple.results.rest_tables import rest_error_table, rest_tables
from supple.results.run_start import start_lines
from supple.results.run_tables import (
    body_table,
    correction_table,
    cost_line,
    error_lines,
    error_table,
    motion_tables,
)
from supple.simulation import reduced_bodies, store_body
from supple.simulation.interruption import INTERRUPTIONS, Terminated, raising_terminated
from supple.simulation.stored_bodies import stored_path
from supple.terminal import (
    ProgressBars,
    error_console,
    print_rows,
    print_table,
    progress_bars,
    say,
    shown_step,
    words,
)

_STABILITY = {True: "Stable", False: "Unstable", None: "An"}
"""First word of the printed line, by the stability of the equilibrium; None: unknown stability."""


@contextmanager
def shown_case(path: Path) -> Iterator[tuple[cases.Case, StepProgress]]:
    """Print the title of the case at `path`, and within the block a bar for each step that is reported."""
    bars = progress_bars()
    steps = ProgressBars(bars)
    case = cases.read_case(path, steps.show)
    say(case.title, "bold")
    with bars:
        yield case, steps.share
        steps.finish()


@contextmanager
def stated_interruption(kept: Callable[[BaseException], str]) -> Iterator[None]:
    """If interrupted by Ctrl-C (SIGINT) or the system (SIGTERM), print what is kept; exit with 130 or 143."""
    with raising_terminated():
        try:
            yield
        except INTERRUPTIONS as error:
            error_console.print(words("stopped: ", "bold red") + words(kept(error)), soft_wrap=True)
            number = signal.SIGTERM if isinstance(error, Terminated) else signal.SIGINT
            raise typer.Exit(128 + number) from error


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


def reduce_case(path: Path, folder: Path) -> None:
    """Perform the reductions of fixed size in the case at `path`; write each body to NAME-reduced.h5.

    Raises
    ------
    CaseError           mistakes in the case file; no body to reduce
    ResultFileError     a file that cannot be written
    SuppleError         errors of building and reducing
    """
    # As in a run: signs and last digits of modes depend on the number of threads.
    with shown_step("reducing") as notify, one_blas_thread():
        case = cases.read_case(path, notify)
        check_not_an_input(case, [stored_path(folder, name) for name in case.made_here])
        bodies = reduced_bodies(case.system, case.made_here)
    if not bodies:
        raise CaseError(
            f"{path} has no body to reduce: give an elastic body a reduction of fixed size, for example "
            'reduction = { basis = "error-controlled", tolerance = 1e-3, modes = 10 }; supple run writes '
            "self-correcting bodies"
        )
    numbers = {body.name: body_numbers(body, case.units, case.fulls.get(body.name)) for body in bodies}
    print_table(*body_table({"units": unit_names(case.units), "bodies": numbers}))
    for body in bodies:
        print_rows(f"Reduction of {body.name}", describe_reduction(body.report))
        written = store_body(body, folder)
        say(f"written to {written} ({written.stat().st_size / 2**20:.1f} MiB)")
