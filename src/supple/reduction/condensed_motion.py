"""Motion outside the columns of a reduced body; it follows the reduced coordinates statically."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from supple.algebra import ReadOnlyArrays
from supple.arrays import FloatArray

__all__ = ["CondensedMotion"]


@dataclass(frozen=True, eq=False)
class CondensedMotion(ReadOnlyArrays):
    """Nodal motion z that follows the coordinates statically; the quartic tensor lacks the released energy.

        z(gamma) = fields @ (amplitudes @ m2),   m2 = (gamma_j gamma_k), j <= k as numpy.triu_indices(r)

    The strain of z is linear in z; its inertia is of leading order (module `condensed_inertia`).
    Displacements include z: the edges of a strip twisted by theta move inwards by width theta^2 / 4, a bent
    beam shortens.

    fields : (n_nodal, m)       orthonormal in the strain energy; interfaces do not move
    amplitudes : (m, n2)        n2 = r(r+1)/2
    moments : (12, n2)          inertia moments of z; None: no inertia, as in files of format version 1
    """

    fields: FloatArray
    amplitudes: FloatArray
    moments: FloatArray | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of nodal freedoms and of coordinate pairs."""
        return self.fields.shape[0], self.amplitudes.shape[1]

    def amplitudes_at(self, gamma: ArrayLike) -> FloatArray:
        """Amplitudes (..., m) of the fields at coordinates gamma (..., r)."""
        return 0.5 * self.amplitude_rates(gamma, gamma)

    def amplitude_rates(self, gamma: ArrayLike, rates: ArrayLike) -> FloatArray:
        """Rates (..., m) of the amplitudes at coordinates and their rates (..., r): bilinear in both."""
        gamma, rates = np.asarray(gamma, dtype=np.float64), np.asarray(rates, dtype=np.float64)
        first, second = np.triu_indices(gamma.shape[-1])
        products = gamma[..., first] * rates[..., second] + rates[..., first] * gamma[..., second]
        return products @ self.amplitudes.T
