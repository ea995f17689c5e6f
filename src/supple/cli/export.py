"""`supple export`: choice of the output by the file name, and check of its options."""

from __future__ import annotations

from dataclasses import dataclass, fields
from importlib import import_module
from pathlib import Path
from typing import Annotated

from typer import Option

from supple.errors import ArgumentError

AllowCode = Annotated[
    bool,
    Option(
        "--allow-code",
        help="Allow the Python file that the case names in `control`. Review it first: it can do anything.",
    ),
]


@dataclass(frozen=True)
class ExportOptions:
    """The options of the command that are not common to all outputs."""

    body: Annotated[
        list[str] | None,
        Option(help="Name of a body; default: all. For ParaView also several (--body A --body B)."),
    ] = None
    time: Annotated[
        float | None,
        Option(help="Time of a .vtu file or of the loads of a deck; default: the end of the run."),
    ] = None
    mode: Annotated[
        int | None, Option(min=1, help="Number of the mode to write for ParaView; 1: the lowest.")
    ] = None
    times: Annotated[str | None, Option(help="FROM:TO:NUMBER: NUMBER times of a result; default: all.")] = (
        None
    )
    stress: Annotated[
        bool, Option("--stress/--no-stress", help="With or without stress in files of runs for ParaView.")
    ] = True
    case: Annotated[Path | None, Option(help="Case file of a result, if this file was moved.")] = None
    abaqus: Annotated[bool, Option("--abaqus", help="Write a deck for Abaqus instead of CalculiX.")] = False
    superelement: Annotated[
        bool,
        Option(
            "--superelement",
            help="Write the reduced body as a superelement: a deck to include in another deck.",
        ),
    ] = False
    inputs: Annotated[
        list[str] | None,
        Option("--input", help="Joint, spring or element whose law is an input of the C code or the FMU."),
    ] = None
    fmi: Annotated[int | None, Option(min=2, max=3, help="Version of FMI; default: 3.")] = None
    platforms: Annotated[
        list[str] | None,
        Option(
            "--platform",
            help="Operating system for which an FMU is built: linux, windows or macos (needs supple[fmu]); "
            "default: that of this computer, with its compiler.",
        ),
    ] = None
    linear: Annotated[
        bool,
        Option(
            "--linear", help="Write an FMU with the matrices of the machine linearised about its equilibrium."
        ),
    ] = False
    allow_code: AllowCode = False

    @property
    def given(self) -> list[str]:
        """Names of the options whose values differ from the defaults."""
        return [each.name for each in fields(self) if getattr(self, each.name) not in (each.default, [])]


_FLAGS = {"stress": "--no-stress", "inputs": "--input", "platforms": "--platform"}


def _flag(name: str) -> str:
    return _FLAGS.get(name, f"--{name.replace('_', '-')}")


@dataclass(frozen=True)
class _Target:
    """A kind of output: description, its options, and its writer as `module:function`, loaded on use."""

    words: str
    options: tuple[str, ...]
    writer: str

    def check(self, options: ExportOptions) -> None:
        """Raise ArgumentError for options that do not apply to this output."""
        other = [_flag(name) for name in options.given if name not in self.options]
        if other:
            taken = ", ".join(map(_flag, self.options)) or "none"
            raise ArgumentError(
                f"{' and '.join(other)} {'is' if len(other) == 1 else 'are'} not for {self.words}: remove "
                f"{'it' if len(other) == 1 else 'them'} (its options: {taken})"
            )


def export(path: Path, output: Path | None, c: Path | None, options: ExportOptions) -> None:
    """Write a file of a case or of a result, or a folder `c` of C source.

    Raises
    ------
    ArgumentError   neither file nor folder, or both; an option that the output does not have
    errors of the writer
    """
    if output is None and c is None:
        raise ArgumentError("give the file to write (-o FILE), or the folder for C source (--c FOLDER)")
    if output is not None and c is not None:
        raise ArgumentError("a machine is written as C (--c FOLDER) or as a file (-o FILE): give one of them")
    target = _target(path, output, options)
    target.check(options)
    goal = output or c
    assert goal is not None
    module, _, function = target.writer.partition(":")
    getattr(import_module(f"supple.cli.{module}"), function)(path, goal, options)


def _target(path: Path, output: Path | None, options: ExportOptions) -> _Target:
    """The output for these arguments: the first matching row."""
    from supple.cli.export_superelement import SUPERELEMENT_SUFFIXES
    from supple.export import TABLE_SUFFIXES

    is_case, suffix = path.suffix.lower() == ".toml", output and output.suffix.lower()
    of_result = () if is_case else ("case",)
    if options.superelement and suffix != ".inp":
        raise ArgumentError("--superelement is for a deck (.inp); other suffixes determine their format")
    machine = ("inputs", "allow_code", *of_result)
    fmu = ("linear", "fmi", "platforms", *machine)
    body, result = "export_superelement:export_superelement", "export_result:export_result"
    rows = (
        (output is None, "a machine as C", machine, "export_machine:export_c"),
        (suffix == ".fmu", "an FMU", fmu, "export_machine:export_fmu"),
        (options.mode is not None, "a mode", ("mode", "body", "time"), "export_result:export_mode"),
        (options.superelement, "a deck with a superelement", ("superelement", "body", "abaqus"), body),
        (suffix in SUPERELEMENT_SUFFIXES, "a superelement", ("body",), body),
        (is_case, "the deck of a case's body", ("body", "time", "abaqus"), "export_case:export_case"),
        (suffix == ".vtu", "a .vtu, which contains one time", (*_PICTURE, "time"), result),
        (suffix in TABLE_SUFFIXES, "a table of the whole machine", ("times", "case"), result),
        (True, "a file for ParaView", (*_PICTURE, "times"), result),
    )
    return next(_Target(words, own, writer) for applies, words, own, writer in rows if applies)


_PICTURE = ("body", "stress", "case")
