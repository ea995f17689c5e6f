"""Locking: the static response of a reduced body is too small where its columns lack stiff motion."""

from __future__ import annotations

import warnings

import numpy as np
from scipy import linalg

from supple.arrays import FloatArray
from supple.body import FlexibleBody
from supple.body.rigid_motion import nodal_rigid_modes
from supple.errors import LockingWarning
from supple.reduction.bases.steady_loads import NAMES
from supple.reduction.condensation import Condensation
from supple.reduction.reduction_report import ROTATION, Locking, in_percent
from supple.reduction.tensors import InternalForceTensors

TOLERATED = 0.02
"""Relative deficit of the static response, above which `warn_of_locking` warns."""

_INCREMENTS, _ITERATIONS, _HALVINGS, _TOLERANCE = 4, 40, 8, 1e-8
"""Numbers of load increments, iterations in each, and halvings of a step; largest relative residual."""


def locking(left_out: Condensation, plain: InternalForceTensors, chosen: InternalForceTensors) -> Locking:
    """The locking indicator of a reduced body, from its tensors, without loads from the user.

    The body is fixed at its first interface and accelerated in the six rigid-body directions (without an
    interface: loaded along its six lowest shapes). All loads are scaled to the same linear strain energy, at
    which the softest linear response contains a largest rotation of 0.1 rad. Loads without rotation are left
    out; the deficit is nan where the iteration diverges. The cost is two or three nonlinear static solutions
    in r coordinates, each for all loads.

    left_out : Condensation of the body and its basis
    plain : tensors of the columns alone
    chosen : tensors of the reduced body; the object `plain` itself if no motion is condensed
    """
    body = left_out.body
    free = left_out.energy + left_out.interface_energy
    names, loads = _loads(body, left_out.basis.vectors, plain.stiffness)
    if not names:
        return Locking((), np.empty(0), np.empty(0))

    def work(tensors: InternalForceTensors) -> FloatArray:
        return np.sum(loads * _static_responses(tensors, loads), axis=1)

    whole, of_columns = work(plain.condensed(free)), work(plain)
    done = of_columns
    if chosen is not plain:
        done = work(chosen) if left_out.interface_energy.any() else whole
    return Locking(names, 1 - of_columns / whole, 1 - done / whole)


def warn_of_locking(name: str, found: Locking, is_condensed: bool) -> None:
    """Warn with LockingWarning when the static response to a load is more than 2 % too small."""
    if found.largest_remaining <= TOLERATED:
        return
    worst = found.loads[int(np.nanargmax(found.remaining))]
    remedy = (
        "its basis lacks the static shapes of its interfaces: take Rubin, CraigBampton or AttachmentModes"
        if is_condensed
        else "its columns lack stiff motion: take quartic=CondensedQuartic(), the default, or add derivatives"
    )
    warnings.warn(
        f"reduced body '{name}' locks: under {worst}, rotated by about {ROTATION:g} rad, its response is "
        f"{in_percent(found.largest_remaining)} too small; {remedy}",
        LockingWarning,
        stacklevel=2,
    )


def _loads(body: FlexibleBody, V: FloatArray, stiffness: FloatArray) -> tuple[tuple[str, ...], FloatArray]:
    """Names (k) and generalised loads (k, r), of one linear energy; none if no load causes rotation."""
    turns = None if body.rotation_operator is None else (body.rotation_operator @ (body.expansion @ V))
    if body.interfaces:
        held = body.interfaces[0].motion
        nodal = nodal_rigid_modes(body.nodes - body.interfaces[0].position, body.dofs_per_node)
        forces = body.expansion.T @ (body.nodal_mass @ nodal)
        # The reaction at the interface balances the loads: the sum does no work on the six rigid motions.
        moves = held @ body.rigid_modes
        forces = forces - held.T @ np.linalg.solve(moves.T, body.rigid_modes.T @ forces)
        names, loads = NAMES[:6], (V.T @ forces).T
        relative = held[3:] @ V
    else:
        _, shapes = np.linalg.eigh(stiffness)
        loads = (stiffness @ shapes[:, :6]).T
        names = tuple(f"push along shape {i + 1}" for i in range(len(loads)))
        relative = np.zeros((3, V.shape[1]))
    responses = np.linalg.solve(stiffness, loads.T)
    energies = 0.5 * np.sum(loads.T * responses, axis=0)
    if turns is None or not np.any(energies > 0):
        return (), np.empty((0, V.shape[1]))
    bends = energies > 1e-14 * energies.max()
    turned = (turns @ responses).reshape(-1, 3, len(loads)) - relative @ responses
    largest = np.sqrt(np.max(np.sum(turned**2, axis=1), axis=0))
    bends &= largest > 0
    if not bends.any():
        return (), np.empty((0, V.shape[1]))
    reference = np.min(energies[bends] * (ROTATION / largest[bends]) ** 2)
    kept = np.flatnonzero(bends)
    return tuple(names[i] for i in kept), loads[kept] * np.sqrt(reference / energies[kept])[:, None]


@np.errstate(all="ignore")  # a buckling body may overflow before the iteration ends
def _static_responses(tensors: InternalForceTensors, loads: FloatArray) -> FloatArray:
    """Equilibria (k, r) under loads (k, r), all at once by Newton's method; nan without convergence."""
    factor = linalg.cho_factor(tensors.stiffness)

    def size(forces: FloatArray) -> FloatArray:
        return np.sqrt(np.sum(forces * linalg.cho_solve(factor, forces.T).T, axis=1))

    responses, alive = np.zeros(loads.shape), np.ones(len(loads), dtype=bool)
    for share in np.linspace(0, 1, _INCREMENTS + 1)[1:]:
        allowed = _TOLERANCE * share * size(loads)
        for _ in range(_ITERATIONS):
            residual = share * loads - tensors.internal_force(responses)
            error = size(residual)
            moving = np.flatnonzero(alive & (error > allowed))
            if not moving.size:
                break
            at, before = responses[moving], error[moving]
            step = np.linalg.solve(tensors.tangent(at), residual[moving, :, None])[..., 0]
            length = np.ones((len(moving), 1))
            for _ in range(_HALVINGS):
                worse = size(share * loads[moving] - tensors.internal_force(at + length * step)) > 2 * before
                if not worse.any():
                    break
                length[worse] /= 2
            responses[moving] = at + length * step
        else:
            alive &= size(share * loads - tensors.internal_force(responses)) <= allowed
    responses[~alive] = np.nan
    return responses
