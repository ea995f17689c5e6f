"""Size of a report and the time to write it: the blade over 20 s, and a large mesh in many modes.

    OMP_NUM_THREADS=1 python benchmarks/report_page.py RESULT [--json FILE]

RESULT is the result of `supple run examples/blade.toml`: results/blade/blade.h5. The large mesh is a plate of
80 000 triangles in 50 synthetic modes over 1000 output times, each mode with its own frequency. Seconds are
processor time, from the motion to the file; the error is that of the stored shapes, relative to the largest
displacement.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from measure import keep, measured

from supple.cases.result_machine import result_machine
from supple.mesh import skin_of, strip
from supple.mesh.feature_edges import feature_edges
from supple.quantities import deflections, observer_of
from supple.report import write_report
from supple.report.moving_body import DISPLACEMENT_TOLERANCE, MovingBody, moving_body
from supple.report.moving_machine import FieldScale, MovingMachine
from supple.report.nodal_shapes import nodal_shapes
from supple.report.page import Page, write_page
from supple.report.visible_surface import VisibleSurface
from supple.results.body_surface import SurfacePoints
from supple.storage import read_solution

CELLS, MODES, INSTANTS, SAMPLED = 200, 50, 1000, 50


def blade(result: Path, page: Path) -> dict[str, Any]:
    """The page of a run on disk."""
    found = result_machine(result)
    solution, looks = read_solution(result), found.case.page_looks
    cost, _ = measured(lambda: write_report(page, found.system, solution, looks, bases=found.case.bases), 3)
    body, part = found.system.placed("blade").body, solution.at(np.arange(0, len(solution.times), SAMPLED))
    drawn = moving_body(found.system, part, body, looks["blade"], colourings={}, bases=found.case.bases)
    assert drawn.displacement is not None
    seen_from = observer_of(found.system, part, "blade", found.case.bases)
    exact = deflections(body, part.bodies["blade"], seen_from)[:, drawn.surface.points.nodes]
    return row(page, len(drawn.surface.triangles), len(solution.times), cost, drawn, exact)


def plate(page: Path) -> dict[str, Any]:
    """The page of a plate in bending and in-plane modes that fewer shapes cannot represent."""
    mesh = strip(2.0, 2.0, CELLS, CELLS)
    triangles, (x, y) = skin_of(mesh).triangles, mesh.nodes[:, :2].T / 2 * np.pi
    numbers = sorted((i * i + j * j, i, j) for i in range(1, 12) for j in range(1, 12))[:MODES]
    shapes = np.stack(
        [
            np.column_stack(
                [
                    0.02 * np.cos(i * x) * np.sin(j * y),
                    0.02 * np.sin(i * x) * np.cos(j * y),
                    np.sin(i * x) * np.sin(j * y),
                ]
            )
            for _, i, j in numbers
        ]
    )
    times, rate = np.linspace(0.0, 10.0, INSTANTS), np.array([each[0] for each in numbers])
    phases = np.random.default_rng(0).uniform(0, 2 * np.pi, MODES)
    amplitudes = np.sin(2 * np.outer(times, rate) + phases) / rate

    def write() -> MovingBody:
        blocks = (np.tensordot(amplitudes[first : first + 16], shapes, 1) for first in range(0, INSTANTS, 16))
        displacement = nodal_shapes(blocks, tolerance=DISPLACEMENT_TOLERANCE)
        surface = VisibleSurface(SurfacePoints.of_nodes(np.arange(mesh.n_nodes)), triangles)
        still, axes = np.zeros((INSTANTS, 3)), np.tile(np.eye(3), (INSTANTS, 1, 1))
        edges = feature_edges(mesh.nodes, triangles)
        body = MovingBody(
            "plate",
            "reduced",
            "its frame",
            mesh.nodes,
            mesh.node_ids,
            surface,
            edges,
            still,
            axes,
            displacement,
        )
        scales = {"deflection": FieldScale("deflection (m)", 1.0, 0.0, body.largest_displacement)}
        low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
        machine = MovingMachine(times, [body], [], [], [], [], scales, low, high, np.eye(3)[2], 1.0)
        write_page(page, Page("plate", [], machine))
        return body

    cost, drawn = measured(write, 1)
    exact = np.tensordot(amplitudes[::SAMPLED], shapes, 1)
    return row(page, len(triangles), INSTANTS, cost, drawn, exact)


def row(
    page: Path, triangles: int, instants: int, cost: dict[str, Any], drawn: MovingBody, exact: np.ndarray
) -> dict[str, Any]:
    """Size, cost and error; exact : (t, N, 3) at some of the output times."""
    assert drawn.displacement is not None
    step = len(drawn.displacement.amplitudes) // len(exact)
    found = np.tensordot(drawn.displacement.amplitudes[::step][: len(exact)], drawn.displacement.shapes, 1)
    error = float(np.abs(found - exact).max() / np.linalg.norm(exact, axis=2).max())
    return {
        "page": page.stem,
        "triangles": triangles,
        "instants": instants,
        "shapes": len(drawn.displacement.shapes),
        "MB": page.stat().st_size / 1e6,
        **cost,
        "error": error,
    }


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("result", type=Path)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    with TemporaryDirectory() as folder:
        rows = [blade(given.result, Path(folder) / "blade.html"), plate(Path(folder) / "plate.html")]
    keep("report_page", rows, given.json)


if __name__ == "__main__":
    main()
