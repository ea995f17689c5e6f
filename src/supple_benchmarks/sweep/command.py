"""The command `supple benchmark sweep`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from supple.terminal import reported_errors, reported_warnings
from supple_benchmarks.options import Debug, Json

__all__ = ["sweep"]


def sweep(
    quick: Annotated[bool, typer.Option("--quick", help="Fewer and shorter cases: a minute.")] = False,
    json: Json = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the report.")] = Path(
        "results/sweep"
    ),
    debug: Debug = False,
) -> None:
    """Cases a second on one core, on all and on a Dask cluster; digits, memory, time to read a column."""
    # Imported here: the solvers take seconds to load, which the help need not wait for.
    from supple.algebra.jax_settings import keep_compiled_programs
    from supple_benchmarks.sweep.perform import perform

    keep_compiled_programs()
    with reported_errors(debug=debug), reported_warnings():
        perform(quick, json, output)
