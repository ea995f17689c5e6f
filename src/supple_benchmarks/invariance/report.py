"""The tables of the invariance benchmark."""

from __future__ import annotations

import numpy as np

from supple_benchmarks.table import Report, Table, table_of

__all__ = ["tables"]

_TITLES = {
    "locking": "Equilibria with a basis of fixed size, against the full body in the same frame",
    "tie": "A box with a rotated rigid root",
    "damping": "A damped box in two frames: difference relative to its deflection",
    "curvature": "A clamped strip against the elastica, frame on the root",
    "turned_element": "The same strip in frames rotated relative to its root",
    "split": "A clamped strip against the elastica, split into k bodies",
}


def tables(report: Report) -> list[Table]:
    """One table for each study of the complete report."""
    found = [table_of(title, report[key]) for key, title in _TITLES.items() if key in report]
    found.append(table_of("Lateral buckling, load over theory", [report["lateral_buckling"]]))
    found.append(table_of("A swinging box, against a geometrically exact beam", [report["box_vibration"]]))
    blade = report["blade_static"]
    fixed, mean = (np.array(blade[frame]) for frame in ("nodal-fixed", "mean-axis"))
    apart = float(np.linalg.norm(mean - fixed) / np.linalg.norm(fixed))
    rows = [
        {"frame": name, **dict(zip("xyz", tip, strict=True)), "apart": apart} for name, tip in blade.items()
    ]
    found.append(table_of("The blade's tip at rest under its mean wind, m", rows))
    return found
