"""`supple export`: choice of the output by the file name, and check of its options."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from supple.errors import ArgumentError

__all__ = ["ExportOptions", "export"]


@dataclass(frozen=True)
class ExportOptions:
    """The options of the command, with their defaults."""

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
    """A kind of output: description, its options, and its writer."""

    words: str
    options: tuple[str, ...]
    write: Callable[[Path, Path, ExportOptions], None]

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
    target.write(path, goal, options)


def _target(path: Path, output: Path | None, options: ExportOptions) -> _Target:
    """The output for these arguments: the first matching row."""
    from supple.cli.export_superelement import SUPERELEMENT_SUFFIXES
    from supple.export import TABLE_SUFFIXES

    is_case, suffix = path.suffix.lower() == ".toml", output and output.suffix.lower()
    of_result = () if is_case else ("case",)
    if options.superelement and suffix != ".inp":
        raise ArgumentError("--superelement is for a deck (.inp); other suffixes determine their format")
    deck = ("superelement", "body", "abaqus")
    rows = (
        (output is None, _Target("a machine as C", ("inputs", "allow_code", *of_result), _c)),
        (
            suffix == ".fmu",
            _Target("an FMU", ("inputs", "linear", "fmi", "platforms", "allow_code", *of_result), _fmu),
        ),
        (options.mode is not None, _Target("a mode", ("mode", "body", "time"), _mode)),
        (options.superelement, _Target("a deck with a superelement", deck, _superelement)),
        (suffix in SUPERELEMENT_SUFFIXES, _Target("a superelement", ("body",), _superelement)),
        (is_case, _Target("the deck of a case's body", ("body", "time", "abaqus"), _deck)),
        (suffix == ".vtu", _Target("a .vtu, which contains one time", (*_PICTURE, "time"), _result)),
        (suffix in TABLE_SUFFIXES, _Target("a table of the whole machine", ("times", "case"), _result)),
        (True, _Target("a file for ParaView", (*_PICTURE, "times"), _result)),
    )
    return next(target for applies, target in rows if applies)


_PICTURE = ("body", "stress", "case")


def _c(path: Path, folder: Path, options: ExportOptions) -> None:
    from supple.cli.export_machine import export_c

    export_c(path, folder, options.inputs or (), case_file=options.case, allow_code=options.allow_code)


def _fmu(path: Path, target: Path, options: ExportOptions) -> None:
    from supple.cli.export_machine import export_fmu

    export_fmu(
        path,
        target,
        options.inputs or (),
        fmi=options.fmi or 3,
        platforms=options.platforms or (),
        linear=options.linear,
        case_file=options.case,
        allow_code=options.allow_code,
    )


def _mode(path: Path, target: Path, options: ExportOptions) -> None:
    from supple.cli.export_mode import export_mode

    assert options.mode is not None
    export_mode(path, target, options.mode, bodies=options.body, time=options.time or 0.0)


def _superelement(path: Path, target: Path, options: ExportOptions) -> None:
    from supple.cli.export_superelement import export_superelement

    export_superelement(path, target, body=options.body, abaqus=options.abaqus)


def _deck(path: Path, target: Path, options: ExportOptions) -> None:
    from supple.cli.export_case import export_case
    from supple.export import TABLE_SUFFIXES

    if target.suffix.lower() in (".vtu", ".vtkhdf", *TABLE_SUFFIXES):
        raise ArgumentError(
            f"cannot write {target} from a case: tables and pictures of a run are written from its result "
            "(.h5). Run the case, then export the result"
        )
    export_case(path, target, body=options.body, time=options.time, abaqus=options.abaqus)


def _result(path: Path, target: Path, options: ExportOptions) -> None:
    from supple.cli.export_result import export_result

    export_result(
        path,
        target,
        bodies=options.body,
        time=options.time,
        times=options.times,
        stress=options.stress,
        case_file=options.case,
    )
