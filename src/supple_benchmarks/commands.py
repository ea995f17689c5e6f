"""The commands `supple benchmark NAME` of all benchmarks that have only the shared options."""

# No postponed annotations: Typer reads the annotations of each command, which contain its help texts.
import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from supple.terminal import reported_errors, reported_warnings
from supple_benchmarks.options import Debug, Json

__all__ = [
    "eigenvalue_error",
    "explicit",
    "intrinsic",
    "invariance",
    "rotating_beam",
    "sweep",
    "trust",
    "validation",
]


def _command(
    name: str, summary: str, *, quick: str, output: str = "Folder of the report."
) -> Callable[..., None]:
    """The command of a benchmark: it calls `perform(quick, json, folder)` of the benchmark's package.

    Parameters
    ----------
    name          : str   of the benchmark; its package has underscores for hyphens
    summary       : str   the help of the command
    quick, output : str   the help of its options
    """
    package = name.replace("-", "_")

    def command(
        quick: Annotated[bool, typer.Option("--quick", help=quick)] = False,
        json: Json = None,
        output: Annotated[Path, typer.Option("-o", "--output", help=output)] = Path("results") / name,
        debug: Debug = False,
    ) -> None:
        # Imported here: the solvers take seconds to load, which the help does not need.
        from supple.algebra.jax_settings import keep_compiled_programs

        perform = importlib.import_module(f"supple_benchmarks.{package}.perform").perform
        keep_compiled_programs()
        with reported_errors(debug=debug), reported_warnings():
            perform(quick, json, output)

    command.__name__, command.__doc__ = package, summary
    return command


eigenvalue_error = _command(
    "eigenvalue-error",
    "Reduce the bodies of [Han2020] to three tolerances; compare mode counts, estimates and true errors.",
    quick="Coarse meshes: under a minute.",
    output="Folder of report and figures.",
)
explicit = _command(
    "explicit",
    "Free flight, step limits, coupling by multipliers, Taylor bar, a crash and throughput.",
    quick="Small meshes, short motions: minutes.",
)
intrinsic = _command(
    "intrinsic",
    "Slender bodies at any rotation, against closed forms, [Wang2015] and the other methods.",
    quick="Small meshes, short motions: some minutes.",
)
invariance = _command(
    "invariance",
    "Locking, ties, damping, curvature, buckling, vibration, splitting: against independent references.",
    quick="Small meshes, short motions: a minute.",
    output="Folder of report and figures.",
)
rotating_beam = _command(
    "rotating-beam",
    "Spin up the beam of [Wu2019] section 6.1, full and reduced, and compare with the paper's numbers.",
    quick="One speed, coarse mesh: under a minute.",
    output="Folder of report, figures and motions.",
)
sweep = _command(
    "sweep",
    "Sweep throughput on one core, all cores and a Dask cluster; rounding, memory, time to read a column.",
    quick="Fewer and shorter cases: a minute.",
)
trust = _command(
    "trust",
    "Estimated errors of self-correcting runs, against full runs made afterwards.",
    quick="Two cases: one and a half minutes.",
    output="Folder of full runs and finished cases, which are read again.",
)
validation = _command(
    "validation",
    "Machines, beams, rotors and impacts, against closed forms and published numbers.",
    quick="Leave out the longest cases: 90 s.",
)
