"""Response of a linearised machine to harmonic and to random forces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy  # its parts are imported when first used
from numpy.typing import ArrayLike

from supple.errors import ModelError
from supple.linearization.linear_machine import Array
from supple.linearization.state_space import StateSpace

__all__ = ["FrequencyResponse", "RandomResponse", "frequency_response", "random_response"]


_BLOCK_BYTES = 2**27
"""Largest memory, bytes, of the matrices that are solved at once; more frequencies are split into blocks."""


UNDRIVEN = 1e-12
"""Relative singular value of a motion at its undamped pole; the root of it is the part of a force or of an
output that counts as none."""


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """`H(i w)` from the inputs of a state space to its outputs.

    angular_frequencies : (nf,) rad/s
    transfer : complex (nf, no, ni); `no` and `ni` are the numbers of outputs and inputs
    """

    space: StateSpace
    angular_frequencies: Array
    transfer: np.ndarray


@dataclass(frozen=True, eq=False)
class RandomResponse:
    """Stationary response to forces of given spectral density.

    angular_frequencies : (nf,) rad/s
    density : complex (nf, no, no), per rad/s, one-sided
    rms : (no,)     over the band of the frequencies
    """

    angular_frequencies: Array
    density: np.ndarray
    rms: Array


def frequency_response(space: StateSpace, angular_frequencies: ArrayLike) -> FrequencyResponse:
    """`H = C (i w - A)^-1 B + D` at each of the frequencies.

    angular_frequencies : (nf,) rad/s
    Raises ModelError for a frequency that is not finite, or at an undamped pole of a motion that the ports
    drive or see, such as the frequency 0 for a force on a free machine.
    """
    w = np.atleast_1d(np.asarray(angular_frequencies, dtype=float))
    if w.ndim != 1 or not w.size or not np.isfinite(w).all():
        raise ModelError("a frequency response needs a list of finite angular frequencies, rad/s")
    if (w == 0).any() and space.drifts.any():
        output, given = np.argwhere(space.drifts)[0]
        raise ModelError(
            f"a constant '{space.inputs[given]}' moves '{space.outputs[output]}' without end: leave out the "
            "frequency 0"
        )
    poles = np.linalg.eigvals(space.a)
    near = abs(1j * w[:, None] - poles).min(axis=1) <= 1e-12 * abs(poles).max()
    size = len(space.a)
    transfer = np.empty((len(w), len(space.c), space.b.shape[1]), dtype=complex)
    for number in np.flatnonzero(near):
        transfer[number] = _beside_pole(space, float(w[number]))
    others = np.flatnonzero(~near)
    n_blocks = -(-len(others) * size**2 * 16 // _BLOCK_BYTES)
    for part in np.array_split(others, max(n_blocks, 1)):
        states = np.linalg.solve(1j * w[part, None, None] * np.eye(size) - space.a, space.b)
        transfer[part] = space.c @ states + space.d
    return FrequencyResponse(space, w, transfer)


def _beside_pole(space: StateSpace, w: float) -> np.ndarray:
    """`H(i w)` at an undamped pole of motions that the inputs do not drive and the outputs do not see.

    For example the static compliance of a shaft across its axis, about which it turns freely.
    """
    balanced, (scale, _) = scipy.linalg.matrix_balance(space.a, permute=False, separate=True)
    matrix, inputs = 1j * w * np.eye(len(scale)) - balanced, space.b / scale[:, None]
    outputs = space.c * scale
    states, _, rank, _ = np.linalg.lstsq(matrix, inputs.astype(complex), rcond=UNDRIVEN)
    free = np.linalg.svd(matrix)[2][rank:].conj().T
    left = np.linalg.norm(matrix @ states - inputs) > UNDRIVEN**0.5 * np.linalg.norm(inputs)
    seen = np.linalg.norm(outputs @ free) > UNDRIVEN**0.5 * np.linalg.norm(outputs)
    if left or seen:
        raise ModelError(
            f"the machine has an undamped pole at {w:.6g} rad/s, where its response is infinite: "
            "give it damping, or leave that frequency out"
        )
    return outputs @ states + space.d


def random_response(response: FrequencyResponse, density: ArrayLike) -> RandomResponse:
    """Stationary response to random forces.

        S_z(w) = H S_u H^H,         rms^2 = integral S_z dw

    for the densities S_u of the inputs and S_z of the outputs; the integral is over the given frequencies.

    density : S_u, (nf,), uncorrelated and equal at all inputs, or (nf, ni, ni)     one-sided, per rad/s
    Raises ModelError for another shape, a density that is negative, not Hermitian or not finite, and for
    frequencies that do not ascend.
    Source: [Bendat2010] chapter 7.
    """
    h = response.transfer
    if not (np.diff(response.angular_frequencies) > 0).all():
        raise ModelError("the integral over the frequencies needs them in ascending order, each once")
    given = np.asarray(density)
    if given.shape == (len(h),):
        given = given[:, None, None] * np.eye(h.shape[2])
    if given.shape != (len(h), h.shape[2], h.shape[2]) or not np.isfinite(given).all():
        raise ModelError(
            f"the spectral density must have the shape ({len(h)},) or ({len(h)}, {h.shape[2]}, {h.shape[2]}) "
            f"and finite values, got {np.shape(density)}"
        )
    if abs(given - np.conj(np.swapaxes(given, 1, 2))).max() > 1e-12 * abs(given).max():
        raise ModelError("a spectral density of several inputs must be Hermitian: S_jk = conj(S_kj)")
    if np.linalg.eigvalsh(given).min() < -1e-12 * abs(given).max():
        raise ModelError("a spectral density must not be negative")
    out = h @ given @ np.conj(np.swapaxes(h, 1, 2))
    powers = np.real(np.einsum("foo->fo", out))
    rms = np.sqrt(np.trapezoid(powers, response.angular_frequencies, axis=0))
    return RandomResponse(response.angular_frequencies, out, rms)
