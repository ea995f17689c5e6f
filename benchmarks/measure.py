"""Process time and memory of a step, and where the numbers go."""

from __future__ import annotations

import resource
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from supple.benchmark.machine import describe_machine
from supple.results import write_json

RESULTS = Path(__file__).parent / "results"


def timed(step: Callable[[], Any], repeats: int = 3) -> tuple[float, Any]:
    """Least processor seconds of some repeats, and the last outcome."""
    best, outcome = float("inf"), None
    for _ in range(repeats):
        began = process_time()
        outcome = step()
        best = min(best, process_time() - began)
    return best, outcome


def wall(step: Callable[[], Any]) -> tuple[float, Any]:
    """Wall seconds of one call, and its outcome."""
    began = perf_counter()
    outcome = step()
    return perf_counter() - began, outcome


def peak_megabytes() -> float:
    """Largest resident size of this process so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def keep(name: str, rows: list[dict[str, Any]]) -> None:
    """Print the rows as a table and write them with the machine's description."""
    heads = list(dict.fromkeys(key for row in rows for key in row))
    table = [heads] + [[_text(row.get(head, "")) for head in heads] for row in rows]
    widths = [max(len(line[i]) for line in table) for i in range(len(heads))]
    for line in table:
        print("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip())
    RESULTS.mkdir(exist_ok=True)
    write_json(RESULTS / f"{name}.json", {"rows": rows, "machine": describe_machine()})


def _text(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
