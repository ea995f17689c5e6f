"""Stress and plastic strain at the nodes of the parts of an explicit run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.explicit import ExplicitShell, ExplicitSubdomain, FourPointMotion, ModalSubdomain, NodalMotion
from supple.explicit.elements import SolidPoints
from supple.explicit.explicit_shell import ShellElements
from supple.explicit.modal_stress import modal_von_mises, stress_of_modes

__all__ = ["element_means", "nodal_von_mises"]

FloatArray = NDArray[np.float64]


def element_means(
    subdomain: ExplicitSubdomain | ExplicitShell, values: FloatArray, alive: FloatArray
) -> FloatArray:
    """Mean (t, N) at each node of values (t, E) over the elements there that are left; zero without any."""
    at_node = sparse.vstack(
        [
            sparse.csr_array(
                (
                    np.ones(points.nodes.size),
                    (np.repeat(np.arange(len(points.nodes)), points.nodes.shape[1]), points.nodes.ravel()),
                ),
                shape=(len(points.nodes), len(subdomain.nodes)),
            )
            for points in _elements(subdomain)
        ],
        format="csr",
    )
    return ((values * alive) @ at_node) / np.maximum(alive @ at_node, 1.0)


def _elements(subdomain: ExplicitSubdomain | ExplicitShell) -> Sequence[SolidPoints | ShellElements]:
    return subdomain.elements if isinstance(subdomain, ExplicitShell) else subdomain.points


def nodal_von_mises(
    subdomain: ModalSubdomain | ExplicitSubdomain | ExplicitShell, motion: FourPointMotion | NodalMotion
) -> FloatArray:
    """Von Mises stress (t, N) of a part, Pa."""
    if isinstance(subdomain, ModalSubdomain):
        assert isinstance(motion, FourPointMotion)
        return modal_von_mises(stress_of_modes(subdomain), motion.coordinates)
    assert isinstance(motion, NodalMotion)
    return element_means(subdomain, motion.von_mises, motion.alive)
