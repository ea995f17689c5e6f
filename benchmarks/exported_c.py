"""Machines as C compared with the compiled march: differences and time per step.

Run with one thread: OMP_NUM_THREADS=1 python benchmarks/exported_c.py [--blade RESULT.h5] [--only NAME ..]
Each machine has a separate process, which is ended after LIMIT seconds; a machine that fails is listed with
the cause.
Machines: those of `tests/fixtures/exported_machines.py`, the slider-crank of the examples, and the blade of
the examples from the result of its run (`supple run examples/blade.toml`).

Differences over 1000 steps are relative to the largest value of a quantity in the machine. Two differences
due to rounding alone are listed for comparison: the C code with and without fused multiplications (-O3
-march=native); and, for the machines in XLA_LEVELS, the march compiled by XLA with and without all
optimisations. The march is the program of long runs.
Microseconds are processor time: for C, mean and maximum over 1000 steps of the exported test; for the march,
the mean of 1000 steps in one call.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import jax
import numpy as np
from measure import RESULTS, table_of

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

from fixtures import exported_machines  # noqa: E402
from fixtures.compiled_c import MachineInC  # noqa: E402

from supple.cases import read_case  # noqa: E402
from supple.cases.result_machine import result_machine  # noqa: E402
from supple.cases.static_case import starting_system  # noqa: E402
from supple.cli.export_machine import machine_outputs  # noqa: E402
from supple.export.c.machine_source import write_machine  # noqa: E402
from supple.methods.floating.compiled import programs  # noqa: E402
from supple.simulation.engines import engine_for  # noqa: E402
from supple.stepping import StepProgram, step_program  # noqa: E402
from supple.storage import write_json  # noqa: E402
from supple_benchmarks.computer import describe_computer  # noqa: E402

STEPS = 1000
LIMIT = 400
"""Seconds for one machine."""
GROUPS = {"places": ("length", "angle"), "rates": ("velocity", "angular velocity")}
"""Kinds of quantities that are compared together; accelerations and forces form the last group."""
LEVELS = {"O2": "-std=c99 -O2 -ffp-contract=off", "O3 native": "-std=c99 -O3 -march=native"}
XLA_LEVELS = ("driven_pair",)

Machine = tuple[Any, Any, Any, Any]


def of_case(case: Any, system: Any) -> Machine:
    """The machine of a case, as exported by the command."""
    return system, case.run, machine_outputs(case, system), {}


def slider_crank_example() -> Machine:
    """The machine of `examples/slider_crank.toml`."""
    case = read_case(HERE.parent / "examples" / "slider_crank.toml")
    return of_case(case, starting_system(case))


def machines(blade: Path | None) -> dict[str, Callable[[], Machine]]:
    """Functions that create the machines, by name."""
    found = {each.__name__: each for each in (*exported_machines.EVERY, exported_machines.joined_line)} | {
        "example slider-crank": slider_crank_example
    }
    if blade is not None:

        def example_blade() -> Machine:
            result = result_machine(blade, HERE.parent / "examples" / "blade.toml")
            return of_case(result.case, starting_system(result.case, result.system))

        found["example blade"] = example_blade
    return found


def driven(program: StepProgram, k: int) -> np.ndarray:
    """Inputs (i,) of step k."""
    return 0.3 * np.sin(0.01 * k) * np.ones(len(program.inputs.variables))


def marched(program: StepProgram, compiled: Any) -> np.ndarray:
    """Outputs (STEPS, o)."""
    now, rows, start = program.start, [], float(program.start.state.time)
    for k in range(1, STEPS + 1):
        now = compiled(now._replace(input=driven(program, k)), np.float64(start + program.size * k))
        rows.append(np.asarray(now.output))
    assert not now.state.failed
    return np.array(rows)


def in_c(program: StepProgram, folder: Path, level: str) -> tuple[np.ndarray, float, float]:
    """Outputs (STEPS, o) of the C code; mean and largest time per step in the exported test, us."""
    subprocess.run(["make", "clean"], cwd=folder, check=True, capture_output=True)
    make = ["make", "test", f"CFLAGS={LEVELS[level]} -fPIC"]
    done = subprocess.run(make, cwd=folder, check=True, capture_output=True, text=True)
    found = re.search(r"([\d.]+) us each, the slowest ([\d.]+) us", done.stdout)
    assert found
    own = folder / level.replace(" ", "")
    own.mkdir()
    for name in ("machine.o", "machine.h"):
        shutil.copy(folder / name, own)
    machine, rows, start = MachineInC(own, compiled="machine.o"), [], float(program.start.state.time)
    for k in range(1, STEPS + 1):
        assert machine.advance(start + program.size * k, driven(program, k))
        rows.append(machine.output)
    return np.array(rows), float(found[1]), float(found[2])


def differences(program: StepProgram, one: np.ndarray, other: np.ndarray, of: str) -> dict[str, float]:
    """Largest relative difference in each group of quantities."""
    kinds = np.array([each.description.partition(",")[0] for each in program.outputs.variables])
    largest: dict[str, float] = {}
    for kind in dict.fromkeys(kinds):
        group = next((name for name, own in GROUPS.items() if kind in own), "accelerations, forces")
        here = kinds == kind
        size = np.abs(one[:, here]).max()
        relative = np.abs(one - other)[:, here].max() / size if size else 0.0
        largest[f"{of}: {group}"] = max(largest.get(f"{of}: {group}", 0.0), float(relative))
    return largest


def microseconds_of_march(machine: Machine, program: StepProgram) -> float:
    """Microseconds per step of `simulate`, after compilation."""
    system, run, _, _ = machine
    programs._QUICK = 0  # as for long runs, which do not use the program that compiles quickly
    engine = engine_for(system, run)
    state = engine.start(run.start)
    times = run.start + program.size * np.arange(1, STEPS + 1)
    times = times[: len(run.times) - 1]
    state = engine.march(state, times).last
    began = process_time()
    engine.march(state, times + times[-1] - run.start)
    return (process_time() - began) / len(times) * 1e6


def row(name: str, make: Callable[[], Machine]) -> dict[str, Any]:
    """The row of a machine with all measurements."""
    machine = make()
    system, run, sensors, inputs = machine
    program = step_program(system, run, sensors, inputs)
    with TemporaryDirectory() as place:
        folder = Path(place)
        began = process_time()
        write_machine(folder, program, name)
        written = process_time() - began
        lines = (folder / "machine.c").read_text().count("\n")
        exact = marched(program, program.compiled)
        found = {"velocities": program.march.n_velocities, "joint equations": program.n_equations}
        found |= {"lines of C": lines, "writing, s": written}
        own = {level: in_c(program, folder, level) for level in LEVELS}
    plain, fused = (rows for rows, *_ in own.values())
    found |= differences(program, exact, plain, "C") | differences(program, plain, fused, "C, fused")
    if name in XLA_LEVELS:
        other = jax.jit(program.advanced).lower(program.start, np.float64(0.0)).compile()
        found |= differences(program, exact, marched(program, other), "march, XLA")
    for level, (_, mean, slowest) in own.items():
        found[f"{level}, us"], found[f"{level}, slowest us"] = mean, slowest
    if not inputs:
        found["march, us"] = microseconds_of_march(machine, program)
    return found


def measured(name: str, blade: Path | None, target: Path) -> dict[str, Any]:
    """The row of a machine, measured in another process; in case of failure, a row with the cause."""
    command = [sys.executable, __file__, "--one", name, "--json", str(target)]
    command += [] if blade is None else ["--blade", str(blade)]
    # A separate session: its compiler is ended with it, and does not run during the next machine.
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        try:
            errors = process.communicate(timeout=LIMIT)[1]
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return {"failed": f"not within {LIMIT} s"}
    if process.returncode:
        return {"failed": (errors.strip().splitlines() or ["no message"])[-1]}
    found: dict[str, Any] = json.loads(target.read_text())
    if "march, us" in found:
        found["march over C"] = found["march, us"] / min(found[f"{level}, us"] for level in LEVELS)
    return found


def main() -> None:
    """Measure, print and store the rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--blade", type=Path)
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--one", help="measure this machine in this process, and write only its row")
    parser.add_argument("--json", type=Path, default=RESULTS / "exported_c.json")
    given = parser.parse_args()
    every = machines(given.blade)
    if given.one:
        write_json(given.json, row(given.one, every[given.one]))
        return
    rows = {}
    with TemporaryDirectory() as place:
        for name in every:
            if given.only and name not in given.only:
                continue
            rows[name] = measured(name, given.blade, Path(place) / "row.json")
            print(name, rows[name], flush=True)
            write_json(given.json, {"computer": describe_computer(), "machines": rows})
    print(table_of([{"machine": name, **own} for name, own in rows.items()]))


if __name__ == "__main__":
    main()
