"""The command `supple benchmark validation`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from supple.terminal import reported_errors, reported_warnings
from supple_benchmarks.options import Debug, Json

__all__ = ["validation"]


def validation(
    quick: Annotated[bool, typer.Option("--quick", help="Leave out the longest cases: 90 s.")] = False,
    json: Json = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder of the report.")] = Path(
        "results/validation"
    ),
    debug: Debug = False,
) -> None:
    """Machines, beams, rotors and impacts beside closed forms and published numbers."""
    # Imported here: the solvers take seconds to load, which the help need not wait for.
    from supple.algebra.jax_settings import keep_compiled_programs
    from supple_benchmarks.validation.perform import perform

    keep_compiled_programs()
    with reported_errors(debug=debug), reported_warnings():
        perform(quick, json, output)
