"""The command `supple benchmark intrinsic`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from supple.terminal import reported_errors, reported_warnings
from supple_benchmarks.options import Debug, Json

__all__ = ["intrinsic"]


def intrinsic(
    quick: Annotated[
        bool, typer.Option("--quick", help="Small meshes, short motions: some minutes.")
    ] = False,
    json: Json = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the report.")] = Path(
        "results/intrinsic"
    ),
    debug: Debug = False,
) -> None:
    """Slender bodies at any rotation: beside closed forms, [Wang2015] and the other methods."""
    # Imported here: the solvers take seconds to load, which the help need not wait for.
    from supple.algebra.jax_settings import keep_compiled_programs
    from supple_benchmarks.intrinsic.perform import perform

    keep_compiled_programs()
    with reported_errors(debug=debug), reported_warnings():
        perform(quick, json, output)
