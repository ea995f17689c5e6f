"""The command `supple benchmark eigenvalue-error`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from supple.terminal import reported_errors, reported_warnings
from supple_benchmarks.options import Debug, Json

__all__ = ["eigenvalue_error"]


def eigenvalue_error(
    quick: Annotated[bool, typer.Option("--quick", help="Coarse meshes: under a minute.")] = False,
    json: Json = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for figures.")] = Path(
        "results/eigenvalue-error"
    ),
    debug: Debug = False,
) -> None:
    """Reduce the bodies of [Han2020] to three tolerances; set counts, estimates and errors side by side."""
    # Imported here: the solvers take seconds to load, which the help need not wait for.
    from supple_benchmarks.eigenvalue_error.perform import perform
    from supple_benchmarks.eigenvalue_error.problem import EigenvalueErrors

    with reported_errors(debug=debug), reported_warnings():
        perform(EigenvalueErrors.quick() if quick else EigenvalueErrors(), json, output)
