"""From a flexible body to a reduced one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter

import numpy as np

from supple.algebra import mass_orthonormalize
from supple.body import FlexibleBody, Frame, ModalDamping, RayleighDamping, inertia_gram
from supple.errors import AccuracyError
from supple.reduction.compression import CompressedDerivatives
from supple.reduction.derivative_columns import DerivativeChoice
from supple.reduction.linear_basis import LinearBasisRecipe, vibrating_basis
from supple.reduction.reduced_body import ReducedBody, ReducedInterface, ReductionReport
from supple.reduction.tensors import internal_force_tensors

LARGEST_ERROR = 1e-8


def reduce(
    body: FlexibleBody,
    frame: Frame,
    basis: LinearBasisRecipe,
    *,
    derivatives: DerivativeChoice = CompressedDerivatives(10),  # noqa: B008 (it is immutable)
    damping: RayleighDamping | ModalDamping | None = None,
) -> ReducedBody:
    """Reduce a body to the coordinates of a linear basis enriched with modal derivatives.

        q = V gamma,   V = [X Theta],   V^T M V = I,   D V = 0

    The linear columns come first, by frequency (X^T K X = diag(omega^2)), then the derivatives chosen.

    body : FlexibleBody
    frame : NodalFixedFrame(interface) or MeanAxisFrame()   the motion gamma is relative to
    basis : Rubin(...), CraigBampton(...), NormalModes(...), Guyan() or CompleteBasis()
    derivatives : CompressedDerivatives(n), PickedDerivatives(n) or NoDerivatives()
    damping : RayleighDamping(...) or ModalDamping(...); None: undamped
    Raises
    ------
    ModelError      too many modes or derivatives; a basis that needs interfaces; derivatives of a linear body
    AccuracyError   the basis or the Gram matrix misses its own identities
    Source: [Wu2019] section 5.
    """
    seconds: dict[str, float] = {}
    with _timed(seconds, "linear basis"):
        linear = vibrating_basis(body, frame, basis.build(body, frame))
    with _timed(seconds, "derivatives"):
        added = derivatives.columns(body, frame, linear)
        V, _, _ = mass_orthonormalize(np.hstack([linear.vectors, added.vectors]), body.mass)
        _check_basis(body, frame, V)
    with _timed(seconds, "inertia"):
        gram = inertia_gram(body, V)
        _check_gram(body, gram, V.shape[1])
    with _timed(seconds, "tensors"):
        tensors = internal_force_tensors(body, V)

    nodal_basis = body.expansion @ V
    rotations = body.rotation_operator
    r = V.shape[1]
    return ReducedBody(
        name=body.name,
        frame=frame,
        gram=gram,
        stiffness=tensors.stiffness,
        cubic=tensors.cubic,
        quartic=tensors.quartic,
        damping=np.zeros((r, r)) if damping is None else damping.matrix(tensors.stiffness, np.eye(r)),
        interfaces=tuple(ReducedInterface(i.name, i.position, i.motion @ V) for i in body.interfaces),
        nodes=body.nodes,
        nodal_basis=nodal_basis,
        rotation_basis=None if rotations is None else (rotations @ nodal_basis).reshape(-1, 3, r),
        rotation_limit=body.rotation_limit,
        frequencies=np.sqrt(np.linalg.eigvalsh(tensors.stiffness)),
        report=ReductionReport(
            linear=linear.labels,
            derivatives=added.labels,
            dropped=linear.dropped + added.dropped,
            singular_values_kept=added.singular_values_kept,
            singular_values_dropped=added.singular_values_dropped,
            seconds=seconds,
        ),
    )


@contextmanager
def _timed(seconds: dict[str, float], step: str) -> Iterator[None]:
    start = perf_counter()
    yield
    seconds[step] = perf_counter() - start


def _check_basis(body: FlexibleBody, frame: Frame, V: np.ndarray) -> None:
    """D V = 0, each entry relative to the lengths of its row and column."""
    D = frame.constraint(body)
    lengths = np.linalg.norm(D, axis=1)[:, None] * np.linalg.norm(V, axis=0)
    error = float(np.max(np.abs(D @ V) / lengths, initial=0.0))
    if not error < LARGEST_ERROR:
        raise AccuracyError(
            f"the basis of body '{body.name}' moves against its frame by {error:.1e} "
            f"(allowed {LARGEST_ERROR:.0e})"
        )


def _check_gram(body: FlexibleBody, gram: np.ndarray, r: int) -> None:
    """The Gram matrix's last block is V^T M V = I, computed from the nodal mass instead of the body's."""
    error = float(np.max(np.abs(gram[-r:, -r:] - np.eye(r)), initial=0.0))
    if not error < LARGEST_ERROR:
        raise AccuracyError(
            f"the inertia Gram matrix of body '{body.name}' misses V^T M V = I by {error:.1e}: "
            "do its nodal mass, expansion and mass agree?"
        )
