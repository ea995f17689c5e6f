"""A basis of given eigenvalue accuracy, whose number of fixed-interface modes is determined automatically."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter
from typing import NamedTuple

import numpy as np

from supple.algebra.eigen import LARGEST_WITH_TWO_FACTORS
from supple.arguments import check_fields
from supple.body import FlexibleBody, Frame
from supple.errors import AccuracyError, ModelError
from supple.reduction.bases.craig_bampton_family import CraigBamptonFamily
from supple.reduction.bases.linear_basis import LinearBasis
from supple.reduction.eigenvalues.eigenvalue_certificate import EigenvalueCertificate
from supple.reduction.eigenvalues.eigenvalue_enclosure import EigenvalueEnclosure, enclose_eigenvalues
from supple.reduction.eigenvalues.eigenvalue_error import (
    EigenvalueErrorEstimator,
    KnownEigenvalues,
    SharperBound,
)
from supple.reduction.eigenvalues.mode_search import Bisection, ModeSearch, SearchStep
from supple.reduction.reduction_report import timed

__all__ = ["ErrorControlled", "ErrorControlledModes", "error_controlled_modes"]

SMALLEST_TOLERANCE = 1e-7
"""Smallest allowed tolerance; rounding errors in the eigenvalues of large bodies can be almost as large."""


@dataclass(frozen=True)
class ErrorControlled:
    """A basis of the n_modes lowest elastic vibrations of the free body, with eigenvalues of given accuracy.

        0 <= chi-bar_n / chi_n - 1 <= tolerance,     n = 1 .. n_modes,  none missed

    chi-bar_n and chi_n are eigenvalues of the reduced and of the full body. First, fixed-interface modes are
    added to a Craig-Bampton basis until the estimated error of every eigenvalue is within the tolerance.
    Then, bounds for the eigenvalues of the full body are computed. If they do not prove the accuracy, more
    modes are added. The columns of the basis are the n_modes lowest vibrations of this Craig-Bampton body,
    with M = I and K = diag(chi-bar), so their number does not depend on the tolerance.

    tolerance : largest relative error of an eigenvalue (squared frequency), such as 1e-3 for 0.1 %
    n_modes : number of elastic modes, besides the six rigid motions, which are exact
    start : number of fixed-interface modes to try first
    most : largest allowed number of fixed-interface modes; None: all of the body
    estimator : of the errors: SharperBound(), TwoTermEstimate(), Han2020Bound() or FirstOrderEstimate()
    search : for the number of modes: Bisection() or OneByOne()
    progress : function that is called with each SearchStep; None: no calls
    Raises ModelError if a number is out of range.
    Source: [Han2020] section 4 and (46)-(49); the sharper estimators, the search and the proof are derived
        here.
    """

    tolerance: float
    n_modes: int
    start: int = 5
    most: int | None = None
    estimator: EigenvalueErrorEstimator = field(default_factory=SharperBound)
    search: ModeSearch = field(default_factory=Bisection)
    progress: Callable[[SearchStep], None] | None = field(default=None, compare=False)

    def __post_init__(self):
        check_fields(self)
        if not 0 < self.tolerance < 1:
            raise ModelError(
                f"the tolerance is {self.tolerance:g}: give a relative error of the eigenvalues between "
                "0 and 1, such as 1e-3 for 0.1 %"
            )
        if self.tolerance < SMALLEST_TOLERANCE:
            raise ModelError(
                f"the tolerance {self.tolerance:g} is below the round-off in the eigenvalues of a "
                f"large body; give {SMALLEST_TOLERANCE:g} or more"
            )
        if self.n_modes < 1 or self.start < 0 or (self.most is not None and self.most < self.start):
            raise ModelError(
                f"n_modes = {self.n_modes}, start = {self.start}, most = {self.most}: give n_modes of one or "
                "more, and 0 <= start <= most"
            )

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """The vibrations as columns, with the proof of their accuracy; see `error_controlled_modes`."""
        modes = error_controlled_modes(body, self)
        return LinearBasis(
            vectors=modes.vectors,
            frequencies=np.sqrt(modes.certificate.values),
            labels=tuple(f"error-controlled mode {i + 1}" for i in range(self.n_modes)),
            static_solver=body.constrained(frame.constraint(body)),
            certificate=modes.certificate,
        )


class ErrorControlledModes(NamedTuple):
    """Free elastic vibrations (n, N), M-orthonormal, and the proof of their accuracy."""

    vectors: np.ndarray
    certificate: EigenvalueCertificate


def error_controlled_modes(body: FlexibleBody, control: ErrorControlled) -> ErrorControlledModes:
    """The lowest vibrations of a Craig-Bampton body whose eigenvalues are within a tolerance, and the proof.

    The search finds the smallest Craig-Bampton basis whose estimated errors are within the tolerance. If the
    estimates are too high, a smaller basis would suffice.

    Raises
    ------
    ModelError      no interface; n_modes not below the number of elastic modes; start too large
    AccuracyError   the tolerance is not reached with all allowed modes; the bounds do not prove the accuracy
    """
    family = CraigBamptonFamily(body)
    _check_range(family, control)
    seconds: dict[str, float] = {}
    with timed(seconds, "modes and search"):
        steps = _search(family, control, control.estimator, control.start)
    with timed(seconds, "enclosure"):
        enclosure = _enclosed(family, control, steps[-1].n_modes)
    # The estimates, of first order, can be too low. The search then continues with the proven bounds.
    with timed(seconds, "modes added"):
        proven = KnownEigenvalues(enclosure.lower)
        if _tried(family, control, proven, steps[-1].n_modes).first_failing:
            steps += _search(family, control, proven, steps[-1].n_modes + 1)
    n_kept = steps[-1].n_modes
    vibrations = family.vibrations(n_kept, control.n_modes)
    certificate = EigenvalueCertificate(
        tolerance=control.tolerance,
        values=vibrations.values,
        enclosure=enclosure,
        n_fixed_interface_modes=n_kept,
        estimated=family.errors(n_kept, control.n_modes, control.estimator),
        steps=steps,
        seconds=seconds,
    )
    return ErrorControlledModes(family.vectors(vibrations), certificate)


def _check_range(family: CraigBamptonFamily, control: ErrorControlled) -> None:
    name = family.body.name
    if control.n_modes >= family.n_vibrations:
        raise ModelError(
            f"{control.n_modes} eigenvalues requested of body '{name}', which has {family.n_vibrations} "
            "elastic ones; request fewer: the next higher eigenvalue is needed to prove that none is missed"
        )
    if control.start > family.n_available:
        raise ModelError(
            f"{control.start} fixed-interface modes at the start, but body '{name}' has {family.n_available}"
        )


def _search(
    family: CraigBamptonFamily, control: ErrorControlled, estimator: EigenvalueErrorEstimator, first: int
) -> tuple[SearchStep, ...]:
    """The steps of the search; the last one meets the tolerance. AccuracyError if no step meets it."""
    most = family.n_available if control.most is None else min(control.most, family.n_available)

    def trial(n_kept: int) -> SearchStep:
        step = _tried(family, control, estimator, n_kept)
        if control.progress:
            control.progress(step)
        return step

    steps = control.search.run(trial, min(first, most), most)
    if steps[-1].first_failing:
        raise _not_reached(family, control, steps[-1])
    return steps


def _tried(
    family: CraigBamptonFamily, control: ErrorControlled, estimator: EigenvalueErrorEstimator, n_kept: int
) -> SearchStep:
    start = perf_counter()
    errors = family.errors(n_kept, control.n_modes, estimator)
    criterion = type(estimator).__name__
    return SearchStep(n_kept, errors, control.tolerance, criterion, perf_counter() - start)


def _enclosed(family: CraigBamptonFamily, control: ErrorControlled, n_kept: int) -> EigenvalueEnclosure:
    """Bounds for the full body's eigenvalues, from trial vibrations of the reduced body with enough modes."""
    body = family.body
    n_trial = min(family.n_vibrations, max(control.n_modes + 8, 3 * control.n_modes // 2))
    n_needed = n_trial - (len(family.rigid_motion) - 6)
    trial = family.vibrations(min(max(n_kept, n_needed), family.n_available), n_trial)
    width = max(0.01 * control.tolerance, 0.1 * SMALLEST_TOLERANCE)
    # Two factors of the matrices of a large body, gigabytes each, must not be in memory at the same time.
    make_room = family.make_room if body.n > LARGEST_WITH_TWO_FACTORS else None
    return enclose_eigenvalues(body, family.vectors(trial), control.n_modes, width, make_room)


def _not_reached(family: CraigBamptonFamily, control: ErrorControlled, step: SearchStep) -> AccuracyError:
    worst = int(np.argmax(step.errors))
    remedy = "loosen the tolerance"
    if step.n_modes < family.n_available:
        remedy += f" or allow more than most = {control.most} modes"
    return AccuracyError(
        f"body '{family.body.name}': with {step.n_modes} fixed-interface modes, the error of eigenvalue "
        f"{worst + 1} of {control.n_modes} is {step.errors[worst]:.1e}, above the tolerance "
        f"{control.tolerance:.1e} ({step.criterion}); {remedy}, or request fewer eigenvalues"
    )
