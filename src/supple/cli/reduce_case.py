"""Reduce the bodies of a case file and keep them, to be used again without their meshes."""

from __future__ import annotations

from pathlib import Path

from rich.table import Table

from supple.cases import read_case
from supple.cli.console import console, worded
from supple.cli.summary_tables import body_table
from supple.errors import CaseError
from supple.reduction import ReducedBody
from supple.results import body_numbers
from supple.simulation import keep_body, reduced_bodies


def reduce_case(path: Path, folder: Path) -> None:
    """Make every reduction of fixed size in the case file at `path`, and keep it: `folder`/NAME-reduced.h5.

    Raises
    ------
    CaseError           mistakes in the case file; no body to reduce
    ResultFileError     a file that cannot be written
    SuppleError         whatever building and reducing find wrong
    """
    with console.status("reducing") as status:
        case = read_case(path, lambda step, detail="": status.update(worded(step, detail)))
        bodies = reduced_bodies(case.system, case.made_here)
    if not bodies:
        raise CaseError(
            f"{path} has no body to reduce: give an elastic body a reduction of fixed size, for example "
            'reduction = { basis = "error-controlled", tolerance = 1e-3, modes = 10 }; one that corrects '
            "itself is written by supple run"
        )
    console.print(body_table({"bodies": {body.name: body_numbers(body) for body in bodies}}))
    for body in bodies:
        console.print(_report_table(body))
        written = keep_body(body, folder)
        console.print(f"written to {written} ({written.stat().st_size / 2**20:.1f} MiB)", highlight=False)


def _report_table(body: ReducedBody) -> Table:
    """What the basis is made of, what was left out, and what it cost."""
    report = body.report
    table = Table(title=f"Reduction of {body.name}", show_header=False)
    for what in ("linear", "derivatives", "corrections", "dropped"):
        labels = getattr(report, what)
        if labels:
            table.add_row(what, f"{len(labels)}: {', '.join(labels)}")
    if report.singular_values_dropped.size:
        table.add_row("largest singular value dropped", f"{report.singular_values_dropped.max():.2g}")
    if report.certificate is not None:
        table.add_row("eigenvalues", str(report.certificate))
    table.add_row("seconds", ", ".join(f"{step} {time:.2f}" for step, time in report.seconds.items()))
    return table
