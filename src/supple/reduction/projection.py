"""Galerkin projection: the equations of a flexible body on the columns of a basis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from supple.body import Damping, FlexibleBody, inertia_gram
from supple.errors import AccuracyError
from supple.reduction.reduced_body import ReducedBody, ReducedInterface
from supple.reduction.reduction_basis import ReductionBasis
from supple.reduction.stopwatch import timed
from supple.reduction.tensors import strain_products

LARGEST_GRAM_ERROR = 1e-8


def project(body: FlexibleBody, basis: ReductionBasis, *, damping: Damping | None = None) -> ReducedBody:
    """The reduced body of a basis: q = V gamma in the kinetic and strain energies, exactly.

    body : FlexibleBody
    basis : ReductionBasis      of that body
    damping : RayleighDamping(...), LinearRayleighDamping(...) or ModalDamping(...); None: undamped
    Raises AccuracyError when the Gram matrix misses its own identity.
    """
    V, r = basis.vectors, basis.r
    seconds = dict(basis.report.seconds)
    with timed(seconds, "inertia"):
        gram = inertia_gram(body, V)
        _check_gram(body, gram, r)
    with timed(seconds, "tensors"):
        products = strain_products(body, V)
        tensors = products.internal_force()
        time = 0.0 if damping is None else damping.retardation_time
        material = products.material(tensors) if time else None

    nodal_basis = body.expansion @ V
    rotations = body.rotation_operator
    return ReducedBody(
        name=body.name,
        frame=basis.frame,
        gram=gram,
        stiffness=tensors.stiffness,
        cubic=tensors.cubic,
        quartic=tensors.quartic,
        damping=np.zeros((r, r)) if damping is None else damping.matrix(tensors.stiffness, np.eye(r)),
        damping_cubic=None if material is None else time * material.cubic,
        damping_quartic=None if material is None else time * material.quartic,
        interfaces=tuple(
            ReducedInterface(i.name, i.position, i.motion @ V, i.cubic_turn) for i in body.interfaces
        ),
        nodes=body.nodes,
        nodal_basis=nodal_basis,
        rotation_basis=None if rotations is None else (rotations @ nodal_basis).reshape(-1, 3, r),
        rotation_limit=body.rotation_limit,
        frequencies=np.sqrt(np.linalg.eigvalsh(tensors.stiffness)),
        report=replace(basis.report, seconds=seconds),
    )


def _check_gram(body: FlexibleBody, gram: np.ndarray, r: int) -> None:
    """The Gram matrix's last block is V^T M V = I, computed from the nodal mass instead of the body's."""
    error = float(np.max(np.abs(gram[-r:, -r:] - np.eye(r)), initial=0.0))
    if not error < LARGEST_GRAM_ERROR:
        raise AccuracyError(
            f"the inertia Gram matrix of body '{body.name}' misses V^T M V = I by {error:.1e}: "
            "do its nodal mass, expansion and mass agree?"
        )
