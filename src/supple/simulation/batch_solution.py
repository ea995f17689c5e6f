"""The result of a batch of load cases."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from supple.errors import ConvergenceError
from supple.integrate import Solution

__all__ = ["BatchSolution"]


@dataclass(frozen=True)
class BatchSolution:
    """The result of a batch: a solution per case, and the causes of failures."""

    solutions: tuple[Solution, ...]
    """One per case, in order; for a failed case up to the last output time reached."""
    failures: Mapping[int, str]
    """Case number to message; empty when every case ran to the end."""
    seconds: float
    """Wall time of all cases after compilation."""
    compile_seconds: float

    def check(self) -> BatchSolution:
        """The batch itself; ConvergenceError, with the failed cases, if any failed."""
        if self.failures:
            first = next(iter(self.failures))
            raise ConvergenceError(
                f"{len(self.failures)} of {len(self.solutions)} cases failed "
                f"({', '.join(map(str, self.failures))}); case {first}: {self.failures[first]}"
            )
        return self
