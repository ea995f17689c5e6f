"""The command `supple`: parse, call, print."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from supple import __version__
from supple.cli.console import console, reported_errors, reported_warnings

if TYPE_CHECKING:
    from supple.benchmark.quadruple_pendulum import QuadruplePendulum
    from supple.benchmark.slider_crank import SliderCrank

app = typer.Typer(
    help="Reduced-order flexible multibody dynamics.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_show_locals=False,
)
benchmark_app = typer.Typer(help="Run a published benchmark and set our numbers beside the paper's.")
app.add_typer(benchmark_app, name="benchmark", no_args_is_help=True)

Debug = Annotated[bool, typer.Option("--debug", help="Show the whole traceback of an error.")]
Json = Annotated[Path | None, typer.Option("--json", help="Report file; default: in the output folder.")]


def main() -> None:
    """Entry point of the command."""
    app()


def _print_version(wanted: bool) -> None:
    if wanted:
        console.print(f"supple {__version__}", highlight=False)
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Reduced-order flexible multibody dynamics."""


@app.command()
def run(
    case: Annotated[Path, typer.Argument(help="Case file (TOML).")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder for results; default: results/CASE.")
    ] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Stop where a model leaves its validity.")] = False,
    resume: Annotated[bool, typer.Option("--resume", help="Continue a run that was cut off.")] = False,
    debug: Debug = False,
) -> None:
    """Simulate a case file; write results (HDF5, JSON), pictures (PNG) and an animation (GIF)."""
    # Imported here: the solvers take seconds to load, which help and version need not wait for.
    from supple.algebra.compilation_cache import keep_compiled_programs
    from supple.cli.run_case import run_case

    keep_compiled_programs()
    with reported_errors(debug=debug), reported_warnings():
        run_case(case, output or Path("results") / case.stem, resume=resume, strict=strict)


@app.command()
def reduce(
    case: Annotated[Path, typer.Argument(help="Case file (TOML).")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder for the bodies; default: results/CASE.")
    ] = None,
    debug: Debug = False,
) -> None:
    """Reduce the bodies of a case file and keep each (HDF5), for cases with reduced = "FILE"."""
    from supple.cli.reduce_case import reduce_case

    with reported_errors(debug=debug), reported_warnings():
        reduce_case(case, output or Path("results") / case.stem)


@app.command()
def info(
    path: Annotated[Path, typer.Argument(help="Case (.toml), mesh (.inp, .msh, .bdf ..) or result (.h5).")],
    debug: Debug = False,
) -> None:
    """Say what a case, mesh or result file holds."""
    from supple.cli.info import print_info

    with reported_errors(debug=debug), reported_warnings():
        print_info(path)


@app.command()
def check(
    path: Annotated[
        Path, typer.Argument(help="Case (.toml), Nastran model (.bdf ..) or HDF5 matrices (.h5).")
    ],
    modes: Annotated[int, typer.Option(min=0, help="Elastic modes to compute; 0 leaves modes out.")] = 6,
    debug: Debug = False,
) -> None:
    """Say whether the models of a file can be used; exit with an error if one cannot."""
    from supple.cli.check import print_check

    with reported_errors(debug=debug), reported_warnings():
        print_check(path, n_frequencies=modes)


@benchmark_app.command("rotating-beam")
def rotating_beam(
    quick: Annotated[bool, typer.Option("--quick", help="One speed, coarse mesh: under a minute.")] = False,
    json: Json = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for figures.")] = Path(
        "results/rotating-beam"
    ),
    debug: Debug = False,
) -> None:
    """Spin up the beam of [Wu2019] section 6.1, full and reduced, and set our numbers beside the paper's."""
    from supple.algebra.compilation_cache import keep_compiled_programs
    from supple.benchmark.rotating_beam import RotatingBeam
    from supple.cli.benchmark_rotating_beam import benchmark_rotating_beam

    keep_compiled_programs()
    with reported_errors(debug=debug), reported_warnings():
        benchmark_rotating_beam(RotatingBeam.quick() if quick else RotatingBeam(), json, output)


@benchmark_app.command("eigenvalue-error")
def eigenvalue_error(
    quick: Annotated[bool, typer.Option("--quick", help="Coarse meshes: under a minute.")] = False,
    json: Json = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for figures.")] = Path(
        "results/eigenvalue-error"
    ),
    debug: Debug = False,
) -> None:
    """Reduce the bodies of [Han2020] to three tolerances; set counts, estimates and errors side by side."""
    from supple.benchmark.eigenvalue_error import EigenvalueErrors
    from supple.cli.benchmark_eigenvalue_error import benchmark_eigenvalue_error

    with reported_errors(debug=debug), reported_warnings():
        benchmark_eigenvalue_error(EigenvalueErrors.quick() if quick else EigenvalueErrors(), json, output)


class Element(StrEnum):
    """Tetrahedra that a machine's flexible body may be made of."""

    TET4 = "tet4"
    TET10 = "tet10"

    @property
    def cell_type_name(self) -> str:
        """Name of the CellType."""
        return f"TETRA{self.value.removeprefix('tet')}"


MachineElement = Annotated[Element, typer.Option(help="Of the flexible body; --quick takes tet4.")]
MachineQuick = Annotated[
    bool, typer.Option("--quick", help="Coarse mesh, two tolerances, short time: under a minute.")
]


@benchmark_app.command("quadruple-pendulum")
def quadruple_pendulum(
    quick: MachineQuick = False,
    element: MachineElement = Element.TET10,
    json: Json = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for figures and motions.")] = Path(
        "results/quadruple-pendulum"
    ),
    debug: Debug = False,
) -> None:
    """Let the pendulum of [Han2020] section 5.1 fall, its last link reduced to three tolerances."""
    from supple.benchmark.quadruple_pendulum import QuadruplePendulum

    _benchmark_machine(QuadruplePendulum, quick, element, json, output, debug)


@benchmark_app.command("slider-crank")
def slider_crank(
    quick: MachineQuick = False,
    element: MachineElement = Element.TET10,
    json: Json = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for figures and motions.")] = Path(
        "results/slider-crank"
    ),
    debug: Debug = False,
) -> None:
    """Drive the slider-crank of [Han2020] section 5.2, its rod reduced to three tolerances."""
    from supple.benchmark.slider_crank import SliderCrank

    _benchmark_machine(SliderCrank, quick, element, json, output, debug)


def _benchmark_machine(
    problem: type[QuadruplePendulum] | type[SliderCrank],
    quick: bool,
    element: Element,
    json: Path | None,
    output: Path,
    debug: bool,
) -> None:
    from supple.algebra.compilation_cache import keep_compiled_programs
    from supple.cli.benchmark_tolerances import benchmark_tolerances
    from supple.mesh import CellType

    keep_compiled_programs()
    with reported_errors(debug=debug), reported_warnings():
        size = problem.quick() if quick else problem(cell_type=CellType[element.cell_type_name])
        benchmark_tolerances(size.machine(), size.tolerances, json, output)


@benchmark_app.command("blade")
def blade(
    quick: Annotated[
        bool, typer.Option("--quick", help="Coarse blade, two seconds of motion: under a minute.")
    ] = False,
    seconds: Annotated[
        float, typer.Option("--seconds", min=1.0, help="Motion that the full-order runs cover, s.")
    ] = 20.0,
    longest: Annotated[
        float, typer.Option("--longest", min=1.0, help="Motion that one of them covers, s.")
    ] = 100.0,
    json: Json = None,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder for figures and motions; a run goes on from there.")
    ] = Path("results/blade-benchmark"),
    debug: Debug = False,
) -> None:
    """The 61.5 m blade of [Wu2019] section 6.2 in the wind: full (two hours), reduced, self-correcting."""
    from supple.algebra.compilation_cache import keep_compiled_programs
    from supple.benchmark.blade_benchmark import BladeBenchmark
    from supple.cli.benchmark_blade import benchmark_blade

    keep_compiled_programs()
    with reported_errors(debug=debug), reported_warnings():
        size = BladeBenchmark.quick() if quick else BladeBenchmark.whole(seconds, longest)
        benchmark_blade(size, json, output)
