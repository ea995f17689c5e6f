"""From a machine to its motion: one case, many cases, runs that live on disk."""

from supple.simulation.batch import (
    BatchSolution,
    simulate_batch,
)
from supple.simulation.recorded_run import (
    begin_recorded,
    continue_recorded,
    simulate_recorded,
)
from supple.simulation.simulate import (
    simulate,
)

__all__ = [
    "BatchSolution",
    "begin_recorded",
    "continue_recorded",
    "simulate",
    "simulate_batch",
    "simulate_recorded",
]
