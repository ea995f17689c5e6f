"""Guaranteed bounds, from both sides, for the eigenvalues of a free body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from supple.algebra import ReadOnlyArrays, count_below
from supple.body import FlexibleBody, MeanAxisFrame
from supple.errors import AccuracyError

__all__ = ["EigenvalueEnclosure", "enclose_eigenvalues"]

# Number of subspace iterations that do not halve the width of the bounds, after which the search stops.
ROUNDS = 12
RIGID_MOTIONS = 6

# Smallest relative gap of the spectrum at the shift; below it, random motions are added, because a cluster
# may be larger than the set of trial motions.
SMALLEST_GAP = 1e-3

# Ratio to the largest energy or inverse eigenvalue, below which a value may be round-off and is dropped.
SMALLEST_PART = 1e-13

# Largest number of times that random motions are added; each time at most as many as there are trial motions.
MOST_WIDENED = 4


@dataclass(frozen=True, eq=False)
class EigenvalueEnclosure(ReadOnlyArrays):
    """lower_n <= chi_n <= upper_n for the n-th elastic eigenvalue of a free body, none missed.

    lower, upper : (N,)     rad^2/s^2
    shift : float           above the last upper bound, in a gap of the spectrum
    n_below : int           number of eigenvalues below the shift, by matrix inertia; with six rigid motions
    """

    lower: np.ndarray
    upper: np.ndarray
    shift: float
    n_below: int


def enclose_eigenvalues(
    body: FlexibleBody,
    trial: np.ndarray,
    n_values: int,
    largest_width: float,
    make_room: Callable[[], None] | None = None,
) -> EigenvalueEnclosure:
    """Enclose the lowest n_values elastic eigenvalues of a free body by Lehmann and Goerisch's theorem.

    U: trial motions; W: their static responses, K W = M U. The number of negative eigenvalues of K - rho M
    proves that exactly p elastic eigenvalues are below the shift rho. Then the p negative eigenvalues mu of

        (A0 - rho A1) x = mu (A0 - 2 rho A1 + rho^2 A2) x
        A0 = U^T K U,    A1 = U^T M U,    A2 = W^T K W

    give lower bounds chi_n >= rho mu / (mu - 1); the most negative mu bounds the highest eigenvalue. The
    Rayleigh-Ritz values of U are upper bounds. Subspace iteration from the trial motions narrows the bounds,
    also for multiple eigenvalues. Random motions are added where a cluster is larger than the set of trial
    motions, or where the count shows that a mode is missing. The theorems are exact and evaluated in floating
    point: the proof holds up to round-off.

    trial : (n, k)          approximations of the lowest elastic modes, k somewhat above n_values
    largest_width : float   largest value allowed of upper / lower - 1
    make_room : called before K - rho M is factored, to release memory
    Raises AccuracyError when the bounds remain wider than largest_width, or the count and the modes found
        disagree.
    Source: [Lehmann1963] in the form of [GoerischHaunhorst1985]; with one trial motion it is Temple's and
        Kato's bound.
    """
    mean_axis = body.constrained(MeanAxisFrame().constraint(body))
    W = mean_axis.solve(body.mass @ trial)
    del trial  # releases memory, which a large body needs
    width = narrowest = np.inf
    count, inside, rounds, widened = None, 0, 0, 0
    while rounds < ROUNDS:
        rounds += 1
        U, upper = _ritz(body, W)
        del W
        if upper.size <= n_values:
            break
        W = mean_axis.solve(body.mass @ U)
        n_left = body.n - RIGID_MOTIONS - upper.size
        n_more = min(upper.size, n_left) if widened < MOST_WIDENED else 0
        # The less accurate upper half of the spare motions is left out, unless it completes the spectrum.
        n_exact = max(n_values + 2, (n_values + upper.size) // 2 + 1) if n_left else upper.size
        inside, gap = _last_before_gap(upper[:n_exact], n_values)
        if gap >= SMALLEST_GAP or n_more == 0:
            shift, lower, width = _bounds(upper, U.T @ (body.mass @ W), inside)
            if width <= largest_width:
                if make_room is not None:
                    make_room()
                below = count_below(body.stiffness, body.mass, shift, grounded=body.grounded_stiffness)
                count = below - RIGID_MOTIONS
                if count == inside:
                    return EigenvalueEnclosure(lower[:n_values], upper[:n_values], shift, below)
            else:
                if width < 0.5 * narrowest:
                    rounds, narrowest = rounds - 1, width
                if rounds < ROUNDS or widened:
                    continue
        if n_more:
            # A cluster extends beyond the trial motions, or a mode is missing from them, such as one of a
            # symmetric body without motion at the interfaces.
            random = np.random.default_rng(n_more).standard_normal((body.n, n_more))
            W = np.hstack([W, mean_axis.solve(body.mass @ random)])
            rounds, narrowest, widened = 0, np.inf, widened + 1
    found = f"bounds {width:.1e} apart" if count is None else f"{inside} found, {count} counted"
    raise AccuracyError(
        f"the lowest {n_values} eigenvalues of body '{body.name}' could not be enclosed to "
        f"{largest_width:.0e} ({found}); give more trial motions or, where the body is so slender that "
        "round-off in its stiffness keeps the bounds apart, a looser tolerance"
    )


def _ritz(body: FlexibleBody, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """M-orthonormal Ritz vectors of columns, and their values, ascending; the columns are overwritten.

    Dependent columns are dropped, as are vectors whose inverse value is round-off compared with the largest.
    """
    columns /= np.sqrt(np.einsum("ij,ij->j", columns, body.stiffness @ columns))
    energies, directions = linalg.eigh(columns.T @ (body.stiffness @ columns))
    first = np.searchsorted(energies, SMALLEST_PART * energies[-1])
    independent = directions[:, first:] / np.sqrt(energies[first:])
    mu, weights = linalg.eigh(independent.T @ (columns.T @ (body.mass @ columns)) @ independent)
    first = np.searchsorted(mu, SMALLEST_PART * mu[-1])
    mu, weights = mu[first:][::-1], weights[:, first:][:, ::-1]
    return columns @ (independent @ weights / np.sqrt(mu)), 1 / mu


def _last_before_gap(values: np.ndarray, n_values: int) -> tuple[int, float]:
    """Number of values below the widest relative gap after the first n_values, and the width of the gap."""
    near = values[n_values - 1 :]
    widths = np.diff(near) / near[:-1]
    widest = int(np.argmax(widths))
    return n_values + widest, float(widths[widest])


def _bounds(upper: np.ndarray, A2: np.ndarray, inside: int) -> tuple[float, np.ndarray, float]:
    """A shift above the first `inside` Ritz values, lower bounds below the shift, and their largest width."""
    shift = 0.5 * float(upper[inside - 1] + upper[inside])
    lower = _lehmann_goerisch(upper, A2, shift)
    if lower.size != inside:
        return shift, lower, np.inf
    # Absolute, because a lower bound above its upper bound is round-off and proves nothing.
    return shift, lower, float(np.max(np.abs(upper[:inside] / lower - 1)))


def _lehmann_goerisch(values: np.ndarray, A2: np.ndarray, rho: float) -> np.ndarray:
    """Lower bounds, ascending, for the eigenvalues below rho, from Ritz values (A1 = I, A0 = diag).

    Empty where rho is a Ritz value to working precision.
    """
    right = np.diag(values - 2 * rho) + rho**2 * A2
    if not np.all(np.diag(right) > 0):
        return np.empty(0)
    # Scaled, as the columns' energies span many decades.
    scale = 1 / np.sqrt(np.diag(right))
    mu = linalg.eigh(
        np.diag((values - rho) * scale**2), scale[:, None] * right * scale, eigvals_only=True, driver="gv"
    )
    mu = mu[mu < 0]
    return np.sort(rho * mu / (mu - 1))
