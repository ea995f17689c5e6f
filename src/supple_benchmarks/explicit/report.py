"""The tables of the explicit benchmark."""

from __future__ import annotations

from supple_benchmarks.table import Report, Table, table_of

__all__ = ["tables"]

_TITLES = {
    "free_flight": "Free flight, 20 revolutions; deceleration by the published scheme over 2 pi Omega h each",
    "step_limit": "Step over limit of free modes: stable, unstable; true limit over (27) for clamped modes",
    "dual_against_primal": "Multipliers against elimination: difference of the final displacements, relative",
    "multi_time_step": "Several time steps compared with one",
    "taylor_bar": "Taylor bar, copper, 227 m/s (published: 21.4 to 21.7 mm, 6.9 to 7.3 mm)",
    "crash": "Crushed nose with a modal rest, compared with all elements",
    "throughput": "Throughput on one core",
}


def tables(report: Report) -> list[Table]:
    """One table for each study in `_TITLES` that the report contains."""
    found = []
    for key, title in _TITLES.items():
        if key in report:
            own = report[key]
            rows = own if isinstance(own, list) else [own if isinstance(own, dict) else {"difference": own}]
            found.append(table_of(title, rows))
    return found
