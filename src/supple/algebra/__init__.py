"""Numerical algebra: rotations, sparse factors, constrained solves, eigenpairs, orthonormal bases."""

from supple.algebra.constrained_solve import *
from supple.algebra.eigen import *
from supple.algebra.growing_modes import *
from supple.algebra.orthonormalize import *
from supple.algebra.read_only import *
from supple.algebra.sparse_factor import *
from supple.algebra.tall_matrix import *
