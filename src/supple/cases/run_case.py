"""Run of a case: simulation, result file, pictures and report."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from supple.blas_threads import one_blas_thread
from supple.cases.case import Case
from supple.cases.condense import with_sufficient_modes
from supple.cases.damping import warn_of_ratios
from supple.cases.drawing import ROUNDS_PICTURE, Drawing, check_drawing, drawing_of
from supple.cases.drawing_process import DrawingProcess
from supple.cases.implausible_units import warn_of_frequencies, warn_of_units
from supple.cases.notify import silent
from supple.cases.result_machine import CASE_FILE, path_from
from supple.cases.run_files import (
    check_outputs,
    page_path,
    readings_paths,
    refuse_overwrite,
    report_path,
    result_path,
    written_after_the_run,
)
from supple.cases.static_case import starting_system
from supple.equations import warn_of_missing_modes
from supple.error import Round, SelfCorrectionError, correct_recorded, correction_numbers, state_errors
from supple.errors import CaseError, SuppleWarning
from supple.integrate import Kinematic, Solution, StepProgress, Validity
from supple.machine import System
from supple.methods.intrinsic import IntrinsicBody
from supple.quantities import (
    Readings,
    TrackedMotion,
    control_sensors,
    read_sensors,
    tracked_places,
)
from supple.results import stress_numbers, summarize
from supple.simulation import reduced_bodies, simulate_and_store
from supple.simulation.engines import is_explicit
from supple.storage import write_errors, write_json
from supple.storage.exclusive_lock import ExclusiveLock
from supple.storage.file_errors import file_errors
from supple.storage.run_inputs import Inputs, changes

__all__ = ["CaseResult", "run_case"]


@dataclass(frozen=True, eq=False)
class CaseResult:
    """The results of the run of a case.

    system : machine with the bodies as simulated; self-correcting bodies have their last basis
    rounds : rounds of the self-correction, from `correction_numbers`; empty without self-correction
    tracked : motions of the tracked places, by their names in the case
    numbers : numbers of the run, from `summarize`
    """

    system: System
    solution: Solution
    rounds: Sequence[Mapping[str, Any]]
    tracked: Mapping[str, TrackedMotion]
    numbers: Mapping[str, Any]


def run_case(
    case: Case,
    folder: Path,
    *,
    resume: bool = False,
    force: bool = False,
    strict: bool = False,
    errors: bool = True,
    allow_code: bool = False,
    progress: StepProgress = silent,
) -> CaseResult:
    """Run a case; write its results (HDF5, JSON) and, unless switched off, its report and pictures.

    Parameters
    ----------
    folder : created if missing; no other process may write to it meanwhile
    resume : continue the result file of an interrupted run, instead of starting a new one
    force : replace existing results; otherwise finished or interrupted runs there are an error
    strict : warnings of start, steps and validity are errors
    errors : estimate the error of the run, with two extra runs unless the case sets otherwise. If false, an
        accuracy limits the error of the basis only. Errors of explicit runs are not estimated.
    allow_code : run the Python file of `control`, if the case has one

    Raises
    ------
    SelfCorrectionError     a target error that was not reached; the message names the file of the best round
    CaseError               `resume` and `force` at once; a file that changed while the case was read; a
                            controller without `allow_code`, or in a case that corrects itself
    ResultFileError         a result that would be lost; a result file that cannot be written or continued, or
                            whose case or input files have changed; another run that writes to the folder
    SuppleError             errors of the build and the simulation; the results until then are stored
    """
    if resume and force:
        raise CaseError("--resume continues a result and --force replaces it: give only one of them")
    check_outputs(case, folder)
    check_drawing(case)
    case.check_control(allow_code=allow_code)
    with file_errors("make the folder", folder):
        folder.mkdir(parents=True, exist_ok=True)
    with ExclusiveLock(folder), DrawingProcess() as beside, one_blas_thread():
        refuse_overwrite(case, folder, resume=resume, force=force)
        options = _Options(resume, force, strict, errors, allow_code, progress)
        return _run_case(case, folder, beside, options)


class _Options(NamedTuple):
    """The options of `run_case`."""

    resume: bool
    force: bool
    strict: bool
    errors: bool
    allow_code: bool
    progress: StepProgress


def _run_case(case: Case, folder: Path, beside: DrawingProcess, options: _Options) -> CaseResult:
    warn_of_units(case)
    _warn_of_unused_error(case)
    inputs = case.inputs
    # Errors of sensors are reported before the run, not after it.
    _ = case.system, case.sensors
    if changed := changes(inputs, case.inputs):
        raise CaseError(f"{case.path} was changed while it was read ({changed}): run it again")
    for body in reduced_bodies(case.system, case.flexible):
        warn_of_missing_modes(case.system, case.run.times, case.flexible[body.name], body, case.units)
    rounds: list[Round] = []
    if not options.resume:
        # If this run is interrupted, numbers of an earlier run must not lie beside its motion.
        for path in written_after_the_run(case, folder):
            with file_errors("replace", path):
                path.unlink(missing_ok=True)

    def known(system: System, solution: Solution) -> None:
        beside.begin(lambda: drawn(system, solution, _tracked(case, system, solution)))

    def drawn(system: System, solution: Solution, tracked: Mapping[str, TrackedMotion]) -> Drawing | None:
        return drawing_of(case, system, solution, tracked, folder, correction_numbers(rounds))

    try:
        system, solution = _simulated(case, folder, rounds, known, inputs, options)
    except SelfCorrectionError:
        _write_report(case, folder, correction_numbers(rounds), {})
        if rounds and case.tables.output.pictures:
            # Imported here: a run without pictures need not load the drawing library.
            from supple.viz import plot_rounds

            plot_rounds(folder / ROUNDS_PICTURE, correction_numbers(rounds), units=case.units)
        raise
    reduced = {body.name: body for body in reduced_bodies(system, case.made_here)}
    warn_of_frequencies(case.units, reduced.values())
    for table in case.parts.body:
        if table.name in reduced:
            warn_of_ratios(table.damping, reduced[table.name])
    tracked = _tracked(case, system, solution)
    named = {each.name for each in case.sensors}
    controls = [each for each in control_sensors(system, solution) if each.name not in named]
    readings = read_sensors([*case.sensors, *controls], system, solution)
    numbers = summarize(system, solution, tracked, fulls=case.fulls, units=case.units)
    stressed = {} if isinstance(case.run.method, Kinematic) else case.elements  # rigid bodies have no stress
    numbers |= {"stress": stress_numbers(system, solution, stressed, units=case.units)}
    numbers |= {"sensors": {each.name: each.plain(case.units) for each in readings}}
    result = CaseResult(system, solution, correction_numbers(rounds), tracked, numbers)
    _write_readings(case, folder, readings)
    _write_report(case, folder, result.rounds, result.numbers)
    if case.tables.output.report:
        _write_page(case, folder, result, readings, inputs, options.progress)
    beside.finish(drawn(system, solution, tracked), options.progress)
    return result


def _warn_of_unused_error(case: Case) -> None:
    """Issue SuppleWarning for keys of [error] in a case whose errors are not estimated."""
    explicit = any(body.is_explicit for body in case.tables.body)
    kind = "explicit" if explicit else "kinematic" if case.tables.simulation.kinematic else None
    if kind is not None and case.tables.error.model_fields_set:
        warnings.warn(
            f"[error] has no effect: the error of {kind} runs is not estimated; remove the table",
            SuppleWarning,
            stacklevel=2,
        )


def _warn_of_unknown_bases(system: System, solution: Solution) -> None:
    """Issue SuppleWarning of quantities whose error of the basis was requested and is not estimated."""
    unknown = [f"'{name}'" for name, each in solution.errors.items() if each.basis is None]
    if unknown:
        why = (
            "a machine with an intrinsic body has no error equation; repeat the run with more modes"
            if system.bodies_of(IntrinsicBody)
            else "the elements of some of its bodies are not known; compare with a model of more coordinates"
        )
        warnings.warn(
            f"[error] basis = true: the error of the basis of {', '.join(unknown)} is not estimated: {why}",
            SuppleWarning,
            stacklevel=2,
        )


def _tracked(case: Case, system: System, solution: Solution) -> dict[str, TrackedMotion]:
    """Motions of the tracked places of the case."""
    return tracked_places(system, solution, case.track, case.bases)


def _write_readings(case: Case, folder: Path, readings: Readings) -> None:
    """Write the readings of the sensors, and draw them unless pictures are off."""
    if not readings:
        return
    # Imported here: a run without sensors need not load the writers for other programs.
    from supple.export import write_readings

    for path in readings_paths(folder):
        write_readings(path, readings, units=case.units)
    if case.tables.output.pictures:
        from supple.viz import plot_readings

        plot_readings(folder / "sensors.png", readings, units=case.units)


def _write_page(
    case: Case, folder: Path, result: CaseResult, readings: Readings, inputs: Inputs, progress: StepProgress
) -> None:
    from supple.report import write_report

    progress("writing the report", 0.0)
    write_report(
        page_path(folder),
        result.system,
        result.solution,
        case.page_looks,
        title=case.title,
        tracked=result.tracked,
        readings=readings,
        elements=case.coloured_elements(result.system),
        bases=case.bases,
        numbers=result.numbers,
        rounds=result.rounds,
        inputs=case.texts(inputs),
        units=case.units,
    )
    progress("writing the report", 1.0)


def _simulated(
    case: Case,
    folder: Path,
    rounds: list[Round],
    known: Callable[[System, Solution], None],
    inputs: Inputs,
    options: _Options,
) -> tuple[System, Solution]:
    """The motion and its system; rounds of a self-correction are appended as they finish.

    known : called with system and motion before the error is estimated
    """
    units = {"units": str(case.units)} if str(case.units) else {}
    of_file: dict[str, Any] = {
        "case": case.text,
        "inputs": inputs,
        "metadata": {"title": case.title, CASE_FILE: path_from(folder, case.path), **units},
        "resume": options.resume,
        "overwrite": options.force,
    }
    machine = starting_system(case, allow_code=options.allow_code)
    condensed = {body.name: body.condense for body in case.tables.body if body.condense is not None}
    machine = with_sufficient_modes(machine, case.run, condensed, options.progress)
    given = (machine, replace(case.run, validity=Validity(strict=options.strict)))
    path = result_path(case.path, folder)
    if case.starts:
        corrected = correct_recorded(
            *given,
            case.starts,
            path,
            **of_file,
            announce=rounds.append,
            accepted=lambda corrected: known(corrected.system, corrected.solution),
            progress=options.progress,
            study=case.study if options.errors else None,
        )
        return corrected.system, corrected.solution

    def simulating(fraction: float) -> None:
        options.progress("compiling and simulating", fraction)

    simulating(0.0)
    system, solution = simulate_and_store(*given, path, case.made_here, **of_file, progress=simulating)
    if options.errors and not is_explicit(system, case.run):
        known(system, solution)
        solution = state_errors(
            system, case.run, solution, case.study, fulls=case.fulls, progress=options.progress
        )
        write_errors(path, solution)
        if solution.stopped is None and case.study.basis:
            _warn_of_unknown_bases(system, solution)
    return system, solution


def _write_report(
    case: Case, folder: Path, rounds: Sequence[Mapping[str, Any]], numbers: Mapping[str, Any]
) -> None:
    """Write the results of a run as JSON."""
    report = {"title": case.title, "self_correction": rounds, **numbers}
    write_json(report_path(case, folder), report)
