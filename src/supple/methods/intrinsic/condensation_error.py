"""Condensation error: frequencies of a condensed body compared with those of its elements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import null_space

from supple.algebra import read_only
from supple.arrays import FloatArray
from supple.body import Damping, FlexibleBody
from supple.errors import AccuracyError, ModelError
from supple.methods.intrinsic.condense import condense
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody
from supple.methods.intrinsic.load_path import LoadPath
from supple.methods.intrinsic.root_support import CLAMPED, RootSupport

__all__ = ["accurate_condensation", "condensation_error"]


FEWEST_SEGMENTS = 6
"""Initial number of segments of `accurate_condensation`."""


@dataclass(frozen=True, eq=False)
class CondensationError:
    """Lowest elastic frequencies of a body on its support, rad/s.

    condensed, exact : (k,)     of the line of stations, and of the elements with all freedoms
    """

    condensed: FloatArray
    exact: FloatArray

    @property
    def relative(self) -> FloatArray:
        """(k,) relative errors of the frequencies, positive where the condensed body is too stiff."""
        return self.condensed / self.exact - 1

    @property
    def largest(self) -> float:
        """Largest absolute value of the relative errors."""
        return float(np.abs(self.relative).max(initial=0.0))


class AccurateBody(NamedTuple):
    """A body and its condensation error."""

    body: IntrinsicBody
    error: CondensationError


def condensation_error(body: FlexibleBody, condensed: IntrinsicBody, n_frequencies: int) -> CondensationError:
    """Errors of the lowest elastic frequencies, compared in ascending order.

    Parameters
    ----------
    body : the body before condensation
    condensed : the condensed body
    n_frequencies : number of frequencies, at most that of the elastic modes of `condensed`, without
        second-order modes

    Raises ModelError for more frequencies than there are modes, and for a root that is not an interface.
    """
    known = condensed.modes.frequencies
    if not 1 <= n_frequencies <= len(known):
        raise ModelError(
            f"body '{body.name}': errors of {n_frequencies} frequencies requested; the condensed body has "
            f"{len(known)} elastic modes: request at most this number"
        )
    exact = _exact(body, condensed, n_frequencies)
    return CondensationError(read_only(known[:n_frequencies]), read_only(exact))


def accurate_condensation(
    body: FlexibleBody,
    root: str,
    tip: str,
    *,
    tolerance: float,
    n_frequencies: int = 6,
    n_modes: int | None = None,
    support: RootSupport = CLAMPED,
    damping: Damping | None = None,
) -> AccurateBody:
    """A condensed body with enough stations for a tolerance of its lowest frequencies, and its error.

    The number of segments starts at 6, or 12, 24, .. if the modes need more, and doubles until the errors are
    within the tolerance.

    Parameters
    ----------
    root, tip : interfaces of the body
    tolerance : largest relative error of the lowest `n_frequencies` elastic frequencies
    n_modes : as for `condense`, but at least n_frequencies
    support, damping : as for `condense`

    Raises
    ------
    AccuracyError   the mesh allows no more stations; the message states the error reached
    ModelError      a tolerance that is not between 0 and 1; and as `condense`, also for more frequencies or
                    modes than the mesh allows
    """
    if not 0 < tolerance < 1:
        raise ModelError(f"a tolerance of frequencies must be between 0 and 1, not {tolerance}")
    reached: tuple[int, float] | None = None
    segments = FEWEST_SEGMENTS
    while 6 * segments < max(n_frequencies, n_modes or 0):  # elastic modes of the line
        segments *= 2
    while True:
        try:
            found = condense(
                body,
                LoadPath(root, tip, segments + 1),
                support=support,
                n_modes=None if n_modes is None else max(n_modes, n_frequencies),
                damping=damping,
            )
        except ModelError as error:
            if reached is None:
                raise
            stations, least = reached
            raise AccuracyError(
                f"body '{body.name}': with {stations} stations its lowest {n_frequencies} frequencies have "
                f"an error of {least:.2g}, above {tolerance:g}, and the mesh allows no more stations: {error}"
            ) from error
        error = condensation_error(body, found, n_frequencies)
        if error.largest <= tolerance:
            return AccurateBody(found, error)
        reached = (segments + 1, error.largest)
        segments *= 2


def _exact(body: FlexibleBody, condensed: IntrinsicBody, number: int) -> FloatArray:
    """Elastic frequencies of the elements, with the root supported as in the condensed body."""
    root = next((each for each in body.interfaces if condensed.stations.get(each.name) == 0), None)
    if root is None:
        raise ModelError(
            f"body '{body.name}': its frequencies are compared on the support of the root, but the first "
            "station is not an interface of the body: define an interface there, and give its name"
        )
    free = condensed.support.free
    held = null_space(free.T).T if free.shape[1] else np.eye(6)
    k = free.shape[1]
    rows = np.asarray(held @ root.motion.toarray())
    values = body.lowest_modes(number + k, rows if len(rows) else None).values[k:]
    return np.sqrt(values)
