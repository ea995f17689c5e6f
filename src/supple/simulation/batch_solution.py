"""What a batch of load cases came to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from supple.errors import ConvergenceError
from supple.integrate import Solution

__all__ = ["BatchSolution"]


@dataclass(frozen=True)
class BatchSolution:
    """What a batch came to: a solution per case, and why where a case failed."""

    solutions: tuple[Solution, ...]
    """One per case, in order; a failed case's ends at the last output time it reached."""
    failures: Mapping[int, str]
    """Case number to message; empty when every case ran to the end."""
    seconds: float
    """Wall time of all cases after compilation."""
    compile_seconds: float

    def check(self) -> BatchSolution:
        """The batch itself, or ConvergenceError naming the failed cases."""
        if self.failures:
            first = next(iter(self.failures))
            raise ConvergenceError(
                f"{len(self.failures)} of {len(self.solutions)} cases failed "
                f"({', '.join(map(str, self.failures))}); case {first}: {self.failures[first]}"
            )
        return self
