"""The command `supple benchmark blade`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from supple.terminal import reported_errors, reported_warnings
from supple_benchmarks.options import Debug, Json

__all__ = ["blade"]


def blade(
    quick: Annotated[
        bool, typer.Option("--quick", help="Coarse blade, two seconds of motion: under a minute.")
    ] = False,
    seconds: Annotated[
        float, typer.Option("--seconds", min=1.0, help="Duration of the full-order runs, s.")
    ] = 20.0,
    longest: Annotated[
        float, typer.Option("--longest", min=1.0, help="Duration of the longest full-order run, s.")
    ] = 100.0,
    json: Json = None,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder of figures and motions; stored runs are reused.")
    ] = Path("results/blade-benchmark"),
    debug: Debug = False,
) -> None:
    """The 61.5 m blade of [Wu2019] section 6.2 in the wind: full (two hours), reduced, self-correcting."""
    # Imported here: the solvers take seconds to load, which the help does not need.
    from supple.algebra.jax_settings import keep_compiled_programs
    from supple_benchmarks.blade.perform import perform
    from supple_benchmarks.blade.run import BladeBenchmark

    keep_compiled_programs()
    with reported_errors(debug=debug), reported_warnings():
        size = BladeBenchmark.quick() if quick else BladeBenchmark.whole(seconds, longest)
        perform(size, json, output)
