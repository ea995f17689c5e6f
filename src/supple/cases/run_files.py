"""The files of a run: their paths, and checks that none replaces an input or an earlier result unasked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from supple.cases.case import Case
from supple.error import ROUNDS_FOLDER, CorrectionFolder
from supple.errors import CaseError, ResultFileError
from supple.importers import files_read_with
from supple.simulation.stored_bodies import stored_path
from supple.storage import read_header, write_json
from supple.storage.file_errors import file_errors
from supple.storage.result_file import check_same_run


def result_path(case: Path, folder: Path) -> Path:
    """The result file of a case file in a folder."""
    return folder / f"{case.stem}.h5"


def report_path(case: Case, folder: Path) -> Path:
    """The JSON file of the results of a run."""
    return folder / f"{case.path.stem}.json"


def readings_paths(folder: Path) -> tuple[Path, Path]:
    """The files of the sensor readings of a run: a table, and HDF5."""
    return folder / "sensors.csv", folder / "sensors.h5"


def page_path(folder: Path) -> Path:
    """The file of the report of a run."""
    return folder / "report.html"


def written_after_the_run(case: Case, folder: Path) -> tuple[Path, ...]:
    """The files of numbers that the run of a case writes when it is complete."""
    readings = readings_paths(folder) if _has_readings(case) else ()
    page = (page_path(folder),) if case.tables.output.report else ()
    return report_path(case, folder), *readings, *page


def _has_readings(case: Case) -> bool:
    """Whether a run of the case reads sensors, or outputs of controllers."""
    return bool(case.tables.sensor or case.tables.control)


def check_outputs(case: Case, folder: Path) -> None:
    """Raise CaseError if a run of the case in a folder would overwrite its inputs or one of its own files."""
    result = result_path(case.path, folder)
    others = {stored_path(folder, name): f"body '{name}'" for name in case.made_here}
    others |= dict.fromkeys(readings_paths(folder) if _has_readings(case) else (), "the sensors")
    if result in others:
        raise CaseError(
            f"{case.path}: the result file and the file of {others[result]} would both be {result}; give "
            "the case file another name"
        )
    check_not_an_input(case, [result, report_path(case, folder), page_path(folder), *others])


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


def write_numbers(case: Case, folder: Path, what: str, numbers: Mapping[str, Any]) -> Path:
    """Write `CASE-WHAT.json`, into a folder that is created if missing; return its path."""
    with file_errors("make the folder", folder):
        folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{case.path.stem}-{what}.json"
    write_json(path, numbers)
    return path


def stored_so_far(case: Path, folder: Path) -> str:
    """Message on the stored results of an interrupted run."""
    path = result_path(case, folder)
    try:
        header = read_header(path)
    except ResultFileError:
        header = None
    if header is not None and header.complete:
        return f"the run is complete in {path}; reports and pictures may be missing"
    if CorrectionFolder(folder / ROUNDS_FOLDER, case="").is_begun:
        return f"the rounds so far are stored in {folder / ROUNDS_FOLDER}; --resume continues them"
    if header is not None and header.n_times:
        return f"the run so far is stored in {path}; --resume continues it"
    return "nothing was computed yet; run the case again"


def refuse_overwrite(case: Case, folder: Path, *, resume: bool, force: bool) -> None:
    """Check, before meshes are read and bodies are built, that this run may write to the folder.

    Raises
    ------
    ResultFileError     a result would be lost; with `resume`: no result to continue, or one of another case
    """
    if force:
        return
    path, rounds = result_path(case.path, folder), CorrectionFolder(folder / ROUNDS_FOLDER, case=case.text)
    if resume:
        _check_to_continue(case, path, rounds)
        return
    seen = _lost(path, rounds)
    if seen:
        raise ResultFileError(
            f"{folder} contains {seen}; --resume continues an interrupted run, --force replaces the "
            "results, -o FOLDER writes elsewhere"
        )


def _check_to_continue(case: Case, path: Path, rounds: CorrectionFolder) -> None:
    if path.exists():
        header = read_header(path)
        check_same_run(path, header, case.text, case.inputs)
        if header.complete:
            raise ResultFileError(
                f"cannot continue {path}: its run is complete; --force runs it again, -o FOLDER elsewhere"
            )
        there, here = str(header.metadata.get("units", "")), str(case.units)
        if there != here:
            raise ResultFileError(
                f"cannot continue {path}: its units are {there or 'not stated'}, and those of the case are "
                f"{here or 'not stated'} now; restore them, or run it again with --force"
            )
    elif not rounds.is_begun:
        raise ResultFileError(f"cannot continue {path}: there is no such file; run it without --resume")


def _lost(path: Path, rounds: CorrectionFolder) -> str:
    """Description of the results that a new run would replace; empty if there are none."""
    if path.exists():
        try:
            header = read_header(path)
        except ResultFileError as error:
            return f"a result that cannot be read ({error})"
        if header.complete:
            return f"the finished run {path.name}"
        if header.n_times:
            return f"the interrupted run {path.name}"
    if rounds.is_begun:
        return f"the rounds of an interrupted run ({rounds.folder.name}/)"
    return ""
