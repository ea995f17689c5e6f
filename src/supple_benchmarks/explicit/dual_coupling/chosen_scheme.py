"""Choice of the scheme for two coupled sides, and of the number of short steps in a long one."""

from __future__ import annotations

import numpy as np

from supple.errors import ModelError
from supple_benchmarks.explicit.dual_coupling.multi_time_step import GravouilCombescure, PrakashHjelmstad
from supple_benchmarks.explicit.dual_coupling.sides import Coupling

__all__ = ["chosen_scheme"]


def chosen_scheme(
    coupling: Coupling, h: float, *, linear: bool, safety: float = 0.9, largest_ratio: int = 50
) -> GravouilCombescure | PrakashHjelmstad:
    """The scheme for linear or nonlinear elements, with the largest stable ratio of long to short step.

        ratio = floor(safety 2 / (omega_max h)),     h <= 2 / omega_max(M_2, K_2)

    The first omega_max is the highest frequency of the modes. The ratio is at least 1 and at most
    `largest_ratio`. With multipliers each side has its own stability limit. Linear elements get
    `PrakashHjelmstad`, which loses the least energy and needs two passes over the short steps; nonlinear
    elements get `GravouilCombescure`, which needs one pass.

    h : step of the elements, s;   linear : whether the force of the elements is linear
    safety : fraction of the step limit of the modes that the long step may use
    largest_ratio : largest ratio of a long step to a short one
    Raises ModelError for a step above the stability limit of the elements, or above `safety` times that of
    the modes.
    """
    side = coupling.elements
    root = 1 / np.sqrt(side.mass)
    stiffness = side.stiffness @ np.eye(len(root))  # dense, also from a sparse matrix
    own = float(2 / np.sqrt(np.linalg.eigvalsh(root[:, None] * stiffness * root)[-1]))
    highest = float(coupling.modal.frequencies.max())
    long = safety * 2 / highest if highest > 0 else np.inf
    for limit, what in (
        (own, "the stability limit of the elements"),
        (long, f"{safety:g} of the stability limit of the modes"),
    ):
        if not 0 < h <= limit:
            raise ModelError(
                f"the step {h:g} s of the elements must be positive and at most {limit:.4g} s, {what}"
            )
    ratio = int(min(max(long / h, 1), largest_ratio))
    return PrakashHjelmstad(ratio) if linear else GravouilCombescure(ratio)
