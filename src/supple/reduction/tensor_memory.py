"""Memory needed to build the tensors of a nonlinear body, estimated beforehand."""

from __future__ import annotations

from supple.algebra.available_memory import available_memory, require_memory
from supple.body import FlexibleBody

_MATRICES = 16
"""Pair matrices in memory at one time in a reduction, with margin; measured: 11 plain, 14 condensed."""
_MATRICES_OF_DAMPING = 4


def tensor_memory(r: int, *, strain_rate_damping: bool = False) -> int:
    """Largest memory, in bytes, for building the tensors of r coordinates; grows with r⁴."""
    n2 = r * (r + 1) // 2
    return 8 * n2**2 * (_MATRICES + _MATRICES_OF_DAMPING * strain_rate_damping)


def largest_fitting(memory: float, *, strain_rate_damping: bool = False) -> int:
    """Largest number of coordinates whose tensors fit in the given memory (bytes)."""
    r = int((memory / tensor_memory(1, strain_rate_damping=strain_rate_damping) * 4) ** 0.25) + 1
    while r and tensor_memory(r, strain_rate_damping=strain_rate_damping) > memory:
        r -= 1
    return r


def require_tensor_memory(
    body: FlexibleBody, r: int, *, strain_rate_damping: bool = False, named: str = "columns"
) -> None:
    """MemoryShortageError where the tensors of r coordinates of a nonlinear body do not fit in memory.

    named : noun for the r columns in the message, as the user sets their number
    """
    if body.is_linear:
        return
    left = available_memory()
    fits = r if left is None else largest_fitting(left, strain_rate_damping=strain_rate_damping)
    require_memory(
        tensor_memory(r, strain_rate_damping=strain_rate_damping),
        f"building the tensors of body '{body.name}' with {r} coordinates",
        f"take at most {fits} {named}, or the body without its nonlinear strains (body.linearized(), "
        "`linear = true` in a case file), which has no tensors",
    )
