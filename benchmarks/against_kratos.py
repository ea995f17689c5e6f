"""Explicit solid elements of St. Venant-Kirchhoff's law, in supple and in Kratos, alternating on one core.

A free block of steel starts undeformed with a rotation that stretches it, integrated by central differences
with the same mesh, lumped masses, step and number of steps in both codes, in double precision. The results
are elements times steps per second of processor time (the best of several runs, without set-up, compilation
and output, but with supple's energy balance and checks in every step), and the largest distance between the
nodes of the two codes.

Only TETRA4 compares equal elements. Kratos integrates its HEXA8 at eight points, supple at one point with
hourglass control; Kratos also runs with one point, without hourglass control.

Kratos Multiphysics (BSD licence) is not a dependency. It needs an environment of its own:

    python -m venv kratos-env
    kratos-env/bin/pip install KratosMultiphysics KratosStructuralMechanicsApplication
    OMP_NUM_THREADS=1 python benchmarks/against_kratos.py --kratos-python kratos-env/bin/python
"""

from __future__ import annotations

import os
import sys
from argparse import ArgumentParser
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from measure import keep
from peer_process import PeerProcess

from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, Run
from supple.machine import (
    Placed,
    System,
)
from supple.mesh import CellType, Mesh, block
from supple.methods.explicit import (
    BulkViscosity,
    ExplicitEngine,
    StVenantKirchhoff,
    explicit_subdomain,
)

STEEL = Isotropic(210e9, 0.3, 7850.0)
SPIN = np.array([0.0, 0.0, 1000.0])
"""rad/s, about the centre of a block of 1 m: strains of some thousandths within the march."""
CENTRE = np.array([0.5, 0.0, 0.0])


@dataclass(frozen=True)
class Elements:
    """The elements of the block in both codes."""

    kind: CellType
    divisions: int
    theirs: str
    order: int

    @property
    def points(self) -> int:
        """Number of integration points of an element in Kratos."""
        return self.order**3 if self.kind is CellType.HEXA8 else 1


def cases(quick: bool) -> list[Elements]:
    """Blocks of about 30 000 elements, or of 1000 if quick."""
    hexahedra, tetrahedra = (10, 6) if quick else (31, 17)
    return [
        Elements(CellType.TETRA4, tetrahedra, "TotalLagrangianElement3D4N", 1),
        Elements(CellType.HEXA8, hexahedra, "TotalLagrangianElement3D8N", 2),
        Elements(CellType.HEXA8, hexahedra, "TotalLagrangianElement3D8N", 1),
    ]


class InSupple:
    """The march in supple."""

    def __init__(self, mesh: Mesh, n_steps: int) -> None:
        # Kratos' solids have no bulk viscosity.
        none = BulkViscosity(0.0, 0.0)
        model = solid_model(mesh, STEEL)
        part = explicit_subdomain(model, StVenantKirchhoff(STEEL), name="block", bulk_viscosity=none)
        self.step = 0.5 * part.step_limit
        span = Run(n_steps * self.step, n_steps * self.step, FixedStep(self.step))
        moving = Placed(part, velocity=np.cross(SPIN, -CENTRE), angular_velocity=SPIN)
        self._engine = ExplicitEngine(System([moving]), span)
        self._start, self._end = self._engine.start(0.0), span.times[-1:]
        leg = self._engine.march(self._start, self._end)  # compiles
        if leg.stopped is not None or leg.statistics.steps != n_steps:
            sys.exit(f"supple: {leg.statistics.steps} steps of {n_steps}; {leg.stopped}")
        self.places = self._engine.solution(leg).bodies["block"].nodes[-1]
        self.costs: list[tuple[float, float]] = []

    def turn(self) -> None:
        """Repeat the march."""
        began, began_wall = process_time(), perf_counter()
        self._engine.march(self._start, self._end)
        self.costs.append((process_time() - began, perf_counter() - began_wall))


class InKratos(PeerProcess):
    """The march in Kratos."""

    def __init__(self, interpreter: Path, elements: Elements, mesh: Mesh, step: float, n_steps: int) -> None:
        velocities = np.cross(SPIN, mesh.nodes - CENTRE)
        case = {
            "element": elements.theirs,
            "order": elements.order,
            "young": STEEL.youngs_modulus,
            "poisson": STEEL.poissons_ratio,
            "density": STEEL.density,
            "step": step,
            "steps": n_steps,
        }
        arrays = {"points": mesh.nodes, "cells": mesh.cells[elements.kind], "velocities": velocities}
        super().__init__(
            "Kratos", interpreter, "kratos_run.py", case, lambda at: np.savez(at / "case.npz", **arrays)
        )
        self.versions = self.ready

    @property
    def places(self) -> np.ndarray:
        """Positions (N, 3) of the nodes at the end of the last run."""
        return np.load(self.folder / "places.npy")


def rows_of(
    interpreter: Path, elements: Elements, n_steps: int, turns: int
) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Rows with the cost of both codes and the distance of their nodes; versions of Kratos' environment."""
    n = elements.divisions
    mesh = block(1.0, 1.0, 1.0, n, n, n, elements.kind)
    count = len(mesh.cells[elements.kind])
    ours = InSupple(mesh, n_steps)
    theirs = InKratos(interpreter, elements, mesh, ours.step, n_steps)
    for _ in range(turns):
        ours.turn()
        theirs.turn()
    apart = float(np.linalg.norm(ours.places - theirs.places, axis=1).max())
    theirs.close()
    strained = strain_motion(mesh.nodes, ours.places, SPIN[2] * n_steps * ours.step)
    least = {code: np.array(each.costs).min(axis=0) for code, each in (("supple", ours), ("Kratos", theirs))}
    rows = [
        {
            "element": elements.kind.name.lower(),
            "points": 1 if code == "supple" else elements.points,
            "elements": count,
            "steps": n_steps,
            "code": code,
            "million element-steps / s": count * n_steps / float(processor) / 1e6,
            "the same, wall": count * n_steps / float(wall) / 1e6,
            "of supple's processor time": float(processor / least["supple"][0]),
            "nodes apart, m": apart,
            "moved, m": float(np.linalg.norm(ours.places - mesh.nodes, axis=1).max()),
            "moved beyond the spin, m": strained,
        }
        for code, (processor, wall) in least.items()
    ]
    return rows, theirs.versions


def strain_motion(before: np.ndarray, after: np.ndarray, angle: float) -> float:
    """Largest distance of a node from its position in a rigid rotation of the block, m."""
    c, s = np.cos(angle), np.sin(angle)
    turned = (before - CENTRE) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + CENTRE
    return float(np.linalg.norm(after - turned, axis=1).max())


def main() -> None:
    parser = ArgumentParser(description="explicit elements of supple and Kratos compared")
    parser.add_argument("--kratos-python", type=Path, help="interpreter of an environment with Kratos")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--quick", action="store_true", help="1000 elements instead of 30 000")
    parser.add_argument("--json", type=Path, help="file to write; default: in benchmarks/results")
    given = parser.parse_args()
    if given.kratos_python is None:
        sys.exit(
            "this comparison needs Kratos in an environment of its own; give the interpreter by "
            "--kratos-python:\n" + (__doc__ or "").split("of its own:\n")[-1]
        )
    rows: list[dict[str, Any]] = []
    versions: dict[str, Any] = {}
    for elements in cases(given.quick):
        found, versions = rows_of(given.kratos_python.absolute(), elements, 60, given.turns)
        rows += found
    keep("against_kratos", rows, given.json, kratos=versions, one_core=True)


if __name__ == "__main__":
    if hasattr(os, "sched_setaffinity"):  # both codes, before either starts threads
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    main()
