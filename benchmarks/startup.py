"""Cost of a start: import, first run of a machine, another duration, one more coordinate, a case.

Run with one thread: OMP_NUM_THREADS=1 taskset -c 0 python benchmarks/startup.py [--quick] [--json FILE]
Every row is a separate process, first with an empty program cache (cold), then with the programs of that
process (warm). Seconds are processor time; programs are those compiled in that time.
Machines: a chain of two rigid rods; a swinging nonlinear flexible rod with ten and with eleven coordinates;
the pendulum of the examples by the command line, pictures included. `--quick` leaves out the flexible rod.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import numpy as np
from measure import RESULTS, table_of

from supple.storage import write_json
from supple_benchmarks.computer import describe_computer

HERE = Path(__file__).parent
CASE = HERE.parent / "examples" / "pendulum.toml"
STEP = 1e-3


class Stopwatch:
    """Processor seconds and number of compiled programs of each part."""

    def __init__(self, began: float) -> None:
        self.parts: dict[str, Any] = {}
        self._began = began
        self._built = 0

    def listen(self) -> None:
        """Start to count compiled programs; JAX must have been imported."""
        import jax

        jax.monitoring.register_event_duration_secs_listener(self._count)

    def _count(self, event: str, duration_secs: float, **_: object) -> None:  # noqa: ARG002
        self._built += event == "/jax/core/compile/backend_compile_duration"

    def lap(self, part: str) -> None:
        """Record the part that ends here."""
        now = process_time()
        self.parts |= {f"{part}, s": now - self._began, f"{part}, programs": self._built}
        self._began, self._built = process_time(), 0


def rigid_machine(_: int) -> Any:
    """Two rods on ball joints."""
    from chain import chain, rigid_rod

    return chain(rigid_rod(), 2)


def flexible_machine(more: int) -> Any:
    """A slender block on a joint at one end, with nonlinear stiffness and 10 + `more` coordinates."""
    from supple.body import AveragingInterface, MeanAxisFrame, flexible_body
    from supple.fem import Isotropic, solid_model
    from supple.machine import GROUND, At, Ball, Placed, System
    from supple.mesh import CellType, block
    from supple.reduction import CraigBampton, NoLoads, reduce

    mesh = block(1.0, 0.05, 0.05, 6, 1, 1, CellType.HEXA20)
    steel = Isotropic(youngs_modulus=2.1e11, poissons_ratio=0.3, density=7850.0)
    near = AveragingInterface("near", (mesh.nodes[:, 0] < 1e-9).nonzero()[0])
    body = flexible_body("rod", solid_model(mesh, steel), [near])
    reduced = reduce(body, MeanAxisFrame(), CraigBampton(n_modes=4 + more), loads=NoLoads)
    return System(
        [Placed(reduced)],
        [Ball(first=GROUND, second=At("rod", "near"), name="ball")],
        gravity=np.array([0.0, 0.0, -9.81]),
    )


MACHINES = {"rigid": rigid_machine, "flexible": flexible_machine}


def measure_machine(kind: str) -> dict[str, Any]:
    """Import, first run, another duration and a coordinate more, in this process."""
    watch = Stopwatch(process_time())
    from supple.integrate import FixedStep, Run
    from supple.simulation import simulate

    watch.lap("import")
    watch.listen()
    machine = MACHINES[kind](0)
    larger = MACHINES[kind](1) if kind == "flexible" else None
    watch.lap("bodies")
    simulate(machine, Run(0.1, 0.01, step=FixedStep(STEP)))
    watch.lap("first run")
    simulate(machine, Run(0.35, 0.01, step=FixedStep(STEP)))
    watch.lap("another duration")
    if larger is not None:
        simulate(larger, Run(0.1, 0.01, step=FixedStep(STEP)))
        watch.lap("a coordinate more")
    return watch.parts


def measure_case(folder: str) -> dict[str, Any]:
    """`supple run` of a small case, in this process."""
    watch = Stopwatch(process_time())
    from supple.cli.main import app

    watch.lap("import")
    watch.listen()
    app(["run", str(CASE), "--output", folder], standalone_mode=False)
    watch.lap("case")
    return watch.parts


def in_new_process(kind: str, programs: str) -> dict[str, Any]:
    """The parts measured in a new process with a given program cache."""
    with TemporaryDirectory() as results:
        shown = subprocess.run(
            [sys.executable, __file__, "--measure", kind, "--results", f"{results}/run"],
            env=os.environ | {"JAX_COMPILATION_CACHE_DIR": programs},
            capture_output=True,
            text=True,
            check=True,
        )
    return json.loads(shown.stdout.splitlines()[-1])


def main() -> None:
    arguments = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    arguments.add_argument("--quick", action="store_true", help="without the flexible machine")
    arguments.add_argument("--json", type=Path, default=RESULTS / "startup.json")
    arguments.add_argument("--measure", help=argparse.SUPPRESS)
    arguments.add_argument("--results", help=argparse.SUPPRESS)
    given = arguments.parse_args()
    if given.measure:  # the process of its own
        parts = measure_case(given.results) if given.measure == "case" else measure_machine(given.measure)
        print(json.dumps(parts))
        return
    rows = []
    for kind in ("rigid", "case") if given.quick else ("rigid", "flexible", "case"):
        with TemporaryDirectory() as programs:
            rows += [
                {"machine": kind, "programs kept": state, **in_new_process(kind, programs)}
                for state in ("cold", "warm")
            ]
    print(table_of(rows))
    print(f"written to {write_json(given.json, {'rows': rows, 'machine': describe_computer()})}")


if __name__ == "__main__":
    main()
