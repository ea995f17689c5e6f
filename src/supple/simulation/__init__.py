"""From a machine to its motion: one case, many cases, runs that live on disk."""

from supple.simulation.assembly import AssembledMachine, assemble
from supple.simulation.batch import simulate_batch
from supple.simulation.batch_solution import BatchSolution
from supple.simulation.engines import register_engine
from supple.simulation.equilibrium import Equilibrium, equilibrium
from supple.simulation.kept_bodies import (
    keep_bodies,
    keep_body,
    reduced_bodies,
    with_kept_bodies,
)
from supple.simulation.kept_run import simulate_kept
from supple.simulation.recorded_run import (
    begin_recorded,
    continue_recorded,
    simulate_recorded,
)
from supple.simulation.simulate import (
    simulate,
)

__all__ = [
    "AssembledMachine",
    "BatchSolution",
    "Equilibrium",
    "assemble",
    "begin_recorded",
    "continue_recorded",
    "equilibrium",
    "keep_bodies",
    "keep_body",
    "reduced_bodies",
    "register_engine",
    "simulate",
    "simulate_batch",
    "simulate_kept",
    "simulate_recorded",
    "with_kept_bodies",
]
