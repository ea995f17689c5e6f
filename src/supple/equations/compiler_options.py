"""Options of XLA for programs of hundreds of tiny operations instead of a few large ones."""

from __future__ import annotations

from typing import Any

import jax

_HAS_OLDER_GENERATOR = jax.__version_info__ < (0, 11)
"""JAX raises an error for an unknown option."""

MARCHING: dict[str, Any] = {"xla_cpu_use_fusion_emitters": False} if _HAS_OLDER_GENERATOR else {}
"""For programs that run thousands of times: the older code generator compiles twice as fast to equal code."""
STARTING: dict[str, Any] = MARCHING | {"xla_backend_optimization_level": 0}
"""For programs that run a few times per simulation: fast compilation, slower code."""
