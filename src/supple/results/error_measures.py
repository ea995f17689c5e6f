"""Distance between two motions of the same nodes: RMS error over time, relative error of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray
from supple.body import BodyForm
from supple.body.floating_kinematics import time_slices
from supple.errors import ModelError
from supple.integrate.motion import Motion
from supple.integrate.solution import Solution

__all__ = ["MotionError", "motion_error", "relative_error", "rms_error"]


@dataclass(frozen=True)
class MotionError:
    """Distance between two motions of the same n nodes.

    times : (t,)                s
    rms : (t,)                  root-mean-square distance of the nodes, unit of length; `rms_error`
    relative_percent : float    relative error over all times, %; `relative_error`
    """

    times: FloatArray
    rms: FloatArray
    relative_percent: float

    @property
    def max_rms(self) -> float:
        """Largest of `rms`."""
        return float(self.rms.max())


def rms_error(reference: FloatArray, positions: FloatArray) -> FloatArray:
    """Root-mean-square distance between two sets of nodal positions, over time.

        eps_RMS(t) = sqrt(1/n sum_a |r_a(t) - rbar_a(t)|^2)

    Parameters
    ----------
    reference, positions : array (t, n, 3)     r and rbar, positions in space of n nodes at t times

    Returns
    -------
    array (t,)
    Source: [Wu2019] (52)
    """
    return np.sqrt(_squared_distance(reference, positions) / reference.shape[1])


def relative_error(reference: FloatArray, positions: FloatArray) -> float:
    """Error of a whole run, in percent.

        RE = sqrt(sum_t |r - rbar|^2) / sqrt(sum_t |r|^2) 100 %

    r and rbar are the vectors of all reference and compared nodal positions at a time. RE depends on the
    choice of the origin, because r is relative to it.

    Parameters as for `rms_error`.
    Source: [Wu2019] (53)
    """
    return _percent(
        _squared_distance(reference, positions).sum(), np.einsum("tni,tni->", reference, reference)
    )


def motion_error(
    reference: Solution,
    reference_body: BodyForm,
    candidate: Solution,
    candidate_body: BodyForm,
    *,
    body: str,
) -> MotionError:
    """RMS and relative error of a body's nodal positions in one solution, compared with another solution.

    Parameters
    ----------
    reference, candidate : Solution     with the same output times, such as of a full and of a reduced body
    reference_body, candidate_body      form of the body in each solution, with the same nodes
    body : str                          name of the body, the same in both solutions

    Raises
    ------
    ModelError  a solution without this body, different output times, or different nodes
    Source: [Wu2019] (52), (53)
    """
    expected, found = reference.motion(body, Motion), candidate.motion(body, Motion)
    times = reference.times
    # Output times are sums of steps, so they can differ by rounding.
    if times.shape != candidate.times.shape or not np.allclose(
        times, candidate.times, rtol=1e-9, atol=1e-9 * abs(times[-1])
    ):
        raise ModelError(
            f"the solutions of body '{body}' have different output times ({len(times)} to t = {times[-1]:g}, "
            f"{len(candidate.times)} to t = {candidate.times[-1]:g}): compare runs with the same output step"
        )
    if not np.array_equal(reference_body.nodes, candidate_body.nodes):
        raise ModelError(
            f"the two models of body '{body}' have different nodes ({len(reference_body.nodes)} and "
            f"{len(candidate_body.nodes)}): compare models of one mesh"
        )
    distance, size = np.empty(len(times)), 0.0
    for rows in time_slices(reference_body, len(times)):
        r = reference_body.positions(expected.at(rows))
        distance[rows] = _squared_distance(r, candidate_body.positions(found.at(rows)))
        size += float(np.einsum("tni,tni->", r, r))
    rms = np.sqrt(distance / len(reference_body.nodes))
    return MotionError(times, rms, _percent(distance.sum(), size))


def _squared_distance(reference: FloatArray, positions: FloatArray) -> FloatArray:
    if reference.shape != positions.shape:
        raise ModelError(
            f"error measure: positions of shapes {reference.shape} and {positions.shape}; "
            "compare the same nodes at the same times"
        )
    return np.sum((reference - positions) ** 2, axis=(1, 2))


def _percent(squared_distance: float, squared_size: float) -> float:
    return 100.0 * float(np.sqrt(squared_distance / squared_size))
