"""Green-Lagrange strain as a quadratic form of displacement gradients (the constant tensor N).

eps = B q + 1/2 N(a, a),   a = G q the displacement gradients,   N symmetric in its two arguments
"""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray


def green_lagrange_form(n_components: int, strains: tuple[tuple[int, int], ...]) -> FloatArray:
    """N of the Green-Lagrange strain: N(a, b)_ij = sum_k a_ki b_kj, twice its symmetric part for shears.

    n_components : number of displacement components k
    strains : tuple of index pairs      the strain components ij, in their Voigt order
    Returns (s, d, d): read-only; gradient a_ki = du_k/dx_i at index k n + i, n directions i.
    """
    directions = 1 + max(max(pair) for pair in strains)
    form = np.zeros((len(strains), n_components, directions, n_components, directions))
    for row, (i, j) in enumerate(strains):
        for k in range(n_components):
            form[row, k, i, k, j] = 1
            form[row, k, j, k, i] = 1
    form = form.reshape(len(strains), n_components * directions, -1)
    form.setflags(write=False)
    return form


VOIGT = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Order of the components of a symmetric tensor: xx, yy, zz, yz, xz, xy."""

SOLID_FORM = green_lagrange_form(3, VOIGT)
"""N (6, 9, 9) of a solid: strains xx, yy, zz, yz, xz, xy; gradients u,x u,y u,z v,x ... w,z."""
