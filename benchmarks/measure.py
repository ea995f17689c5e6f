"""Measurement of time and memory of steps, and output of the results.

Times are medians of some repetitions, processor time and wall time in seconds: the two differ if the machine
has other load, or if a library uses several threads. Memory is the peak memory added by the step, and the
size of the process at that time, in MiB.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any

from supple.storage import write_json
from supple_benchmarks.computer import describe_computer

RESULTS = Path(__file__).parent / "results"
STATUS, CLEAR = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def measured(step: Callable[[], Any], repeats: int = 5) -> tuple[dict[str, Any], Any]:
    """Processor and wall seconds and peak memory of a step, and its last outcome."""
    processor, wall, outcome = [], [], None
    before = _restart_peak()
    for _ in range(repeats):
        outcome = None  # released first, so that the peak contains one outcome only
        began, began_wall = process_time(), perf_counter()
        outcome = step()
        processor.append(process_time() - began)
        wall.append(perf_counter() - began_wall)
    peak = _resident("VmHWM")
    grown = None if before is None or peak is None else peak - before
    cost = {"cpu s": median(processor), "wall s": median(wall), "peak MB": grown, "process MB": peak}
    return cost, outcome


@dataclass
class Steps:
    """Measured steps of a benchmark, as rows.

    repeats : default number of repetitions of a step
    announce : called with every finished row
    """

    repeats: int = 5
    announce: Callable[[dict[str, Any]], None] | None = None
    rows: list[dict[str, Any]] = field(default_factory=list)

    def measure(
        self, step: str, work: Callable[[], Any], *, repeats: int | None = None, **beside: float
    ) -> Any:
        """Run a step, append a row with its cost and the values `beside`, and return the outcome."""
        cost, outcome = measured(work, repeats or self.repeats)
        self.rows.append({"step": step, **cost, **beside})
        if self.announce is not None:
            self.announce(self.rows[-1])
        return outcome


def _restart_peak() -> float | None:
    """Reset the peak memory (Linux only); returns the present size, MiB."""
    if not CLEAR.exists():
        return None
    CLEAR.write_text("5", encoding="ascii")
    return _resident("VmRSS")


def _resident(entry: str) -> float | None:
    if not STATUS.exists():
        return None
    for line in STATUS.read_text(encoding="ascii").splitlines():
        if line.startswith(entry):
            return int(line.split()[1]) / 1024
    return None


def keep(name: str, rows: list[dict[str, Any]], file: Path | None = None, **beside: Any) -> None:
    """Print the rows as a table and write them with a description of the computer; default: to RESULTS."""
    print(table_of(rows))
    content = {"rows": rows, "machine": describe_computer() | beside}
    path = write_json(file or RESULTS / f"{name}.json", content)
    print(f"written to {path}")


def table_of(rows: list[dict[str, Any]]) -> str:
    """The rows as a text table with the keys as heads."""
    heads = list(dict.fromkeys(key for row in rows for key in row))
    table = [heads] + [[_text(row.get(head)) for head in heads] for row in rows]
    widths = [max(len(line[i]) for line in table) for i in range(len(heads))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in table
    )


def _text(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.3g}" if isinstance(value, float) else str(value)
