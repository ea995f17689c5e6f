"""What a case, mesh or result file holds, in a few lines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rich.table import Table

from supple.cases import read_case
from supple.cli.check import print_check
from supple.cli.console import console
from supple.errors import ImportFormatError
from supple.importers import MESH_SUFFIXES, NASTRAN_SUFFIXES, read_mesh
from supple.mesh import Mesh
from supple.storage import holds_reduced_body, read_header, read_reduced_body, read_solution


def print_info(path: Path) -> None:
    """Print what the file at `path` holds: a case, mesh or result; also the check of a whole model.

    Raises
    ------
    CaseError, ImportFormatError, MeshError, ResultFileError    a file that cannot be read, or of another kind
    """
    readers = {".toml": _case, ".h5": _hdf5} | dict.fromkeys(MESH_SUFFIXES, _mesh)
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise ImportFormatError(
            f"{path}: no such kind of file is known; give one that ends in {', '.join(readers)}"
        )
    console.print(reader(path))
    if path.suffix.lower() in NASTRAN_SUFFIXES:
        print_check(path, n_frequencies=6)


def _case(path: Path) -> Table:
    case = read_case(path).tables
    table = _named(f"Case {path}", case.title)
    for body in case.body:
        basis = f", basis {body.reduction.basis}" if body.reduction else ""
        basis += ", corrects itself" if body.corrects_itself else ""
        interfaces = ", ".join(interface.name for interface in body.interface) or "none"
        table.add_row(f"body {body.name}", f"{body.kind}{basis}; interfaces: {interfaces}")
    for joint in case.joint:
        table.add_row(f"joint {joint.name or ''}", f"{joint.kind}: {joint.first} - {joint.second}")
    for load in case.load:
        table.add_row("load", f"{load.kind} at {load.at}")
    for spring in case.spring:
        table.add_row("spring", f"{spring.kind}: {spring.first} - {spring.second}")
    run = case.simulation
    table.add_row("simulation", f"{run.duration:g} s, stored every {run.output_step:g} s")
    return table


def _mesh(path: Path) -> Table:
    mesh = read_mesh(path)
    table = _named(f"Mesh {path}", f"{mesh.n_nodes} nodes")
    for kind, cells in mesh.cells.items():
        table.add_row(kind.name, f"{len(cells)} cells")
    for axis, low, high in zip("xyz", mesh.nodes.min(axis=0), mesh.nodes.max(axis=0), strict=True):
        table.add_row(axis, f"{low:g} to {high:g}")
    _add_sets(table, mesh)
    return table


def _add_sets(table: Table, mesh: Mesh) -> None:
    for name, nodes in mesh.node_sets.items():
        table.add_row(
            f"node set {name}", f"{len(nodes)} nodes, centroid {_point(mesh.nodes[nodes].mean(axis=0))}"
        )
    for name, members in mesh.cell_sets.items():
        table.add_row(f"cell set {name}", f"{sum(len(cells) for cells in members.values())} cells")


def _hdf5(path: Path) -> Table:
    return _reduced_body(path) if holds_reduced_body(path) else _result(path)


def _reduced_body(path: Path) -> Table:
    body = read_reduced_body(path)
    table = _named(f"Reduced body {path}", body.name)
    kind = "linear" if body.is_linear else "nonlinear"
    table.add_row("coordinates", f"{body.r} of {len(body.nodal_basis)} freedoms, {kind}; {body.frame}")
    table.add_row("mass", f"{body.gram[0, 0]:g}")
    table.add_row("lowest frequencies", f"{_listed(body.frequencies[:6] / (2 * np.pi))} Hz in its frame")
    if body.report.certificate is not None:
        table.add_row("eigenvalues", str(body.report.certificate))
    for interface in body.interfaces:
        table.add_row(f"interface {interface.name}", f"at {_point(interface.position)}")
    return table


def _result(path: Path) -> Table:
    header = read_header(path)
    state = (
        "complete" if header.complete else "cut off, or still running; supple run CASE --resume continues it"
    )
    table = _named(f"Result {path}", state)
    for name, value in header.metadata.items():
        table.add_row(name, str(value))
    if header.n_times:
        solution = read_solution(path)
        table.add_row("times", f"{header.n_times}, from {solution.times[0]:g} to {solution.times[-1]:g} s")
        for name, motion in solution.bodies.items():
            table.add_row(f"body {name}", f"{motion.coordinates.shape[1]} coordinates")
        for name, forces in solution.joint_forces.items():
            table.add_row(f"joint {name}", f"{forces.shape[1]} forces and moments")
    cost = header.statistics
    table.add_row("cost", f"{cost.steps} steps, {cost.iterations} iterations, {cost.seconds:.2f} s")
    return table


def _named(title: str, first: str) -> Table:
    table = Table(title=title, show_header=False)
    table.add_row("what", first)
    return table


def _point(position: np.ndarray) -> str:
    return f"({_listed(position)})"


def _listed(values: np.ndarray) -> str:
    return ", ".join(f"{value:.4g}" for value in values)
