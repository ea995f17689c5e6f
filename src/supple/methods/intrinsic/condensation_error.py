"""How many stations are enough: frequencies of a condensed body against those of its elements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space

from supple.algebra import read_only
from supple.body import Damping, FlexibleBody
from supple.errors import AccuracyError, ModelError
from supple.methods.intrinsic.condense import condense
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody
from supple.methods.intrinsic.load_path import LoadPath
from supple.methods.intrinsic.root_support import CLAMPED, RootSupport

__all__ = ["accurate_condensation", "condensation_error"]

Array = NDArray[np.float64]

FEWEST_SEGMENTS = 6


@dataclass(frozen=True, eq=False)
class CondensationError:
    """The lowest elastic frequencies of a body on its support, rad/s.

    condensed, exact : (k,)     on stations, and of all freedoms of the elements
    """

    condensed: Array
    exact: Array

    @property
    def relative(self) -> Array:
        """(k,) of the frequencies, positive where stations are too stiff."""
        return self.condensed / self.exact - 1

    @property
    def largest(self) -> float:
        """Of them all, without its sign."""
        return float(np.abs(self.relative).max(initial=0.0))


class AccurateBody(NamedTuple):
    """A body, and the error that it has."""

    body: IntrinsicBody
    error: CondensationError


def condensation_error(body: FlexibleBody, condensed: IntrinsicBody, n_frequencies: int) -> CondensationError:
    """Errors of the lowest elastic frequencies, in ascending order on either side.

    Parameters
    ----------
    body : that was condensed
    n_frequencies : at most the elastic modes of the condensed one

    Raises ModelError for more frequencies than there are modes.
    """
    known = condensed.modes.frequencies
    if not 1 <= n_frequencies <= len(known):
        raise ModelError(
            f"body '{body.name}': errors of {n_frequencies} frequencies asked for; the condensed body has "
            f"{len(known)} elastic modes"
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
    """A body with as many stations as bring its lowest frequencies within a tolerance.

    The number of segments doubles, from 6 on, until the errors allow it.

    Parameters
    ----------
    root, tip : interfaces of the body
    tolerance : largest relative error of the lowest `n_frequencies` elastic frequencies
    n_modes, support, damping : as for `condense`

    Raises
    ------
    AccuracyError   the mesh carries no more stations: what was reached, with how many
    ModelError      as `condense`
    """
    if not 0 < tolerance < 1:
        raise ModelError(f"a tolerance of frequencies lies between 0 and 1, not {tolerance}")
    reached: tuple[int, float] | None = None
    segments = FEWEST_SEGMENTS
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
                f"body '{body.name}': with {stations} stations its lowest {n_frequencies} frequencies are "
                f"off by {least:.2g}, not by {tolerance:g}, and the mesh carries no more: {error}"
            ) from error
        error = condensation_error(body, found, n_frequencies)
        if error.largest <= tolerance:
            return AccurateBody(found, error)
        reached = (segments + 1, error.largest)
        segments *= 2


def _exact(body: FlexibleBody, condensed: IntrinsicBody, number: int) -> Array:
    """Elastic frequencies of the elements, the root held as its support holds it."""
    root = next(i for i in body.interfaces if condensed.stations.get(i.name) == 0)
    free = condensed.support.free
    held = null_space(free.T).T if free.shape[1] else np.eye(6)
    k = free.shape[1]
    rows = np.asarray(held @ root.motion.toarray())
    values = body.lowest_modes(number + k, rows if len(rows) else None).values[k:]
    return np.sqrt(values)
