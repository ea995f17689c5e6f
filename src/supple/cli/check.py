"""The check of a model: a table of findings, with remedies."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rich.table import Table

from supple.body import MatrixFiles, ModelCheck, Verdict, deck_source, labelled_matrices_source
from supple.body.model_check import LOWEST_FREQUENCIES
from supple.cases import Case, read_case
from supple.cases.notify import silent
from supple.cli.info import is_only_a_mesh
from supple.errors import ImportFormatError, ModelError
from supple.importers import DECK_SUFFIXES, HDF5_SUFFIXES, is_section_file, read_deck
from supple.terminal import LOGGER, PrintedMessage, say, words
from supple.units import UNNAMED, UnitSystem, with_unit

_VERDICTS = {
    Verdict.OK: "[green]OK[/green]",
    Verdict.DOUBTFUL: "[yellow]doubtful[/yellow]",
    Verdict.REFUSED: "[bold red]problem[/bold red]",
}


def print_check(path: Path, *, n_frequencies: int) -> None:
    """Print the check of every elastic body in the file at `path`.

    path : case file (.toml), deck (.bdf, .dat, .nas, .blk, .inp) or HDF5 file of matrices
    n_frequencies : number of elastic modes to compute for each body

    Raises
    ------
    ModelError   a model that is refused, after the findings of all bodies are printed; before them, a body
                 from a section table or condensed matrices that cannot be built
    SuppleError  a file that cannot be read, or of another kind
    """
    refused = []
    for name, check, units in _checks(path, n_frequencies):
        LOGGER.info(PrintedMessage(check_table(name, check, units)))
        if not check.is_accepted:
            refused.append(name)
    if refused:
        raise ModelError(f"{', '.join(refused)}: refused; see the lines marked 'problem'")


def check_table(name: str, check: ModelCheck, units: UnitSystem = UNNAMED) -> Table:
    """The findings of a check as a table, frequencies in Hz if the unit of time is known."""
    hertz, factor = units.frequency_shown
    table = Table("", "what", "seen", title=words(f"Check of {name}"))
    for finding in check.findings:
        seen = f"{finding.seen}\n-> {finding.remedy}" if finding.remedy else finding.seen
        if finding.what == LOWEST_FREQUENCIES:
            listed = ", ".join(f"{factor * frequency:.4g}" for frequency in check.frequencies)
            seen = with_unit(listed, hertz)
        table.add_row(_VERDICTS[finding.verdict], words(finding.what), words(seen))
    return table


def _print_lines(case: Case) -> None:
    """Print one line for each body from a section table or condensed matrices.

    Raises ModelError for a body that cannot be built.
    """
    hertz, factor = case.units.frequency_shown
    for table in case.tables.body:
        if not table.is_line:
            continue
        body = table.line(case.folder, silent)
        held, lowest = body.stated_frequencies()
        listed = ", ".join(f"{factor * frequency:.4g}" for frequency in lowest)
        say(
            f"body '{body.name}': condensed on {body.line.n} stations, mass {body.mass:.5g}; rigid-body "
            f"residual {body.line.rigid_force:.0e}; lowest frequencies {held} "
            f"{with_unit(listed, hertz)}"
        )


def _checks(path: Path, n_frequencies: int) -> Iterator[tuple[str, ModelCheck, UnitSystem]]:
    suffix = path.suffix.lower()
    if is_section_file(path):
        raise ImportFormatError(
            f"{path}: a section table is not a complete model; write a case: supple new {path}"
        )
    if suffix in DECK_SUFFIXES:
        try:
            source = deck_source(path)
        except ModelError:
            if is_only_a_mesh(read_deck(path)):
                raise ImportFormatError(
                    f"{path}: a mesh without sections is not a complete model; write a case with its "
                    f"material: supple new {path}"
                ) from None
            raise
        yield str(path), source.check(n_frequencies), UNNAMED
    elif suffix in HDF5_SUFFIXES:
        source = labelled_matrices_source(MatrixFiles(path, path, path))
        yield str(path), source.check(n_frequencies), UNNAMED
    elif suffix == ".toml":
        case = read_case(path)
        _print_lines(case)
        for name, source in case.sources.items():
            yield f"body '{name}'", source.check(n_frequencies), case.units
        without = [
            f"'{body.name}'" for body in case.parts.body if not body.is_line and body.name not in case.sources
        ]
        if without:
            say(
                f"not checked, because they have no elements or matrices here: {', '.join(without)} "
                "(rigid bodies, and bodies read from files of reduced bodies)"
            )
    else:
        complete = ", ".join((".toml", *DECK_SUFFIXES, *HDF5_SUFFIXES))
        raise ImportFormatError(
            f"{path}: not a complete model: check reads {complete}; for a mesh or a machine write a case: "
            f"supple new {path}"
        )
