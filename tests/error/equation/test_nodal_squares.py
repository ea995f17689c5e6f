"""Mean squares over nodes without the nodes."""

from __future__ import annotations

import numpy as np

from supple.algebra.rotation import rotation_exp
from supple.body import in_space
from supple.error.equation.nodal_squares import nodal_squares


def test_it_is_the_mean_over_the_nodes():
    rng = np.random.default_rng(0)
    N, s, k, t = 7, 3, 5, 4
    nodes, motion, onto = (rng.standard_normal(shape) for shape in ((N, 3), (N, 3, s), (N, 3, k)))
    g, e, origin, turn = (rng.standard_normal((t, m)) for m in (s, k, 3, 3))
    rotation = np.array([rotation_exp(psi) for psi in rng.standard_normal((t, 3))])
    place = nodes + np.einsum("nis,ts->tni", motion, g)
    seen = np.einsum("nik,tk->tni", onto, e) + np.cross(turn[:, None], place)
    moved = in_space(origin, rotation, seen)
    exact = np.sqrt(np.mean(np.sum(moved**2, axis=2), axis=1))
    told = nodal_squares(nodes, motion, onto).rms(rotation, origin, turn, g, e)
    np.testing.assert_allclose(told, exact, rtol=1e-12)
