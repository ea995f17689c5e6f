"""Options of XLA: these programs are hundreds of tiny operations, not a few large ones."""

from __future__ import annotations

from typing import Any

__all__ = ["MARCHING", "STARTING"]

MARCHING: dict[str, Any] = {"xla_cpu_use_fusion_emitters": False}
"""For what runs thousands of times: the older code generator compiles twice as fast to code as good."""
STARTING: dict[str, Any] = MARCHING | {"xla_backend_optimization_level": 0}
"""For what runs a few times per simulation: compiled quickly rather than well."""
