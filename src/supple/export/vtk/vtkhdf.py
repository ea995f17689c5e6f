"""The motion of a machine as one VTKHDF file for ParaView.

The format is VTKHDF 2.0, an UnstructuredGrid with one partition per body. Cells and points are stored once;
`PointData` and `CellData` have rows for each output time, with the partitions one after another. VTK 9.3 to
9.7 reads it. Collections of named blocks are not used: VTK reads them only from 9.4 on, and VTK 9.7 reads
their first time only. The cell array `body` is the index of a name in the field data `bodies`.

Source: VTK file formats, VTKHDF, https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/index.html
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import h5py
import numpy as np

from supple.arguments import checked_arguments
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.export.vtk.fields import Field, fields_of
from supple.export.vtk.pieces import Piece, pieces_of
from supple.fem import FiniteElementModel
from supple.integrate import Solution
from supple.machine import At, System
from supple.mesh import Mesh
from supple.simulation.recorded_columns import check_motions
from supple.storage import ResultParts
from supple.storage.atomic_write import replacing, reserve_space
from supple.units import UNNAMED, UnitSystem

__all__ = ["write_vtkhdf"]


_BLOCK_NUMBERS = 2**22
"""Numbers of a field that are computed and written at a time (32 MiB)."""
_HEADERS = 2**16
"""Largest size of the file headers of the arrays, bytes."""


@checked_arguments
def write_vtkhdf(
    path: Path | str,
    system: System,
    run: Solution | ResultParts,
    meshes: Mapping[str, Mesh] = MappingProxyType({}),
    *,
    elements: Mapping[str, FiniteElementModel] = MappingProxyType({}),
    bodies: Collection[str] | None = None,
    bases: Mapping[str, At] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> Path:
    """Write the motion of a machine as VTKHDF (`.vtkhdf`); returns the path.

    Points are those of the assembled, undeformed machine; `displacement` is the vector from there to the
    position at the output time. `deflection` is the displacement relative to the rigid motion of the body's
    first interface, in global components. Field values are in single precision, and NaN for bodies without
    the field.

    Parameters
    ----------
    run : Solution | ResultParts    the output times to write; parts of a result file are read one at a time
    meshes : meshes of elastic bodies, by name; a body without one is written as points
    elements : finite element models of these bodies, by name, to write their von Mises stress too
    bodies : names of the bodies to write, without joints; by default all bodies and joints
    bases : by body, the interface relative to which its deflection is written; by default its first interface
    units : units of the model, for the names of the fields and the unit of stress

    Raises
    ------
    ModelError          no output time, another suffix, an unknown body, a mesh of another body; also as in
                        `stress_modes`
    ResultFileError     the file cannot be written (a full disk), or the result file of the run cannot be read
    """
    path = Path(path)
    if path.suffix.lower() != ".vtkhdf":
        raise ModelError(
            f"cannot write {path}: ParaView recognises VTKHDF by its suffix; end the path in .vtkhdf"
        )
    if not len(run.times):
        raise ModelError(f"cannot write {path}: no output time is selected; select at least one")
    if isinstance(run, Solution):  # parts of a file are checked against the bodies when the file is opened
        check_motions(system, run)
    pieces = pieces_of(system, meshes, bodies)
    fields = fields_of(system, pieces, elements, bases, units)
    with replacing(path) as temporary:
        # Built in memory, then extended in reserved space: a failed write crashes HDF5 (reserve_space).
        with h5py.File("image", "w", driver="core", backing_store=False) as file:
            group = file.create_group("VTKHDF")
            _write_grid(group, pieces)
            _write_steps(group, np.asarray(run.times), pieces, fields)
            n_bytes = 0
            for field in fields:
                n_rows = len(run.times) * sum(map(field.n_rows, pieces))
                shape = (n_rows,) if field.width == 1 else (n_rows, field.width)
                # Not yet allocated.
                n_bytes += group.create_dataset(f"{field.section}/{field.name}", shape, field.kind).nbytes
            file.flush()
            temporary.write_bytes(file.id.get_file_image())
        reserve_space(temporary, temporary.stat().st_size + n_bytes + _HEADERS)
        with h5py.File(temporary, "r+") as file:
            begun = 0
            for part in _short_parts(run, pieces):
                positions = {piece: piece.positions(part) for piece in pieces}
                for field in fields:
                    values = field.values(part, positions)
                    rows = values.reshape(-1, *values.shape[2:])
                    start = begun * values.shape[1]
                    file[f"VTKHDF/{field.section}/{field.name}"][start : start + len(rows)] = rows
                begun += len(part.times)
    return path


def _write_grid(group: h5py.Group, pieces: Sequence[Piece]) -> None:
    group.attrs["Version"] = np.array([2, 0])
    group.attrs.create("Type", np.bytes_("UnstructuredGrid"))
    group["NumberOfPoints"] = [len(piece.points) for piece in pieces]
    group["NumberOfCells"] = [len(piece.cells.types) for piece in pieces]
    group["NumberOfConnectivityIds"] = [len(piece.cells.nodes) for piece in pieces]
    group["Points"] = np.concatenate([piece.points for piece in pieces])
    group["Types"] = np.concatenate([piece.cells.types for piece in pieces])
    group["Offsets"] = np.concatenate([piece.cells.offsets for piece in pieces])
    group["Connectivity"] = np.concatenate([piece.cells.nodes for piece in pieces])
    numbers = [np.full(len(piece.cells.types), k, np.int32) for k, piece in enumerate(pieces)]
    group["CellData/body"] = np.concatenate(numbers)
    # VTK reads ASCII strings only.
    names = [piece.name.encode("ascii", "replace").decode() for piece in pieces]
    group.create_dataset("FieldData/bodies", data=names, dtype=h5py.string_dtype("ascii"))


def _write_steps(
    group: h5py.Group, times: FloatArray, pieces: Sequence[Piece], fields: Sequence[Field]
) -> None:
    n_times = len(times)
    still = np.zeros(n_times, dtype=np.int64)
    steps = group.create_group("Steps")
    steps.attrs["NSteps"] = n_times
    steps["Values"] = times
    steps["NumberOfParts"] = np.full(n_times, len(pieces))
    for name in ("PartOffsets", "PointOffsets"):
        steps[name] = still
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        steps[name] = still[:, None]
    steps["CellDataOffsets/body"] = still
    steps["FieldDataOffsets/bodies"] = still
    steps["FieldDataSizes/bodies"] = np.tile([1, len(pieces)], (n_times, 1))
    for field in fields:
        n_rows = sum(map(field.n_rows, pieces))
        steps[f"{field.section}Offsets/{field.name}"] = n_rows * np.arange(n_times)


def _short_parts(run: Solution | ResultParts, pieces: Sequence[Piece]) -> Iterator[Solution]:
    """The run split into parts whose positions fit in memory."""
    n_times = max(1, _BLOCK_NUMBERS // (3 * sum(len(piece.points) for piece in pieces)))
    for part in (run,) if isinstance(run, Solution) else run:
        for start in range(0, len(part.times), n_times):
            yield part.at(slice(start, start + n_times))
