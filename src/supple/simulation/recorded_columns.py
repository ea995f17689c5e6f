"""Which columns the coordinates in a result file multiply, so that they are never taken for others."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from supple.errors import ResultFileError
from supple.machine import System
from supple.reduction import ReducedBody
from supple.storage.result_reader import Metadata, ResultHeader

KEY = "columns"

# Of the largest measure: round-off moves columns by far less, another sign or order by far more.
SAME = 1e-5


def columns_of(system: System) -> Metadata:
    """Metadata that tell the bases of a system apart: each column's product with one random vector.

    Vibrations have no sign of their own, and those of like frequency no directions: round-off decides, and
    another number of threads is enough to change it. The motion on disk would then mean another one.
    """
    measures = {name: _measures(body).tolist() for name, body in system.bodies_of(ReducedBody).items()}
    return {KEY: json.dumps(measures)} if measures else {}


def check_columns(header: ResultHeader, system: System, path: Path | str) -> None:
    """ResultFileError when a system's reduced bodies move by other columns than those of a result file."""
    recorded = json.loads(str(header.metadata.get(KEY, "{}")))
    for name, body in system.bodies_of(ReducedBody).items():
        if name not in recorded:
            continue
        then, now = np.array(recorded[name]), _measures(body)
        if then.shape != now.shape or np.abs(then - now).max() > SAME * np.abs(then).max():
            raise ResultFileError(
                f"{path} holds a motion of body '{name}' on {then.size} columns that are not those of "
                f"the body given, which has {now.size}. Reducing again can change their signs: keep the "
                "reduced body beside its motion (write_reduced_body) and continue with it, or start anew"
            )


def _measures(body: ReducedBody) -> np.ndarray:
    probe = np.random.default_rng(0).standard_normal(len(body.nodal_basis))
    return body.nodal_basis.T @ probe
