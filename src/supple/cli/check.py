"""The check of a model before it is used: a table of findings, each in order or with its remedy."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rich.table import Table

from supple.body import ModelCheck, Verdict, labelled_matrices_source, nastran_source
from supple.cases import read_case
from supple.errors import ImportFormatError, ModelError
from supple.importers import HDF5_SUFFIXES, NASTRAN_SUFFIXES
from supple.terminal import console, words

_VERDICTS = {
    Verdict.OK: "[green]OK[/green]",
    Verdict.DOUBTFUL: "[yellow]doubtful[/yellow]",
    Verdict.REFUSED: "[bold red]problem[/bold red]",
}


def print_check(path: Path, *, n_frequencies: int) -> None:
    """Print the check of every elastic body in the file at `path`.

    path : case file (.toml), Nastran bulk data (.bdf, .dat, .nas, .blk) or HDF5 file of matrices

    Raises
    ------
    ModelError   a model that is refused, after all are printed
    SuppleError  a file that cannot be read, or of another kind
    """
    refused = []
    for name, check in _checks(path, n_frequencies):
        console.print(check_table(name, check))
        if not check.is_accepted:
            refused.append(name)
    if refused:
        raise ModelError(f"{', '.join(refused)}: refused; see the lines marked 'problem'")


def check_table(name: str, check: ModelCheck) -> Table:
    """The findings of a check as a table."""
    table = Table("", "what", "seen", title=words(f"Check of {name}"))
    for finding in check.findings:
        seen = f"{finding.seen}\n-> {finding.remedy}" if finding.remedy else finding.seen
        table.add_row(_VERDICTS[finding.verdict], words(finding.what), words(seen))
    return table


def _checks(path: Path, n_frequencies: int) -> Iterator[tuple[str, ModelCheck]]:
    suffix = path.suffix.lower()
    if suffix in NASTRAN_SUFFIXES:
        yield str(path), nastran_source(path).check(n_frequencies)
    elif suffix in HDF5_SUFFIXES:
        yield str(path), labelled_matrices_source(nodes=path, stiffness=path, mass=path).check(n_frequencies)
    elif suffix == ".toml":
        for name, source in read_case(path).sources.items():
            yield f"body '{name}'", source.check(n_frequencies)
    else:
        complete = ", ".join((".toml", *NASTRAN_SUFFIXES, *HDF5_SUFFIXES))
        raise ImportFormatError(
            f"{path}: not a whole model; give a file that ends in {complete} (a mesh without materials, or "
            "matrices without nodes: write a case file that names both)"
        )
