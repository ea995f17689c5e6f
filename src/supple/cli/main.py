"""The command `supple`: its subcommands, options and help texts."""

from __future__ import annotations

import gc
from collections.abc import Callable
from dataclasses import fields
from functools import wraps
from importlib import import_module
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer
from typer.core import TyperGroup

from supple import __version__
from supple.cli.benchmark import BenchmarkGroup
from supple.cli.export import AllowCode, ExportOptions
from supple.cli.export import export as write_export
from supple.errors import ArgumentError
from supple.progress import show_progress
from supple.terminal import console, print_rows, reported_errors, reported_warnings, say, show_any_character

app = typer.Typer(
    help="Reduced-order flexible multibody dynamics.",
    no_args_is_help=True,
    add_completion=False,
    # Plain text, because markup would read [spin] as a style and add a type to every flag.
    rich_markup_mode=None,
    context_settings={"max_content_width": 110},
    pretty_exceptions_show_locals=False,
)
app.add_typer(
    typer.Typer(cls=BenchmarkGroup, rich_markup_mode=None),
    name="benchmark",
    help="Run a published benchmark and compare its results with the numbers of the paper.",
    no_args_is_help=True,
)


class SweepGroup(TyperGroup):
    """The commands of `sweep`; a file name in place of a command runs that sweep."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """The arguments, with `run` inserted before a file name or an option of that command."""
        if args and args[0] not in {*self.commands, "--help"}:
            args = ["run", *args]
        return super().parse_args(ctx, args)


sweep_app = typer.Typer(cls=SweepGroup, rich_markup_mode=None)
app.add_typer(
    sweep_app,
    name="sweep",
    help="Run a sweep, the cases of a table (supple sweep CASES.toml -o FOLDER), or print its progress.",
    no_args_is_help=True,
)

CaseFile = Annotated[Path, typer.Argument(help="Case file (TOML).")]
Folder = Annotated[
    Path | None, typer.Option("-o", "--output", help="Folder for results; default: results/CASE.")
]
Instant = Annotated[
    float, typer.Option(help="Time at which loads and laws are evaluated, in the case's unit of time.")
]
NoErrors = Annotated[
    bool,
    typer.Option(
        "--no-errors", help="Skip the error estimate of the bases, which factorises the full bodies."
    ),
]
_DEBUG = Parameter(
    "debug",
    Parameter.KEYWORD_ONLY,
    default=False,
    annotation=Annotated[bool, typer.Option("--debug", help="Show the whole traceback of an error.")],
)


def main() -> None:
    """Entry point of the command."""
    gc.disable()  # imports make hardly any garbage; `reported` enables the collection after them
    show_any_character()
    show_progress(False)  # commands draw their own progress bars
    app()


def _print_version(wanted: bool) -> None:
    if wanted:
        console.print(f"supple {__version__}", highlight=False)
        raise typer.Exit


def reported(module: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Decorator: a command with the option --debug, whose errors and warnings are printed.

    module : that of the command, imported before the collection of garbage, which skips what is imported
    """

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        @wraps(command)
        def called(*, debug: bool, **given: Any) -> None:
            with reported_errors(debug=debug), reported_warnings():
                import_module(module)
                if not gc.isenabled():
                    gc.freeze()
                    gc.enable()
                command(**given)

        own = signature(command, eval_str=True).parameters.values()
        vars(called)["__signature__"] = Signature([*own, _DEBUG])
        return called

    return decorate


def with_options(kind: type[ExportOptions]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Decorator: the fields of a dataclass become options of a command, which receives it as `options`."""
    types = get_type_hints(kind, include_extras=True)

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        @wraps(command)
        def called(**given: Any) -> None:
            options = kind(**{name: given.pop(name) for name in types})
            command(**given, options=options)

        *own, _ = signature(command, eval_str=True).parameters.values()
        more = [
            Parameter(each.name, Parameter.KEYWORD_ONLY, default=each.default, annotation=types[each.name])
            for each in fields(kind)
        ]
        vars(called)["__signature__"] = Signature([*own, *more])
        return called

    return decorate


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Reduced-order flexible multibody dynamics."""


@app.command()
@reported("supple.cli.computed_case")
def run(
    case: CaseFile,
    output: Folder = None,
    strict: Annotated[
        bool,
        typer.Option(
            "--strict", help="End with an error where a run would warn of its start, steps or validity."
        ),
    ] = False,
    resume: Annotated[bool, typer.Option("--resume", help="Continue an interrupted run.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Replace existing results.")] = False,
    no_errors: Annotated[
        bool, typer.Option("--no-errors", help="Skip the error estimate, which repeats the run twice.")
    ] = False,
    allow_code: AllowCode = False,
) -> None:
    """Simulate a case file; write results (HDF5, JSON), report (HTML), pictures (PNG) and animation (GIF)."""
    # Imported here, because the solvers take seconds to load, and help and version do not need them.
    from supple.algebra.jax_settings import keep_compiled_programs
    from supple.cli.computed_case import run_case

    keep_compiled_programs()
    folder, errors = output or Path("results") / case.stem, not no_errors
    run_case(case, folder, resume=resume, force=force, strict=strict, errors=errors, allow_code=allow_code)


@sweep_app.command("run", hidden=True)
@reported("supple.cli.sweep")
def sweep(
    path: Annotated[
        Path,
        typer.Argument(
            metavar="CASES", help="Sweep file (TOML), which names a case file and the table of the cases."
        ),
    ],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder for results; default: results/CASES.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Number of processes on this computer; default: one per core.")
    ] = None,
    cluster: Annotated[
        str | None, typer.Option(help="Address of the scheduler of a Dask cluster, such as tcp://host:8786.")
    ] = None,
    mpi: Annotated[
        bool,
        typer.Option("--mpi", help="Use MPI processes (mpiexec .. python -m mpi4py.futures -m supple ..)."),
    ] = False,
    share: Annotated[
        str | None,
        typer.Option(help="K/N, for job arrays: run the cases of job K of N jobs, in this process."),
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Start again and replace the folder. Not with --share.")
    ] = False,
    allow_code: AllowCode = False,
) -> None:
    """Simulate the cases of a table; the same command continues an interrupted sweep.

    Exit code 0: every case has results; 3: every case has run, some failed; 4: some cases have not run.
    """
    from supple.algebra.jax_settings import keep_compiled_programs
    from supple.cli.sweep import chosen_executors, sweep_cases

    keep_compiled_programs()
    executors = chosen_executors(workers, cluster, mpi, share)
    folder = output or Path("results") / path.stem
    sweep_cases(path, folder, executors, share, force=force, allow_code=allow_code)


@sweep_app.command("status")
@reported("supple.cli.sweep")
def sweep_status(folder: Annotated[Path, typer.Argument(help="Folder of a sweep.")]) -> None:
    """Print the progress of a sweep; exit codes as for the sweep."""
    from supple.cli.sweep import print_status

    print_status(folder)


@sweep_app.command("page")
@reported("supple.cli.sweep")
def sweep_page(
    folder: Annotated[Path, typer.Argument(help="Folder of a sweep.")],
    reports: Annotated[
        int,
        typer.Option(
            min=0, help="Number of cases to simulate again for a report; those with the most extremes."
        ),
    ] = 3,
    allow_code: AllowCode = False,
) -> None:
    """Write the page of a sweep (HTML): table, plots, extremes, and reports of the extreme cases."""
    from supple.algebra.jax_settings import keep_compiled_programs
    from supple.cli.sweep import write_pages

    keep_compiled_programs()
    write_pages(folder, reports, allow_code=allow_code)


@app.command()
@reported("supple.cli.computed_case")
def reduce(case: CaseFile, output: Folder = None) -> None:
    """Reduce the bodies of a case file; write each to an HDF5 file, which cases read by reduced = "FILE"."""
    from supple.cli.computed_case import reduce_case

    reduce_case(case, output or Path("results") / case.stem)


@app.command()
@reported("supple.cli.computed_case")
def static(
    case: CaseFile,
    output: Folder = None,
    time: Instant = 0.0,
    no_errors: NoErrors = False,
    allow_code: AllowCode = False,
) -> None:
    """Find the equilibrium of the machine of a case file; with a [spin] table, that in steady rotation."""
    from supple.algebra.jax_settings import keep_compiled_programs
    from supple.cli.computed_case import static_case

    keep_compiled_programs()
    folder = output or Path("results") / case.stem
    static_case(case, folder, time=time, errors=not no_errors, allow_code=allow_code)


@app.command()
@reported("supple.cli.computed_case")
def modes(
    case: CaseFile,
    output: Folder = None,
    number: Annotated[
        int, typer.Option("-n", "--number", min=1, help="Number of modes, from the lowest frequency up.")
    ] = 6,
    time: Instant = 0.0,
    rates: Annotated[
        str | None,
        typer.Option(
            help="FROM:TO:NUMBER: Campbell diagram at NUMBER rates of the case's spin, in rad per unit of "
            "time; loads have their values at time 0."
        ),
    ] = None,
    no_errors: NoErrors = False,
    allow_code: AllowCode = False,
) -> None:
    """Find the modes of the machine of a case file about its equilibrium; draw and animate them."""
    from supple.algebra.jax_settings import keep_compiled_programs
    from supple.cli.computed_case import modes_case

    keep_compiled_programs()
    folder, errors = output or Path("results") / case.stem, not no_errors
    modes_case(case, folder, n_modes=number, time=time, rates=rates, errors=errors, allow_code=allow_code)


@app.command()
@reported("supple.cases")
@with_options(ExportOptions)
def export(
    path: Annotated[Path, typer.Argument(help="Result of a run (.h5), or a case file (.toml).")],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="File to write. From a result: .vtkhdf (ParaView), .vtu (one time), .csv, .mat, .outb, .nc "
            "or .h5 (tables). From a case: a deck (.inp), a mode (.vtkhdf, .vtu), a body (.op4, .pch for "
            "Nastran, .sid for Simpack, .fem for MBDyn, .npz for Exudyn, .dat for OpenFAST), or the machine "
            "for co-simulation (.fmu).",
        ),
    ] = None,
    c: Annotated[
        Path | None, typer.Option("--c", help="Folder for the machine in C: source, header, test, Makefile.")
    ] = None,
    *,
    options: ExportOptions,
) -> None:
    """Export a run (for ParaView, or as tables), a mode (for ParaView), a body (as a deck, or for other
    programs), or a machine (C source with --c FOLDER, FMU for co-simulation with -o FILE.fmu).

    A deck for Abaqus or CalculiX contains one body, clamped at its joints.
    """
    write_export(path, output, c, options)


@app.command()
@reported("supple.cli.info")
def info(
    path: Annotated[
        Path,
        typer.Argument(
            help="Case (.toml), deck (.inp, .bdf ..), mesh (.msh), section table (.csv ..) or result (.h5)."
        ),
    ],
    json: Annotated[
        Path | None, typer.Option("--json", help="JSON file to write, with the numbers of a deck.")
    ] = None,
    modes: Annotated[
        int, typer.Option(min=0, help="Number of frequencies of a deck to compute, from the lowest up.")
    ] = 0,
    held: Annotated[
        bool,
        typer.Option("--held", help="Compute these frequencies with the supports of the deck, not free."),
    ] = False,
) -> None:
    """Print a summary of a case, deck, mesh, section table or result file."""
    from supple.cli.info import print_info

    print_info(path, json=json, n_modes=modes, held=held)


@app.command()
@reported("supple.cli.check")
def check(
    path: Annotated[
        Path, typer.Argument(help="Case (.toml), Nastran model (.bdf ..) or HDF5 matrices (.h5).")
    ],
    modes: Annotated[int, typer.Option(min=0, help="Number of elastic modes to compute.")] = 6,
) -> None:
    """Check the models of a file; exit with an error if a model cannot be used."""
    from supple.cli.check import print_check

    print_check(path, n_frequencies=modes)


@app.command()
@reported("supple.cases")
def example(
    name: Annotated[
        str | None, typer.Argument(help="Name of an example; default: list all examples.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder for the example; default: the current one.")
    ] = None,
) -> None:
    """List the examples, or write one with its mesh into a folder."""
    from supple import cases

    if name is None:
        if output is not None:
            raise ArgumentError("-o is the folder for an example: give the name of an example as well")
        print_rows("Examples: supple example NAME", cases.example_titles().items())
        return
    files = cases.write_example(name, output or Path())
    for path in files:
        say(f"wrote {path}")
    say(f"Run it: {cases.command_of_example(files[0])}")


@app.command()
@reported("supple.cases")
def new(
    mesh: Annotated[
        Path,
        typer.Argument(
            help="Mesh, deck, section table or machine (.msh, .bdf, .csv, .urdf ..); default: a prompt."
        ),
    ] = Path(),
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Case file to write; default: MESH.toml.")
    ] = None,
) -> None:
    """Write a commented case file for a mesh, section table or machine; comments mark the guesses."""
    from supple import cases

    file = mesh if mesh != Path() else Path(typer.prompt("Mesh, deck or section table"))
    written = output or Path(f"{file.stem}.toml")
    cases.write_new_case(file, written)
    say(f"wrote {written}: edit the lines marked GUESS, then run: supple run {written}")
