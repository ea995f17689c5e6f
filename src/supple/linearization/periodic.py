"""Linear equations periodic in the rotation of a machine: Floquet modes by Hill's method.

    M(psi) y'' + C(psi) y' + K(psi) y = 0,     psi = r t,     y = e^(s t) sum_h y_h e^(i h psi)

Harmonics of the matrices and of the mode give one quadratic eigenvalue problem with constant coefficients,

    sum_j [ (s + i j r)^2 M_(h-j) + (s + i j r) C_(h-j) + K_(h-j) ] y_j = 0.

Each mode appears once for every harmonic, at s + i h r. Of these copies, the result contains the one with the
mean harmonic nearest to zero, whose frequency is that of most of the motion.
Source: Hill's determinant; [Hammond1974] for rotors whose equations remain periodic.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from supple.errors import AccuracyError

Array = np.ndarray

ROUNDS = (4, 7, 11)
"""Highest harmonics of a mode: the next one is used if the mode has not decayed at the last one (`LEFT`)."""
LEFT = 1e-4
"""Allowed part of a mode in its highest harmonics, relative to its norm; the square of this part is about the
relative error of the frequency."""
LARGEST = 4000
"""Largest number of states of the eigenvalue problem with more harmonics than the first of `ROUNDS`."""
HALF = 1e-3
"""Tolerance of a mean harmonic of +-1/2, where two copies of a mode are equally near to zero: the one at -1/2
is removed if that at +1/2 exists."""
ZERO = 3e-7
"""Ratio to a typical frequency below which an eigenvalue is zero within rounding."""


@dataclass(frozen=True, eq=False)
class Periodic:
    """Fourier coefficients of the matrices of a machine over one revolution, h = -H .. H.

    rate : rad per unit of time
    mass, damping, stiffness : complex (2 H + 1, k, k)
    """

    rate: float
    mass: Array
    damping: Array
    stiffness: Array

    @classmethod
    def of_samples(cls, rate: float, mass: Array, damping: Array, stiffness: Array) -> Periodic:
        """From samples (s, k, k) at evenly spaced angles of one revolution."""
        highest = (len(mass) - 1) // 2

        def coefficients(samples: Array) -> Array:
            spectrum = np.fft.fft(samples, axis=0) / len(samples)
            return np.concatenate([spectrum[-highest:], spectrum[: highest + 1]])

        return cls(rate, *map(coefficients, (mass, damping, stiffness)))

    def along(self, basis: Array) -> Periodic:
        """The coefficients for motions `basis @ y`."""
        return Periodic(
            self.rate, *(basis.T @ each @ basis for each in (self.mass, self.damping, self.stiffness))
        )


@dataclass(frozen=True, eq=False)
class FloquetModes:
    """Free motions `e^(s t) sum_h y_h e^(i h psi)`, slowest first.

    eigenvalues : complex (m,)          above the real axis
    harmonics : complex (2 h + 1, k, m)   y_h, from -h to h
    """

    eigenvalues: Array
    harmonics: Array

    @property
    def principal(self) -> Array:
        """`y_0` (k, m)."""
        return self.harmonics[len(self.harmonics) // 2]


def floquet_modes(periodic: Periodic, n_modes: int | None) -> FloquetModes:
    """The slowest modes; all by default.

    Raises AccuracyError if the harmonics of a mode do not decay.
    """
    k = periodic.mass.shape[1]
    found, last = None, np.inf
    for number in ROUNDS:
        if 2 * k * (2 * number + 1) > LARGEST and found is not None:
            break
        found = _with_harmonics(periodic, number)
        shown = found.harmonics[:, :, :n_modes]
        sizes = np.linalg.norm(shown, axis=1)
        last = float(np.max(sizes[[0, -1]] / np.linalg.norm(sizes, axis=0), initial=0.0))
        if last < LEFT:
            return found
    raise AccuracyError(
        f"the periodic equations of the machine were not solved: a mode has {last:.1e} of its motion in "
        "its highest harmonics; request fewer modes, or keep fewer modes of its bodies"
    )


def _with_harmonics(periodic: Periodic, number: int) -> FloquetModes:
    """Modes with up to the given number of harmonics."""
    k, orders = periodic.mass.shape[1], np.arange(-number, number + 1)
    frequency = 1j * periodic.rate * np.repeat(orders, k)
    matrices = periodic.mass, periodic.damping, periodic.stiffness
    mass, damping, stiffness = (_blocks(each, orders) for each in matrices)
    stiff = mass * frequency**2 + damping * frequency + stiffness
    damped = 2 * mass * frequency + damping
    factor = linalg.lu_factor(mass)
    solved = linalg.lu_solve(factor, np.hstack([stiff, damped]))
    size = len(mass)
    middle, stiffer = (each[len(each) // 2].real for each in (periodic.mass, periodic.stiffness))  # means
    unit = float(np.sqrt(np.linalg.norm(linalg.solve(middle, stiffer)))) or 1.0
    state = np.zeros((2 * size, 2 * size), dtype=complex)
    state[:size, size:] = unit * np.eye(size)
    state[size:, :size], state[size:, size:] = -solved[:, :size] / unit, -solved[:, size:]
    values, vectors = linalg.eig(state)
    harmonics = vectors[:size].reshape(len(orders), k, -1)
    weights = np.einsum("hkm,kl,hlm->hm", harmonics.conj(), middle, harmonics).real
    mean = orders @ weights / weights.sum(axis=0)
    values = np.where(abs(values) < ZERO * unit, 0.0, values)
    kept = np.flatnonzero((abs(mean) <= 0.5 + HALF) & ~_twins(values, mean, 1j * periodic.rate))
    kept = kept[values[kept].imag >= 0]
    kept = np.delete(kept, np.flatnonzero(values[kept] == 0)[1::2])  # one of the two zeros of free motions
    order = kept[np.lexsort((-values[kept].real, abs(values[kept])))]
    return FloquetModes(values[order], harmonics[:, :, order])


def _twins(values: Array, mean: Array, shift: complex) -> Array:
    """Whether modes have a mean harmonic near -1/2 and repeat others near 1/2, one harmonic apart."""
    other = np.flatnonzero(abs(mean - 0.5) <= HALF)
    twins = abs(mean + 0.5) <= HALF
    apart = abs(values[:, None] - shift - values[other]).min(axis=1, initial=np.inf)
    return twins & (apart <= HALF * abs(shift))


def _blocks(coefficients: Array, orders: Array) -> Array:
    """Block (h, j) is the coefficient h - j, zero beyond the highest one."""
    highest, k = len(coefficients) // 2, coefficients.shape[1]
    padded = np.concatenate([coefficients, np.zeros((1, k, k))])
    between = orders[:, None] - orders
    chosen = np.where(abs(between) <= highest, between + highest, len(coefficients))
    return padded[chosen].transpose(0, 2, 1, 3).reshape(len(orders) * k, len(orders) * k)
