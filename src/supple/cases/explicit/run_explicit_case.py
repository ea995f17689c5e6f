"""Run an explicit case: march it, keep it on disk as it goes on, draw it, and say what came out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from supple.cases.explicit.explicit_case import ExplicitCase
from supple.cases.notify import Progress, silent
from supple.cases.outputs import check_not_an_input
from supple.cases.remains import check_remains, report_path, result_path
from supple.errors import CaseError
from supple.explicit import ExplicitSystem, keep_explicit
from supple.integrate import Solution
from supple.machine import At
from supple.results.explicit_summary import mean_motion, summarize_explicit
from supple.storage import write_json
from supple.storage.exclusive_lock import ExclusiveLock
from supple.storage.file_errors import file_errors
from supple.storage.run_inputs import changes

__all__ = ["ExplicitResult", "run_explicit_case"]


@dataclass(frozen=True, eq=False)
class ExplicitResult:
    """What the run of an explicit case came to; numbers as `summarize_explicit` gives them."""

    system: ExplicitSystem
    solution: Solution
    numbers: Mapping[str, Any]


def run_explicit_case(
    case: ExplicitCase,
    folder: Path,
    *,
    resume: bool = False,
    force: bool = False,
    progress: Progress = silent,
) -> ExplicitResult:
    """Run an explicit case and write its results (HDF5, JSON) and, if wanted, its pictures into `folder`.

    Parameters
    ----------
    folder : made if it is not there; nobody else writes to it meanwhile
    resume : continue the result file of a run that was cut off, to the last bit as if it had not been
    force : replace the result that is there; otherwise one that is finished or was cut off is an error

    Raises
    ------
    CaseError           --resume and --force at once; a file that changed while the case was read
    ResultFileError     a result that would be lost; a file that cannot be written or continued, or whose case
                        or files have changed since
    SuppleError         whatever the build and the march find wrong; what was computed is kept
    """
    if resume and force:
        raise CaseError("--resume goes on with a result and --force replaces it: give one of them")
    path = result_path(case.path, folder)
    check_not_an_input(case, [path, report_path(case, folder)])
    with file_errors("make the folder", folder):
        folder.mkdir(parents=True, exist_ok=True)
    with ExclusiveLock(folder):
        check_remains(case, folder, resume=resume, force=force)
        return _run(case, folder, path, resume=resume, force=force, progress=progress)


def _run(
    case: ExplicitCase, folder: Path, path: Path, *, resume: bool, force: bool, progress: Progress
) -> ExplicitResult:
    inputs = case.inputs
    system = case.system
    if changed := changes(inputs, case.inputs):
        raise CaseError(f"{case.path} was changed while it was read ({changed}): run it again")
    if not resume:
        # Were this run stopped, the numbers of the one before would stand beside its motion.
        report_path(case, folder).unlink(missing_ok=True)

    def marching(fraction: float) -> None:
        progress("compiling and marching", fraction)

    marching(0.0)
    units = case.units
    solution = keep_explicit(
        system,
        case.run,
        path,
        options=case.options,
        case=case.text,
        inputs=inputs,
        metadata={"title": case.title} | ({"units": str(units)} if str(units) else {}),
        resume=resume,
        overwrite=force,
        progress=marching,
    )
    places = {place: At(*place.split(".", 1)) for place in case.tables.output.track}
    tracked = {name: mean_motion(system, solution, place) for name, place in places.items()}
    numbers = summarize_explicit(system, solution, tracked, units=units)
    write_json(report_path(case, folder), {"title": case.title, **numbers})
    _draw(case, ExplicitResult(system, solution, numbers), tracked, folder, progress)
    return ExplicitResult(system, solution, numbers)


def _draw(
    case: ExplicitCase,
    result: ExplicitResult,
    tracked: Mapping[str, Any],
    folder: Path,
    progress: Progress,
) -> None:
    output = case.tables.output
    if not (output.pictures or output.animation):
        return
    # Imported here: a run without pictures does not wait for the drawing library.
    from supple.viz.explicit_pictures import COLOURINGS, animate_explicit, draw_explicit

    if output.pictures:
        case.notify("drawing pictures")
        draw_explicit(folder, result.solution, tracked, units=case.units)
    for colour in output.colour if output.animation else ():
        animate_explicit(
            folder / f"{colour}.gif",
            result.system,
            result.solution,
            COLOURINGS[colour],
            units=case.units,
            progress=lambda share, colour=colour: progress(f"drawing the film in {colour}", share),
        )
