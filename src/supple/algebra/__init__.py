"""Arrays in, arrays out: rotations, sparse factors, constrained solves, eigenpairs, orthonormal bases."""

from supple.algebra.constrained_solve import (
    ConstrainedFactor,
    GroundedFactor,
    constrained_factor,
    grounded_factor,
)
from supple.algebra.eigen import Eigenpairs, count_below, lowest_modes
from supple.algebra.growing_modes import GrowingModes, RitzModes
from supple.algebra.orthonormalize import OrthonormalBasis, mass_orthonormalize
from supple.algebra.read_only import read_only
from supple.algebra.sparse_factor import (
    DirectSolver,
    Inertia,
    Rslab,
    SparseFactor,
    SuperLU,
    factorize_general,
    factorize_symmetric,
    installed_solver,
)
from supple.algebra.tall_matrix import TallMatrix

__all__ = [
    "ConstrainedFactor",
    "DirectSolver",
    "Eigenpairs",
    "GroundedFactor",
    "GrowingModes",
    "Inertia",
    "OrthonormalBasis",
    "RitzModes",
    "Rslab",
    "SparseFactor",
    "SuperLU",
    "TallMatrix",
    "constrained_factor",
    "count_below",
    "factorize_general",
    "factorize_symmetric",
    "grounded_factor",
    "installed_solver",
    "lowest_modes",
    "mass_orthonormalize",
    "read_only",
]
