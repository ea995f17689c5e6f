"""The error of a finished reduced run caused by its bases, estimated by the error equation."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from supple.algebra.rotation import rotation_log
from supple.blas_threads import one_blas_thread
from supple.body import FullBody, ModalDamping
from supple.equations.configuration import Configuration
from supple.equations.consistent_start import consistent_start
from supple.error.basis_error import FIRST_ORDER, BasisError, BodyError
from supple.error.converged_error import (
    Differences,
    converged,
    deflection,
    deformed_rows,
    is_finite,
    is_large,
    is_small,
)
from supple.error.equation import (
    AssessedBody,
    ErrorEquation,
    ErrorHistory,
    MissedAtRest,
    ModesInFrame,
    StartError,
    error_space,
    modes_in_frame,
    run_columns,
    second_corrections,
)
from supple.error.leading_fields import leading_fields
from supple.error.missing_motion import FOLLOWED
from supple.error.residual_correction import (
    ResidualCorrections,
    active_constraints,
    system_corrections,
)
from supple.error.sample_times import followed, load_peaks, stratified_samples
from supple.error.stopping import locking_loss
from supple.errors import ModelError, RedundantConstraintWarning, StartWarning
from supple.integrate import FloatingMotion, FramedMotion, Progress, Run, Solution
from supple.machine import ForceElement, System
from supple.methods.floating.compiled.every_step import EveryStep, as_outputs, every_step
from supple.methods.floating.full.full_system import FullSystem
from supple.methods.intrinsic import IntrinsicBody
from supple.reduction import ReducedBody, ReductionBasis

__all__ = ["ErrorEstimate", "ErrorEstimator", "MissingMotionAlongRun", "estimate_error"]

INSTANTS = 24
FRESH = 7
"""Sample times out of every `INSTANTS` that are not used to build the error space. The corrections at these
times measure the part of the error outside that space."""
DIVERGED = 10.0
"""Ratio of error to deformation above which the error equation counts as diverged."""


@dataclass(frozen=True, eq=False)
class ErrorEstimate:
    """Error of a run caused by its bases, and the motion outside them.

    error : BasisError
    histories : ErrorHistory, by body       the error at every step of the run
    missed : (n, m), by body                displacement fields outside the basis, with their size in the run
    corrections : ResidualCorrections, by body      the quasi-static motion outside the basis
    corrected : the system reduced to the columns of the error, and the estimate of its true motion; the
                distance of this motion from the run is the error of any quantity of interest; None without
                an estimate
    factorizations : int    number of factorisations of the whole system or of a full body
    """

    error: BasisError
    histories: Mapping[str, ErrorHistory]
    missed: Mapping[str, np.ndarray]
    corrections: Mapping[str, ResidualCorrections]
    corrected: tuple[System, Solution] | None = None
    factorizations: int = 0


@dataclass(frozen=True, eq=False)
class MissingMotionAlongRun:
    """Motion outside the bases of a run at some times, from equilibria of the full bodies.

    steps : the run at every step, or at its output times if it stopped early
    corrections : by body, first at the times used to build the error space, then at further times
    n_looked : number of the times used to build the error space
    along : indices of the sample times and of the intermediate times between them, among the steps
    """

    steps: EveryStep
    corrections: Mapping[str, ResidualCorrections]
    n_looked: int
    along: np.ndarray

    @property
    def fields(self) -> dict[str, np.ndarray]:
        """Displacement fields (n, m) outside the basis, by body."""
        return {name: own.deformation for name, own in self.corrections.items()}


def estimate_error(
    system: System,
    reduced: System,
    bases: Mapping[str, ReductionBasis],
    run: Run,
    solution: Solution,
    *,
    progress: Progress | None = None,
) -> BasisError:
    """Error of a reduced run caused by its bases, estimated without a full-order run.

    To first order the error obeys the full equations of the system, linearised about the run and driven by
    the run's own residual. These equations are solved in about a hundred coordinates per body
    (`ErrorEquation`), with the run's own integrator and steps. Where the error is not small, they are solved
    again about the corrected motion.

    Parameters
    ----------
    system : System         with the bodies to assess as FullBody
    reduced : System        as simulated, with these bodies reduced
    bases : ReductionBasis  by body
    run, solution : settings and result of the run of the reduced system
    progress : function     called with the completed fraction of the work

    Returns
    -------
    BasisError      by body; infinite if the run stopped early or the solution of the equation diverges

    Raises
    ------
    ModelError      bodies that are not full in `system`, or not reduced in `reduced`; a machine with
                    controllers or intrinsic bodies
    AccuracyError   no equilibrium was found and a tangent is singular, as for `system_corrections`
    """
    return ErrorEstimator(system, run).assess(reduced, bases, solution, progress=progress).error


class ErrorEstimator:
    """Estimates the errors of runs of one system; the modes of its full bodies are computed once.

    system : System     with the bodies to assess as FullBody
    run : Run           settings of all these runs

    Raises ModelError for a machine with controllers or intrinsic bodies.
    """

    def __init__(self, system: System, run: Run) -> None:
        check_linearised(system)
        self._system = system
        self._run = run
        self._modes: dict[str, ModesInFrame] = {}
        self._full_start: tuple[FullSystem, Configuration, np.ndarray] | None = None

    def assess(
        self,
        reduced: System,
        bases: Mapping[str, ReductionBasis],
        solution: Solution,
        *,
        instants: int = INSTANTS,
        largest_missing: Mapping[str, float] | None = None,
        progress: Progress | None = None,
    ) -> ErrorEstimate:
        """Error of one run caused by its bases; parameters as for `estimate_error`.

        instants : number of times at which the residual is balanced, in addition to load peaks and kinks
        largest_missing : RMS of the nodes, by body; if the motion outside a basis exceeds this limit, the
            error is not estimated, and is infinite
        """
        missing = self.missing_motion(reduced, bases, solution, instants=instants, progress=progress)
        exceeded = any(
            limit < float(missing.corrections[name].rms.max()) < np.inf
            for name, limit in (largest_missing or {}).items()
        )
        if solution.stopped is not None or exceeded:
            if progress is not None:
                progress(1.0)
            return self._unknown(missing, solution)
        return self.error_of(missing, reduced, bases, solution, progress=progress)

    def modes(self, name: str) -> ModesInFrame:
        """The lowest modes of a body in its frame, computed once."""
        if name not in self._modes:
            full = self._system.bodies_of(FullBody)[name]
            self._modes[name] = modes_in_frame(full.body, full.frame)
        return self._modes[name]

    @one_blas_thread()
    def missing_motion(
        self,
        reduced: System,
        bases: Mapping[str, ReductionBasis],
        solution: Solution,
        *,
        instants: int = INSTANTS,
        progress: Progress | None = None,
    ) -> MissingMotionAlongRun:
        """Motion outside the bases at sample times, from equilibria; the run may have stopped early."""
        fulls = self._to_assess(bases)
        steps = every_step(reduced, self._run, solution) if solution.stopped is None else as_outputs(solution)
        looked, fresh = self._instants(steps.solution.times, instants)
        both, places = np.unique(np.concatenate([looked, fresh]), return_inverse=True)
        along = followed(both)
        at_each = system_corrections(
            reduced,
            tuple(fulls.values()),
            bases,
            steps.solution,
            both,
            between=None if all(full.is_linear for full in fulls.values()) else along,
            progress=None if progress is None else lambda fraction: progress(0.5 * fraction),
        )
        missed = {name: own.at(places) for name, own in at_each.items()}
        return MissingMotionAlongRun(steps, missed, len(looked), along)

    @one_blas_thread()
    def error_of(
        self,
        missing: MissingMotionAlongRun,
        reduced: System,
        bases: Mapping[str, ReductionBasis],
        solution: Solution,
        *,
        progress: Progress | None = None,
    ) -> ErrorEstimate:
        """Error of a run that reached its end, from its `missing_motion`; other arguments as for `assess`."""
        fulls, steps, missed = self._to_assess(bases), missing.steps, missing.corrections
        fields, n_looked = missing.fields, missing.n_looked
        start = self.start_errors(steps.solution, bases)
        assessed = {
            name: self._assessed_body(
                name, full, reduced, bases[name], steps.solution, missed[name], n_looked, start
            )
            for name, full in fulls.items()
        }
        equation = ErrorEquation(
            reduced,
            assessed,
            self._run.second_order_method.coefficients,
            steps.solution,
            active_constraints(reduced, solution),
            start,
        )

        def missed_along() -> dict[str, ResidualCorrections]:
            return system_corrections(
                reduced, tuple(fulls.values()), bases, steps.solution, missing.along, tolerance=FOLLOWED
            )

        simulated = {name: reduced_form(reduced, name) for name in fulls}
        differences = _differences(equation, missed_along, simulated, is_smooth(reduced))
        if differences is None:
            return self._unknown(missing, solution)
        found, histories, second = differences
        if progress is not None:
            progress(1.0)
        errors = {
            name: body_error(
                history,
                second[name],
                steps.outputs,
                fields[name][:, n_looked:],
                indicator=float(missed[name].rms.max()),
                locking_loss=locking_loss(simulated[name]),
            )
            for name, history in histories.items()
        }
        added = {name: _missing(history, second[name], fields[name]) for name, history in histories.items()}
        corrected = equation.corrected(found, steps.outputs)
        # Factorisations: those of the corrections, and per body one for the modes and one for the couplings.
        factorizations = max(own.factorizations for own in missed.values()) + 2 * len(fulls)
        return ErrorEstimate(BasisError(errors), histories, added, missed, corrected, factorizations)

    def _unknown(self, missing: MissingMotionAlongRun, solution: Solution) -> ErrorEstimate:
        errors = BasisError(dict.fromkeys(missing.corrections, unknown_error(solution)))
        return ErrorEstimate(errors, {}, missing.fields, missing.corrections)

    def _to_assess(self, bases: Mapping[str, ReductionBasis]) -> dict[str, FullBody]:
        fulls = self._system.bodies_of(FullBody)
        for name in bases:
            if name not in fulls:
                raise ModelError(
                    f"error estimate: the system has no full body '{name}': give it as a FullBody"
                )
        return {name: fulls[name] for name in bases}

    def _instants(self, times: np.ndarray, instants: int) -> tuple[np.ndarray, np.ndarray]:
        fresh = max(1, FRESH * instants // INSTANTS)
        looked = stratified_samples(len(times), max(1, instants - fresh), seed=0)
        looked = np.union1d(looked, load_peaks(self._system, times))
        return looked, stratified_samples(len(times), fresh, seed=1)

    def _assessed_body(
        self,
        name: str,
        full: FullBody,
        reduced: System,
        basis: ReductionBasis,
        steps: Solution,
        missed: ResidualCorrections,
        n_looked: int,
        start: Mapping[str, StartError],
    ) -> AssessedBody:
        body = reduced_form(reduced, name)
        motion = run_columns(full.body, body, basis, steps.motion(name, FloatingMotion))
        corrections = missed.deformation[:, :n_looked]
        if name in start:
            at_start = np.column_stack([start[name].position[6:], start[name].velocity[6:]])
            corrections = np.hstack([corrections, at_start])
        deformed = motion.vectors @ motion.coordinates[deformed_rows(len(steps.times))[1:]].T
        space = error_space(self.modes(name), motion.vectors, corrections, deformed)
        return AssessedBody(full, motion, space, full.damping or modal_damping(body))

    def start_errors(self, steps: Solution, bases: Mapping[str, ReductionBasis]) -> dict[str, StartError]:
        """True start state less that of the run, by body; empty if all start as placed and undeformed."""
        placed = {each.body.name: each for each in self._system.bodies}
        as_given = all(
            np.array_equal(np.asarray(given), motion[0])
            for name, each in placed.items()
            for own in (steps.motion(name, FramedMotion),)
            for given, motion in (
                (each.position, own.position),
                (each.rotation, own.rotation),
                (each.twist[:3], own.velocity),
                (each.twist[3:], own.angular_velocity),
            )
        )
        if as_given and not any(
            np.any(each.coordinates) or np.any(each.coordinate_rates) for each in placed.values()
        ):
            return {}
        if self._full_start is None:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RedundantConstraintWarning)
                warnings.simplefilter("ignore", StartWarning)
                self._full_start = consistent_start(FullSystem(self._system), float(steps.times[0]))[:3]
        machine, configuration, velocity = self._full_start
        return {
            name: _start_error(machine, index, name, configuration, velocity, steps, bases)
            for index, name in enumerate(placed)
        }


def reduced_form(system: System, name: str) -> ReducedBody:
    """The reduced form of a body; raises ModelError if the body is not reduced in this system."""
    body, reduced = system.placed(name, "error estimate").body, system.bodies_of(ReducedBody)
    if name not in reduced:
        raise ModelError(
            f"error estimate: body '{name}' is a {type(body).__name__}: name reduced bodies only"
        )
    return reduced[name]


def check_linearised(system: System) -> None:
    """Raise ModelError for a machine with intrinsic bodies or controllers, which are not linearised here."""
    if system.controllers:
        raise ModelError(
            "error estimate: not available for a machine with controllers: give the bodies "
            "reductions of fixed size and compare with richer ones, or leave the controllers out, "
            "replace(system, controllers=())"
        )
    if intrinsic := system.bodies_of(IntrinsicBody):
        raise ModelError(
            f"error estimate: not available for a machine with intrinsic bodies ('{next(iter(intrinsic))}'): "
            "give the other bodies reductions of fixed size, and compare with "
            "richer ones"
        )


def is_smooth(system: System) -> bool:
    """Whether a machine has no force elements, hence no contacts, friction or limits.

    With force elements the first order is not enough: even a small error may exceed a contact depth or the
    distance to a limit.
    """
    return not any(isinstance(load, ForceElement) for load in system.loads)


def modal_damping(body: ReducedBody) -> ModalDamping | None:
    """Damping for a full body without damping: modal ratios of its reduced body; None if undamped.

    Modes of the full body above those of the reduced body have the last ratio.
    """
    if not body.damping.any():
        return None
    squares, modes = np.linalg.eigh(body.stiffness)
    return ModalDamping(np.sum(modes * (body.damping @ modes), axis=0) / (2 * np.sqrt(squares)))


def _start_error(
    machine: FullSystem,
    index: int,
    name: str,
    configuration: Configuration,
    velocity: np.ndarray,
    steps: Solution,
    bases: Mapping[str, ReductionBasis],
) -> StartError:
    own, part = steps.motion(name, FloatingMotion), machine.slices[index]
    gamma, rates = own.coordinates[0], own.coordinate_rates[0]
    if name in bases:
        gamma, rates = bases[name].vectors @ gamma, bases[name].vectors @ rates
    turn = np.asarray(rotation_log(own.rotation[0].T @ configuration.rotations[index]))
    position = np.concatenate(
        [
            configuration.origins[index] - own.position[0],
            turn,
            configuration.coordinates[machine.coordinate_slices[index]] - gamma,
        ]
    )
    moving = velocity[part] - np.concatenate([own.velocity[0], own.angular_velocity[0], rates])
    return StartError(position, moving)


def _differences(
    equation: ErrorEquation,
    missed_along: Callable[[], Mapping[str, ResidualCorrections]],
    simulated: Mapping[str, ReducedBody],
    smooth: bool,
) -> Differences | None:
    """True motion less the run's, the errors by body, and their last relative change by body.

    None if the error exceeds `DIVERGED` times the deformation: not even its order of magnitude is known then.
    missed_along : function that returns the quasi-static motion outside the bases at many times
    simulated : the assessed bodies as simulated
    smooth : bool   whether small elastic second corrections suffice as proof that an error is small
    """
    found = equation.first()
    histories = equation.histories(found)
    first: Differences = found, histories, dict.fromkeys(histories, np.inf)
    bounded = _are_bounded(histories)
    if bounded:
        second = second_corrections(equation, histories)
        known = smooth and is_small(histories, second, simulated)
        first = (found, histories, second) if known else converged(equation, found, histories, smooth=smooth)
    nonlinear = not all(history.body.full.is_linear for history in histories.values())
    if nonlinear and max(first[2].values()) > FIRST_ORDER:
        # Tangents at the state of the run can be unstable: if walls of a body buckle, but not in the run, all
        # differences grow. At the state of the run plus the motion outside its bases, tangents are stable.
        tangents = equation.with_missed({name: _known(own) for name, own in missed_along().items()})
        about = equation.first(tangents)
        other = converged(equation, about, equation.histories(about), tangents, smooth=smooth)
        if max(other[2].values()) <= FIRST_ORDER:
            return other
    return first if bounded else None


def _are_bounded(histories: Mapping[str, ErrorHistory]) -> bool:
    return is_finite(histories) and all(
        float(history.rms.max()) <= DIVERGED * deflection(history) for history in histories.values()
    )


def _known(missed: ResidualCorrections) -> MissedAtRest:
    """Motion outside the basis at the times where an equilibrium was found."""
    known = np.isfinite(missed.rms)
    return MissedAtRest(missed.times[known], missed.deformation[:, known])


def body_error(
    history: ErrorHistory,
    second: float,
    outputs: np.ndarray,
    fresh: np.ndarray,
    *,
    indicator: float = 0.0,
    locking_loss: float = 0.0,
) -> BodyError:
    """`BodyError` of a body from the history of its error.

    second : ratio of the second correction to the first
    outputs : indices of the output times among the steps
    fresh : (n, m)          corrections that were not used to build the error space
    indicator, locking_loss :   as in `BodyError`
    """
    rms = history.rms[outputs]
    row = int(outputs[np.argmax(rms)])
    sizes = np.linalg.norm(history.at_nodes(row), axis=1)
    return BodyError(
        rms=float(rms.max()),
        worst=float(sizes.max()),
        worst_node=int(np.argmax(sizes)),
        worst_time=float(history.times[row]),
        rest=_rest(history, fresh),
        # If an equilibrium is missing, the columns of the error may lock; a large error is then not known.
        second=np.inf if is_large(history) and not np.isfinite(indicator) else second,
        history=rms,
        indicator=indicator,
        locking_loss=locking_loss,
    )


def unknown_error(solution: Solution) -> BodyError:
    """The error of a run that stopped early, or whose error equation diverges: infinite."""
    times = solution.times
    return BodyError(np.inf, np.inf, 0, float(times[-1]), np.inf, None, np.full(len(times), np.inf))


def _rest(history: ErrorHistory, fresh: np.ndarray) -> float:
    """Largest RMS over the nodes of the part of `fresh` corrections outside the error space."""
    full, Z = history.body.full, history.body.space.vectors
    outside = fresh - Z @ (Z.T @ (full.body.mass @ fresh))
    moved = full.expand(outside.T)
    return float(np.sqrt(np.mean(np.sum(moved**2, axis=2), axis=1)).max(initial=0.0))


def _missing(history: ErrorHistory, second: float, corrections: np.ndarray) -> np.ndarray:
    """Fields (n, m) for new columns: the corrections, and the leading directions of a converged error.

    If the second correction to the error is large, the march may have diverged; the error then has the shapes
    of the instability. For a blade with buckling walls, these shapes would replace the corrections.
    """
    if second > FIRST_ORDER and not history.body.full.is_linear:
        return corrections
    leading = leading_fields(history.deformation, history.coordinates, corrections.shape[1])
    return np.hstack([leading, corrections])
