"""Where the nodes of a sub-domain are: the only way from its motion to space."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.explicit.explicit_shell import ExplicitShell
from supple.explicit.explicit_subdomain import ExplicitSubdomain
from supple.explicit.modal_subdomain import ModalSubdomain
from supple.explicit.motions import FourPointMotion, NodalMotion

__all__ = ["part_positions"]


def part_positions(
    subdomain: ModalSubdomain | ExplicitSubdomain | ExplicitShell,
    motion: FourPointMotion | NodalMotion,
    nodes: ArrayLike | slice = slice(None),
) -> NDArray[np.float64]:
    """Positions (t, n, 3) of some nodes, or all.

    x = sum_a w_a x_a + P Phi y     of a modal one: [Radioss] (5), never integrated
    """
    own = nodes if isinstance(nodes, slice) else np.asarray(nodes)
    if not isinstance(subdomain, ModalSubdomain):
        assert isinstance(motion, NodalMotion)
        return motion.nodes[:, own]
    assert isinstance(motion, FourPointMotion)
    weights = subdomain.points.weights(subdomain.body.nodes)[own]
    P = (motion.points[:, 1:] - motion.points[:, :1]).swapaxes(1, 2)
    local = np.einsum("nik,tk->tni", subdomain.shapes[own], motion.coordinates, optimize=True)
    return weights @ motion.points + local @ P.swapaxes(1, 2)
