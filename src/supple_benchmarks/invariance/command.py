"""The command `supple benchmark invariance`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from supple.terminal import reported_errors, reported_warnings
from supple_benchmarks.options import Debug, Json

__all__ = ["invariance"]


def invariance(
    quick: Annotated[bool, typer.Option("--quick", help="Small meshes, short motions: a minute.")] = False,
    json: Json = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for figures.")] = Path(
        "results/invariance"
    ),
    debug: Debug = False,
) -> None:
    """Locking, ties, damping, curvature, buckling, vibration and splitting beside independent references."""
    # Imported here: the solvers take seconds to load, which the help need not wait for.
    from supple.algebra.jax_settings import keep_compiled_programs
    from supple_benchmarks.invariance.perform import perform

    keep_compiled_programs()
    with reported_errors(debug=debug), reported_warnings():
        perform(quick, json, output)
