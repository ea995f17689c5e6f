"""The command `supple benchmark explicit`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from supple.terminal import reported_errors, reported_warnings
from supple_benchmarks.options import Debug, Json

__all__ = ["explicit"]


def explicit(
    quick: Annotated[bool, typer.Option("--quick", help="Small meshes, short motions: minutes.")] = False,
    json: Json = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the report.")] = Path(
        "results/explicit"
    ),
    debug: Debug = False,
) -> None:
    """Free flight, step limits, coupling by multipliers, Taylor bar, a crash and throughput."""
    # Imported here: the solvers take seconds to load, which the help need not wait for.
    from supple.algebra.jax_settings import keep_compiled_programs
    from supple_benchmarks.explicit.perform import perform

    keep_compiled_programs()
    with reported_errors(debug=debug), reported_warnings():
        perform(quick, json, output)
