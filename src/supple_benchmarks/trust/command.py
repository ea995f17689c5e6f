"""The command `supple benchmark trust`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from supple.terminal import reported_errors, reported_warnings
from supple_benchmarks.options import Debug, Json

__all__ = ["trust"]


def trust(
    quick: Annotated[bool, typer.Option("--quick", help="Two cases: one and a half minutes.")] = False,
    json: Json = None,
    output: Annotated[
        Path,
        typer.Option("-o", "--output", help="Folder for full runs and finished cases, which are read again."),
    ] = Path("results/trust"),
    debug: Debug = False,
) -> None:
    """Stated errors of runs that correct themselves, beside full runs that they have never seen."""
    # Imported here: the solvers take seconds to load, which the help need not wait for.
    from supple.algebra.jax_settings import keep_compiled_programs
    from supple_benchmarks.trust.perform import perform

    keep_compiled_programs()
    with reported_errors(debug=debug), reported_warnings():
        perform(quick, json, output)
