"""Error of a finished run caused by its bases, estimated by one more run with much richer bases.

The richer bases contain the old basis, the 24 lowest modes in the frame and 12 leading directions of the
motion outside the basis (`system_corrections`). With controllers that motion is unknown, because the
controller forces are known during the run only. Then the richer bases contain the static shapes of the
interfaces and compressed derivatives instead. In some accepted runs, the error equation gave 0.2 to 0.6 of
the true error; the distance to a run with richer bases was then 0.75 to 1.0 of the true error.

The first richer run has a strain energy of second order in the added coordinates (`second_order_beyond`). If
it stops early, or the motion due to the neglected terms is too large (`NEGLECTED`), it is repeated with all
terms.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from supple.blas_threads import one_blas_thread
from supple.body.full_body import FullBody
from supple.error.basis_error import ENRICH
from supple.error.leading_fields import leading_fields
from supple.error.residual_correction import system_corrections
from supple.error.sample_times import stratified_samples
from supple.errors import SuppleWarning
from supple.integrate import ErrorPart, FloatingMotion, Run, Solution, StepProgress, Validity
from supple.machine import Placed, System
from supple.quantities.quantity_of_interest import QuantityOfInterest, quantity_distance
from supple.reduction import (
    CompressedDerivatives,
    CondensedQuartic,
    CraigBampton,
    NoDerivatives,
    NormalModes,
    PlainQuartic,
    ReducedBody,
    ReductionBasis,
    enrich,
    reduction_basis,
)
from supple.reduction.projection import project_unchecked
from supple.reduction.second_order import second_order_beyond
from supple.simulation.watched_run import watched_run

MODES, DIRECTIONS = 24, 12
INSTANTS = 50
NEGLECTED = 0.05
"""Largest motion due to neglected terms of the energy, as a fraction of the motion in added coordinates;
above it, the run is repeated with all terms."""
SOFTEST = 1e-12
"""Fraction of the largest eigenvalue of the tangent; smaller eigenvalues count as zero stiffness."""
SHORTER_STEPS = "take shorter steps, or softer stops and springs, so that the richer bases reach the end"
"""Remedy where the run with richer bases stops early."""


@one_blas_thread()
def check_run(
    system: System,
    run: Run,
    solution: Solution,
    fulls: Mapping[str, FullBody],
    bases: Mapping[str, ReductionBasis],
    quantities: Sequence[QuantityOfInterest],
    *,
    missed: Mapping[str, np.ndarray] | None = None,
    progress: StepProgress | None = None,
) -> tuple[dict[str, ErrorPart], dict[str, np.ndarray]]:
    """Error of a finished run caused by its bases, by quantity of interest, and its shapes by body.

    The shapes are the leading directions (n, m) of the difference between the richer run and this one, each
    with its RMS size. If the richer run stopped early, the errors are infinite and there are no shapes.

    fulls, bases : full bodies and bases of the assessed reduced bodies, by name
    missed : (n, m) displacement fields outside each basis; None: found here at `INSTANTS` times, except
        with controllers
    """
    report = progress or (lambda _step, _share: None)
    step = "motion outside the bases"
    report(step, 0.0)
    added = missed or {}
    if missed is None and not system.controllers:
        reduced = [fulls[name] for name in bases]
        n_times = len(solution.times)
        instants = stratified_samples(n_times, min(INSTANTS, n_times - 1), seed=n_times)
        found = system_corrections(
            system, reduced, bases, solution, instants, progress=lambda x: report(step, x)
        )
        added = {name: own.deformation for name, own in found.items()}
    richer = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SuppleWarning)
        for name, basis in bases.items():
            richer[name] = _richer(fulls[name], basis, added.get(name))
        whole = replace(system, bodies=tuple(_placed(each, fulls, bases, richer) for each in system.bodies))
        finer = replace(whole, bodies=tuple(_to_second_order(each, bases) for each in whole.bodies))
        step = "the same run with richer bases"
        report(step, 0.0)

        def simulated(machine: System) -> Solution:
            own = replace(run, validity=Validity())
            return watched_run(machine, own, progress=lambda x: report(step, x), check=False)

        check = simulated(finer)
        if not all(_suffices(whole, finer, check, name, basis.r) for name, basis in bases.items()):
            finer, check = whole, simulated(whole)
    besides = "static shapes with derivatives" if system.controllers else "corrections"
    how = f"a run with {MODES} more modes and {DIRECTIONS} more {besides}"
    if check.stopped is not None:
        unknown = ErrorPart(np.inf, f"no estimate: {how} stopped early: {check.stopped}", SHORTER_STEPS)
        return {each.name: unknown for each in quantities}, {}
    parts = {
        each.name: ErrorPart(quantity_distance(each, system, solution, finer, check), how, ENRICH)
        for each in quantities
    }
    shapes = {}
    for name, basis in bases.items():
        before = solution.motion(name, FloatingMotion).coordinates @ _onto(fulls[name], basis, richer[name]).T
        after = check.motion(name, FloatingMotion).coordinates
        shapes[name] = leading_fields(richer[name].vectors, after - before, most=DIRECTIONS)
    return parts, shapes


def _onto(full: FullBody, basis: ReductionBasis, richer: ReductionBasis) -> np.ndarray:
    """Coordinates of the columns of a basis in a richer, M-orthonormal basis."""
    return richer.vectors.T @ (full.body.mass @ basis.vectors)


def _richer(full: FullBody, basis: ReductionBasis, missed: np.ndarray | None) -> ReductionBasis:
    """The basis with modes and the motion outside it; missed None: with static shapes and derivatives."""
    n_modes = min(MODES, max(full.n_coordinates - 8, 1))
    modes = reduction_basis(full.body, full.frame, NormalModes(n_modes), derivatives=NoDerivatives())
    more = enrich(full.body, basis, modes.vectors, n_modes).basis
    if missed is None:
        recipe = CraigBampton(1) if full.interfaces else NormalModes(n_modes)
        missed = reduction_basis(
            full.body, full.frame, recipe, derivatives=CompressedDerivatives(DIRECTIONS)
        ).vectors
    return enrich(full.body, more, missed, DIRECTIONS).basis


def _placed(
    placed: Placed,
    fulls: Mapping[str, FullBody],
    bases: Mapping[str, ReductionBasis],
    richer: Mapping[str, ReductionBasis],
) -> Placed:
    body = cast("ReducedBody", placed.body)
    if body.name not in richer:
        return placed
    full, basis = fulls[body.name], richer[body.name]
    quartic = PlainQuartic() if body.condensed is None else CondensedQuartic()
    more = project_unchecked(full.body, basis, damping=full.damping, quartic=quartic)
    onto = _onto(full, bases[body.name], basis)
    return replace(
        placed,
        body=more,
        coordinates=onto @ placed.coordinates,
        coordinate_rates=onto @ placed.coordinate_rates,
    )


def _to_second_order(placed: Placed, bases: Mapping[str, ReductionBasis]) -> Placed:
    body = cast("ReducedBody", placed.body)
    if body.name not in bases:
        return placed
    return replace(placed, body=second_order_beyond(body, leading=bases[body.name].r))


def _suffices(whole: System, finer: System, check: Solution, name: str, leading: int) -> bool:
    """Whether the terms of a body's energy beyond second order would change the richer run only slightly.

        |K_t^+ (f - f_2)| <= NEGLECTED |d|      largest of each side over `INSTANTS` times, in the M-norm

    f : internal force with all terms;  f_2, K_t : force of the energy of second order, and its tangent, with
    the pseudo-inverse K_t^+
    d : coordinates after the first `leading` ones
    """
    body, short = (cast("ReducedBody", each.placed(name).body) for each in (whole, finer))
    if body is short:
        return True
    if check.stopped is not None:
        return False
    coordinates = check.motion(name, FloatingMotion).coordinates
    sampled = coordinates[np.linspace(0, len(coordinates) - 1, INSTANTS).round().astype(int)]
    forces = body.tensors.internal_force(sampled) - short.tensors.internal_force(sampled)
    softness = np.linalg.pinv(short.tensors.tangent(sampled), rcond=SOFTEST, hermitian=True)
    moved = np.linalg.norm(np.einsum("tij,tj->ti", softness, forces), axis=1)
    added = np.linalg.norm(sampled[:, leading:], axis=1)
    return bool(moved.max() <= NEGLECTED * added.max())
