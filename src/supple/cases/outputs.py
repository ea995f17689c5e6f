"""Check of the files that a case writes: none of them is an input, and no two are the same."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from supple.cases.case import Case
from supple.cases.existing_results import readings_paths, report_path, result_path
from supple.cases.run_page import page_path
from supple.errors import CaseError
from supple.importers import files_read_with
from supple.simulation.stored_bodies import stored_path


def check_outputs(case: Case, folder: Path) -> None:
    """Raise CaseError if a run of the case in a folder would overwrite its inputs or one of its own files."""
    result = result_path(case.path, folder)
    kept = {stored_path(folder, name): name for name in case.made_here}
    if result in kept:
        raise CaseError(
            f"{case.path}: the result file and the file of body '{kept[result]}' would both be {result}; "
            "give the case file another name"
        )
    readings = readings_paths(folder) if case.tables.sensor else ()
    if result in readings:
        raise CaseError(
            f"{case.path}: the result file and the file of the sensors would both be {result}; give "
            "the case file another name"
        )
    check_not_an_input(case, [result, report_path(case, folder), page_path(folder), *kept, *readings])


def check_not_an_input(case: Case, targets: Sequence[Path]) -> None:
    """Raise CaseError if a file to be written is the case file, or one that it names or includes."""
    named = [case.folder / name for name in case.files]
    read = {path.resolve() for each in named for path in files_read_with(each)} | {case.path.resolve()}
    for target in targets:
        if target.resolve() in read:
            raise CaseError(
                f"cannot write {target}: it is an input of {case.path} and would be lost; write to another "
                "folder or file (-o)"
            )
