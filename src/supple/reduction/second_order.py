"""Reduced bodies whose strain energy is truncated to second order in some coordinates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from supple.reduction.reduced_body import ReducedBody


def second_order_beyond(body: ReducedBody, leading: int) -> ReducedBody:
    """The body without the energy of third and fourth order in d, the coordinates after the first `leading`.

        U(a, d) ~ U(a, 0) + dU/dd(a, 0) d + d . d2U/dd2(a, 0) d / 2,   gamma = (a, d)

    All orders in `a` remain; the damping is truncated in the same way; a linear body is unchanged. If d is
    small, such as the motion outside a basis, the relative error of d due to the truncation is of order d.
    With 13 of 49 coordinates in `a`, seven tenths of the quartic tensor are zero.

    leading : number of coordinates a
    """
    if body.cubic is None:
        return body
    beyond = np.arange(body.r) >= leading
    first, second = np.triu_indices(body.r)
    in_pair = beyond[first].astype(int) + beyond[second]
    present = {"cubic": in_pair[:, None] + beyond <= 2, "quartic": in_pair[:, None] + in_pair <= 2}
    tensors = {
        name: np.where(present[name.removeprefix("damping_")], own, 0.0)
        for name in ("cubic", "quartic", "damping_cubic", "damping_quartic")
        if (own := getattr(body, name)) is not None
    }
    return replace(body, **tensors)
