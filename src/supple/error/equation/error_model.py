"""System of the error equation: each assessed body is reduced to the columns of its error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from supple.arrays import FloatArray
from supple.body import Damping, FlexibleBody, Frame, inertia_gram
from supple.body.damping import damping_matrix
from supple.machine import Placed, System
from supple.reduction import ReducedBody, ReducedInterface, ReductionReport, filled_up

MULTIPLE = 32
MOST_DOUBLED = 128
BRIEF = 5000
"""Largest number of steps of a short run. In a longer run, 128 instead of 96 columns cost more time than the
compilation of another program."""


def padded_size(size: int, steps: float) -> int:
    """Padded number of columns, 32, 64, 96 ..: spaces of similar sizes share one compiled program.

    In a short run 64 is followed by 128, because the spaces of most bodies have 80 to 120 columns.
    """
    multiple = -(-size // MULTIPLE) * MULTIPLE
    return MOST_DOUBLED if 2 * MULTIPLE < multiple <= MOST_DOUBLED and steps <= BRIEF else multiple


def body_of_columns(
    body: FlexibleBody, frame: Frame, columns: FloatArray, damping: Damping | None, steps: float
) -> ReducedBody:
    """A body reduced to columns (n, k), linearised about its undeformed state, with padding coordinates.

    steps : total number of steps of the runs that use these columns; it determines the padding
    The effect of the deformation on stiffness and damping is added by `ElasticGain`.
    """
    k = columns.shape[1]
    stiffness = columns.T @ (body.stiffness @ columns)
    stiffness = (stiffness + stiffness.T) / 2
    own = ReducedBody(
        name=body.name,
        frame=frame,
        gram=inertia_gram(body, columns),
        stiffness=stiffness,
        cubic=None,
        quartic=None,
        damping=damping_matrix(damping, body, columns, stiffness),
        interfaces=tuple(
            ReducedInterface(i.name, i.position, i.motion @ columns, i.cubic_turn) for i in body.interfaces
        ),
        nodes=body.nodes,
        nodal_basis=body.expansion @ columns,
        rotation_basis=None,
        rotation_limit=body.rotation_limit,
        frequencies=np.sqrt(np.maximum(np.diag(stiffness), 0.0)),
        report=ReductionReport(linear=tuple(f"column {i + 1}" for i in range(k))),
        padding=padded_size(k, steps) - k,
        elastic_elsewhere=not body.is_linear,
    )
    return filled_up(own)


def system_of_columns(system: System, bodies: Mapping[str, ReducedBody]) -> System:
    """The system with these bodies in place of those of the same names, undeformed at the start."""

    def placed(each: Placed) -> Placed:
        if each.body.name not in bodies:
            return each
        body = bodies[each.body.name]
        at_rest = np.zeros(body.r)
        return replace(each, body=body, coordinates=at_rest, coordinate_rates=at_rest)

    return replace(system, bodies=tuple(placed(each) for each in system.bodies))
