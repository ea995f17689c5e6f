"""Galerkin projection: the equations of a flexible body on the columns of a basis."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from supple.body import Damping, FlexibleBody, FullBody, ModalDamping, inertia_gram
from supple.body.averaging_error import section_softness
from supple.body.damping import damping_matrix
from supple.errors import AccuracyError
from supple.reduction.condensation import Condensation, CondensedQuartic, QuarticChoice
from supple.reduction.locking import locking, warn_of_locking
from supple.reduction.reduced_body import ReducedBody, ReducedInterface
from supple.reduction.reduction_basis import ReductionBasis
from supple.reduction.reduction_report import timed
from supple.reduction.tensors import InternalForceTensors, require_tensor_memory, strain_products

__all__ = ["counted_damping", "project", "project_unchecked"]

LARGEST_GRAM_ERROR = 1e-8


def project(
    body: FlexibleBody,
    basis: ReductionBasis,
    *,
    damping: Damping | None = None,
    quartic: QuarticChoice = CondensedQuartic(),  # noqa: B008 (it is immutable)
) -> ReducedBody:
    """The reduced body of a basis, q = V gamma; `quartic` selects whether other motion is condensed.

    body : FlexibleBody
    basis : ReductionBasis      of that body
    damping : RayleighDamping(...), LinearRayleighDamping(...) or ModalDamping(...); None: undamped
    quartic : CondensedQuartic() condenses motion outside the columns; PlainQuartic() neglects it
    Raises AccuracyError when the Gram matrix violates V^T M V = I; MemoryShortageError when the tensors would
    exceed the available memory.
    Warns LockingWarning when the static response is too small because the columns lack stiff motion.
    """
    found = _projection(body, basis, damping, quartic)
    if found.left_out is None:
        return found.body
    report = found.body.report
    seconds = dict(report.seconds)
    with timed(seconds, "locking"):
        lost = locking(found.left_out, found.plain, found.chosen)
    warn_of_locking(body.name, lost, found.body.condensed is not None)
    return replace(found.body, report=replace(report, seconds=seconds, locking=lost))


def project_unchecked(
    body: FlexibleBody, basis: ReductionBasis, *, damping: Damping | None, quartic: QuarticChoice
) -> ReducedBody:
    """The body of `project` without locking indicator and warning; the indicator takes most of the time."""
    return _projection(body, basis, damping, quartic).body


class _Projection(NamedTuple):
    """A reduced body with the input of its locking indicator; `left_out` is None for a linear body."""

    body: ReducedBody
    left_out: Condensation | None
    plain: InternalForceTensors
    chosen: InternalForceTensors


def _projection(
    body: FlexibleBody, basis: ReductionBasis, damping: Damping | None, quartic: QuarticChoice
) -> _Projection:
    V, r = basis.vectors, basis.r
    time = 0.0 if damping is None else damping.retardation_time
    require_tensor_memory(body, r, strain_rate_damping=bool(time))
    seconds = dict(basis.report.seconds)
    with timed(seconds, "inertia"):
        gram = inertia_gram(body, V)
        _check_gram(body, gram, r)
    with timed(seconds, "tensors"):
        products = strain_products(body, V)
        classes = products.classes()
        products = products.by_classes(classes)
        tensors = plain = products.internal_force()
    motion, left_out = None, None
    if not body.is_linear:
        left_out = Condensation(body, basis)
        with timed(seconds, "condensation"):
            of_columns, products = products, quartic.strains(products, left_out)
            # Without condensation `plain` and `tensors` are one object, as `locking` requires.
            if products is not of_columns:
                products = products.by_classes(classes)
                tensors = products.internal_force()
            motion = quartic.motion(left_out)

    material = products.material(tensors) if time else (None, None)
    damping_cubic, damping_quartic = (None if each is None else time * each for each in material)
    nodal_basis = body.expansion @ V
    rotations = body.rotation_operator
    reduced = ReducedBody(
        name=body.name,
        frame=basis.frame,
        gram=gram,
        stiffness=tensors.stiffness,
        cubic=tensors.cubic,
        quartic=tensors.quartic,
        damping=damping_matrix(damping, body, V, tensors.stiffness)
        + (0.0 if body.damping is None else V.T @ (body.damping @ V)),
        damping_cubic=damping_cubic,
        damping_quartic=damping_quartic,
        interfaces=tuple(
            ReducedInterface(
                i.name, i.position, i.motion @ V, i.cubic_turn, i.tied_nodes, section_softness(body, i)
            )
            for i in body.interfaces
        ),
        nodes=body.nodes,
        nodal_basis=nodal_basis,
        rotation_basis=None if rotations is None else (rotations @ nodal_basis).reshape(-1, 3, r),
        rotation_limit=body.rotation_limit,
        frequencies=np.sqrt(np.linalg.eigvalsh(tensors.stiffness)),
        report=replace(basis.report, seconds=seconds),
        condensed=motion,
        # No full body if it has modal coordinates, which belong to no node: the nodal basis lacks them.
        full=None if body.n_modal else FullBody(body, basis.frame, counted_damping(damping, r)),
    )
    return _Projection(reduced, left_out, plain, tensors)


def counted_damping(damping: Damping | None, r: int) -> Damping | None:
    """The damping for the full body: ModalDamping of all modes becomes that of r modes; others unchanged."""
    if isinstance(damping, ModalDamping) and damping.n_modes is None:
        return replace(damping, n_modes=r)
    return damping


def _check_gram(body: FlexibleBody, gram: np.ndarray, r: int) -> None:
    """Check that the last block of the Gram matrix, V^T M V from the nodal mass, is I; else AccuracyError."""
    error = float(np.max(np.abs(gram[-r:, -r:] - np.eye(r)), initial=0.0))
    if not error < LARGEST_GRAM_ERROR:
        raise AccuracyError(
            f"the inertia Gram matrix of body '{body.name}' violates V^T M V = I by {error:.1e}: "
            "check that its nodal mass, expansion and mass agree"
        )
