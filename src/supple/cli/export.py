"""`supple export`: choice of the output by the file name, and check of its options."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from importlib import import_module
from pathlib import Path

from supple.errors import ArgumentError


@dataclass(frozen=True)
class ExportOptions:
    """The options of the command, with their defaults.

    body : names of bodies; by default all, or the only one that can be written
    time : of the loads, of the state of a mode, or of a .vtu; by default the end of the run, for a mode 0
    mode : number from 1, in order of frequency
    times : FROM:TO:NUMBER, evenly spaced output times of a result; by default all
    stress : whether files of runs for ParaView contain stress
    case : present path of the case file of a result, as in `result_machine`
    abaqus : write for Abaqus instead of CalculiX
    superelement : write the reduced body in a deck
    inputs : names of joints, springs and elements whose laws become inputs
    fmi : version of FMI, 2 or 3; by default 3
    platforms : operating systems of the libraries of an FMU; by default this computer's
    linear : export the machine linearised about its equilibrium, as matrices
    allow_code : whether the controllers of the case may run
    """

    body: Sequence[str] | None = None
    time: float | None = None
    mode: int | None = None
    times: str | None = None
    stress: bool = True
    case: Path | None = None
    abaqus: bool = False
    superelement: bool = False
    inputs: Sequence[str] | None = None
    fmi: int | None = None
    platforms: Sequence[str] | None = None
    linear: bool = False
    allow_code: bool = False

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
        (output is None, _Target("a machine as C", machine, "export_machine:export_c")),
        (suffix == ".fmu", _Target("an FMU", fmu, "export_machine:export_fmu")),
        (options.mode is not None, _Target("a mode", ("mode", "body", "time"), "export_mode:export_mode")),
        (
            options.superelement,
            _Target("a deck with a superelement", ("superelement", "body", "abaqus"), body),
        ),
        (suffix in SUPERELEMENT_SUFFIXES, _Target("a superelement", ("body",), body)),
        (
            is_case,
            _Target("the deck of a case's body", ("body", "time", "abaqus"), "export_case:export_case"),
        ),
        (suffix == ".vtu", _Target("a .vtu, which contains one time", (*_PICTURE, "time"), result)),
        (suffix in TABLE_SUFFIXES, _Target("a table of the whole machine", ("times", "case"), result)),
        (True, _Target("a file for ParaView", (*_PICTURE, "times"), result)),
    )
    return next(target for applies, target in rows if applies)


_PICTURE = ("body", "stress", "case")
