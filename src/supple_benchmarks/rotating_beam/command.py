"""The command `supple benchmark rotating-beam`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from supple.terminal import reported_errors, reported_warnings
from supple_benchmarks.options import Debug, Json

__all__ = ["rotating_beam"]


def rotating_beam(
    quick: Annotated[bool, typer.Option("--quick", help="One speed, coarse mesh: under a minute.")] = False,
    json: Json = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for figures.")] = Path(
        "results/rotating-beam"
    ),
    debug: Debug = False,
) -> None:
    """Spin up the beam of [Wu2019] section 6.1, full and reduced, and set our numbers beside the paper's."""
    # Imported here: the solvers take seconds to load, which the help need not wait for.
    from supple.algebra.jax_settings import keep_compiled_programs
    from supple_benchmarks.rotating_beam.perform import perform
    from supple_benchmarks.rotating_beam.problem import RotatingBeam

    keep_compiled_programs()
    with reported_errors(debug=debug), reported_warnings():
        perform(RotatingBeam.quick() if quick else RotatingBeam(), json, output)
