"""Linearised multi-point constraints: *MPC except BEAM, which is a rigid tie."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from supple.arrays import FloatArray
from supple.importers.freedom_sums import Terms, motion_along, relative_motion


def mpc_rows(
    kind: str, first: int, others: Sequence[int], positions: FloatArray
) -> Iterator[tuple[Terms, int]]:
    """Constraint rows, each with the freedom that it eliminates, or -1.

    p is the node `first`; a, b, c are the nodes `others`.

    TIE, PIN           u_p = u_a, with or without rotations
    LINK               constant distance between p and a
    LINEAR, QUADRATIC  displacement and rotation of p are interpolated on the edge a b, or a b c
    SLIDER             p stays on the line through a and b
    """
    p, place = first, positions[first]
    if kind == "LINK":
        (a,) = others
        span = place - positions[a]
        if np.linalg.norm(span) > 0:
            yield relative_motion(p, a, span / np.linalg.norm(span)), -1
        return
    if kind == "SLIDER":
        a, b = others
        along_line = positions[b] - positions[a]
        if np.linalg.norm(along_line) > 0:
            share = float((place - positions[a]) @ along_line / (along_line @ along_line))
            for across in np.linalg.svd(along_line[None])[2][1:]:
                weights = ((p, 1.0), (a, share - 1.0), (b, -share))
                yield [term for n, w in weights for term in motion_along(n, across, w)], -1
        return
    shares = [1.0] if len(others) == 1 else _shares(place, positions[list(others)])
    for component in range(3 if kind == "PIN" else 6):
        terms = [(6 * n + component, -share) for n, share in zip(others, shares, strict=True)]
        yield [(6 * p + component, 1.0), *terms], 6 * p + component


def _shares(place: FloatArray, nodes: FloatArray) -> list[float]:
    """Shape functions of the nodes of an edge at a position on it, linear or quadratic.

    On a quadratic edge x(s) = sum_i N_i(s) x_i, the position determines s; the middle node need not be
    halfway.
    """
    if len(nodes) == 2:
        chord = nodes[1] - nodes[0]
        s = float((place - nodes[0]) @ chord / (chord @ chord))
        return [1 - s, s]
    distance = np.linalg.norm(nodes[:, None] - nodes, axis=2)
    middle = int(np.argmin(distance.sum(axis=1)))
    first, last = (i for i in range(3) if i != middle)
    chord = nodes[last] - nodes[first]
    t, at = ((x - nodes[first]) @ chord / (chord @ chord) for x in (nodes[middle], place))
    # The middle node is at t along the chord (0 to 1), the point s at s^2 (2 - 4 t) + s (4 t - 1).
    b = 4 * t - 1
    s = float(2 * at / (b + np.sqrt(max(b**2 + 4 * (2 - 4 * t) * at, 0.0))))
    shares = [0.0, 0.0, 0.0]
    shares[first], shares[middle], shares[last] = (1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)
    return shares
