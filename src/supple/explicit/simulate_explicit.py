"""An explicit run, in memory or kept in a result file as it goes on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from supple.arguments import checked_arguments
from supple.errors import ResultFileError
from supple.explicit.engine import ExplicitEngine, ExplicitOptions
from supple.explicit.explicit_system import ExplicitSystem
from supple.explicit.modal_limits import ModalPeaks, ModalWatch, modal_watch
from supple.explicit.run_inputs import check_modes, inputs_of, modes_of
from supple.integrate import Progress, Recorder, Run, Solution
from supple.integrate import run as march_through
from supple.storage import ResultFile, read_header, read_solution
from supple.storage.result_content import Metadata
from supple.storage.run_inputs import Inputs, changes

__all__ = ["keep_explicit", "simulate_explicit"]


@checked_arguments
def simulate_explicit(
    system: ExplicitSystem,
    run: Run,
    *,
    options: ExplicitOptions | None = None,
    file: Path | str | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
    check: bool = True,
) -> Solution:
    """Motion of an explicit system from its initial state over a run.

    Parameters
    ----------
    system : ExplicitSystem
    run : Run               its span and output times, the step of the explicit nodes if it is fixed, and its
                            validity; another method and tolerances are refused, the march has its own
    options : ExplicitOptions
    file : path             keep the motion in this result file as it is computed; a finished run is read, one
                            that was cut off goes on, to the last bit as if it had not been
    overwrite : bool        begin anew, whatever the file holds
    progress, check : as for `simulate`

    Returns
    -------
    Solution    a `NodalMotion` or `FourPointMotion` per sub-domain; under `ENERGIES` the energy balance in
                the order of `Energies`, under `STEPS` the step and the ratio, under `OBSTACLES` how far each
                has moved and its velocity

    Raises
    ------
    ModelError          ties that do not meet, nodes that begin inside an obstacle, a step above the limit
    ConvergenceError    an element that turned over, an energy balance open by 1 %: what was computed is kept
    ValidityError       what is warned of, under `Validity(strict=True)`
    ResultFileError     the file holds another run, or cannot be read or written

    Warns
    -----
    ValidityWarning     a modal part stressed beyond the yield stress, turned by more than 0.1 rad against its
                        frame, or spinning too fast for modes at rest, at an output time
    """
    engine = ExplicitEngine(system, run, options)
    watched = _Watched(engine, run, modal_watch(system, run.validity))
    if file is None:
        return watched.march(progress=progress, check=check)
    path, case = Path(file), _case(system, run)
    inputs = inputs_of(system, run, options or ExplicitOptions())
    begun = False
    if path.exists() and not overwrite:
        header = read_header(path)
        if changed := changes(header.inputs, inputs):
            raise ResultFileError(
                f"{path} holds another run than the one asked for ({changed}); say overwrite=True to replace "
                f"it, or choose another file. There: {header.case}. Here: {case}"
            )
        check_modes(header, system, path)
        if header.complete:
            return read_solution(path)
        begun = bool(header.n_times)
    names = _Names(case, inputs, modes_of(system))
    return _kept(watched, path, names, begun, overwrite, progress, check)


def keep_explicit(
    system: ExplicitSystem,
    run: Run,
    path: Path,
    *,
    options: ExplicitOptions | None = None,
    case: str,
    inputs: Inputs,
    metadata: Metadata = MappingProxyType({}),
    resume: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> Solution:
    """A run in a result file that is told what it depends on: begun, or continued where it was cut off.

    Parameters
    ----------
    system, run, options, progress : as for `simulate_explicit`
    case, inputs, metadata : kept in the file; a file of other inputs is not continued
    resume : continue the run that was cut off
    overwrite : replace what is there; otherwise only a run without any output is replaced

    Raises
    ------
    ResultFileError     a file that cannot be written, or not be continued
    errors of `simulate_explicit`; what was computed until then is kept in the file
    """
    engine = ExplicitEngine(system, run, options)
    begun = resume and bool(read_header(path).n_times)
    if begun:
        check_modes(read_header(path), system, path)
    names = _Names(case, inputs, {**metadata, **modes_of(system)})
    watched = _Watched(engine, run, modal_watch(system, run.validity))
    return _kept(watched, path, names, begun, overwrite, progress, True)


class _Names(NamedTuple):
    """What a result file says of its run."""

    case: str
    inputs: Inputs
    metadata: Metadata


class _Watched(NamedTuple):
    """An engine and its run, with the limits of modal parts."""

    engine: ExplicitEngine
    run: Run
    limits: ModalWatch

    def march(
        self,
        *,
        resume: Solution | None = None,
        record: Recorder | None = None,
        progress: Progress | None = None,
        check: bool = True,
    ) -> Solution:
        """Through the run, each leg held against the limits once it is recorded."""
        peaks: dict[str, ModalPeaks] = {}

        def observed(leg: Solution) -> None:
            if record is not None:
                record(leg)
            peaks.update(self.limits.observe(peaks, leg))

        done = march_through(
            self.engine, self.run.times, resume=resume, record=observed, progress=progress, check=check
        )
        self.limits.report(peaks)
        return done


def _kept(
    watched: _Watched,
    path: Path,
    names: _Names,
    begun: bool,
    overwrite: bool,
    progress: Progress | None,
    check: bool,
) -> Solution:
    """The run in its file, from its start or from the last instant that is there."""
    if begun:
        with ResultFile.resume(path, case=names.case, inputs=names.inputs) as kept:
            return _recorded(watched, kept, kept.last_instant(), progress, check)
    with ResultFile.create(
        path, case=names.case, inputs=names.inputs, metadata=names.metadata, overwrite=overwrite
    ) as kept:
        return _recorded(watched, kept, None, progress, check)


def _recorded(
    watched: _Watched,
    kept: ResultFile,
    start: Solution | None,
    progress: Progress | None,
    check: bool,
) -> Solution:
    run, stopped = watched.run, None
    if start is None or start.times[-1] < run.times[-1] - 1e-6 * run.output_step:
        done = watched.march(resume=start, record=kept.append, progress=progress, check=check)
        stopped = done.stopped
    whole = kept.solution()
    if stopped is None:
        kept.finish()
    return replace(whole, stopped=stopped)


def _case(system: ExplicitSystem, run: Run) -> str:
    parts = ", ".join(f"{part.name} ({type(part.subdomain).__name__})" for part in system.placed)
    return f"explicit: {parts}; {run.duration:g} from {run.start:g}, every {run.output_step:g}"
