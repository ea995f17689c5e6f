"""Speed of explicit elements: million element-steps per second of processor time."""

from __future__ import annotations

from time import process_time

import numpy as np

from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, Run, run
from supple.machine import (
    Placed,
    System,
)
from supple.mesh import CellType, block
from supple.methods.explicit import (
    BulkViscosity,
    ExplicitEngine,
    J2Plasticity,
    LinearHardening,
    StVenantKirchhoff,
    explicit_subdomain,
)
from supple_benchmarks.table import Row

__all__ = ["throughput"]

STEEL = Isotropic(210e9, 0.3, 7850.0)


def throughput(quick: bool) -> list[Row]:
    """Throughput of HEXA8 and TETRA4, elastic and plastic, without bulk viscosity: one row for each pair."""
    n = 10 if quick else 20
    rows = []
    for kind in (CellType.HEXA8, CellType.TETRA4):
        model = solid_model(block(1, 1, 1, n, n, n, kind), STEEL)
        count = len(model.mesh.cells[kind])
        for law in (StVenantKirchhoff(STEEL), J2Plasticity(STEEL, LinearHardening(300e6, 1e9))):
            part = explicit_subdomain(model, law, bulk_viscosity=BulkViscosity(0.0, 0.0))
            steps, h = (100, 0.5 * part.step_limit)
            span = Run(2 * steps * h, steps * h, FixedStep(h))
            engine = ExplicitEngine(
                System([Placed(part, velocity=np.array([1.0, 0.0, 0.0]))]),
                span,
            )
            run(engine, span.times)
            began = process_time()
            run(engine, span.times)
            seconds = process_time() - began
            rows.append(
                {
                    "element": f"{kind.name.lower()} {type(law).__name__}",
                    "million_element_steps_per_s": 2 * steps * count / seconds / 1e6,
                }
            )
    return rows
