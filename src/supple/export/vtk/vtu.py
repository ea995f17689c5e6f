"""A machine at one output time as a VTU file (VTK XML, UnstructuredGrid).

Source: VTK file formats, XML formats, https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from types import MappingProxyType
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from supple.arguments import checked_arguments
from supple.errors import ModelError
from supple.export.vtk.cells import joined
from supple.export.vtk.fields import GHOSTS, fields_of
from supple.export.vtk.pieces import pieces_of
from supple.fem import FiniteElementModel
from supple.integrate import Solution
from supple.machine import At, System
from supple.mesh import Mesh
from supple.simulation.recorded_columns import check_motions
from supple.storage.atomic_write import replacing
from supple.units import UNNAMED, UnitSystem

__all__ = ["write_vtu"]

_KINDS = {"f4": "Float32", "f8": "Float64", "u1": "UInt8", "i4": "Int32", "i8": "Int64"}


@checked_arguments
def write_vtu(
    path: Path | str,
    system: System,
    instant: Solution,
    meshes: Mapping[str, Mesh] = MappingProxyType({}),
    *,
    elements: Mapping[str, FiniteElementModel] = MappingProxyType({}),
    bodies: Collection[str] | None = None,
    bases: Mapping[str, At] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> Path:
    """Write a machine at one output time as VTU (`.vtu`); returns the path.

    Points and fields are those of `write_vtkhdf`; deleted elements are left out.

    instant : Solution      with one output time: `solution.at([-1])`, an equilibrium, or a phase of a mode

    Other parameters and errors as for `write_vtkhdf`; also ModelError for several output times.
    """
    path = Path(path)
    if path.suffix.lower() != ".vtu":
        raise ModelError(f"cannot write {path}: the name of a VTU file must end in .vtu; change the path")
    if len(instant.times) != 1:
        raise ModelError(
            f"cannot write {path}: a .vtu file holds one output time and {len(instant.times)} are given; "
            "choose one, such as solution.at(np.array([-1])), or write .vtkhdf"
        )
    check_motions(system, instant)
    pieces = pieces_of(system, meshes, bodies)
    positions = {piece: piece.positions(instant) for piece in pieces}
    fields = fields_of(system, pieces, elements, bases, units)
    arrays = {field: field.values(instant, positions)[0] for field in fields}
    cells = joined([piece.cells for piece in pieces], [len(piece.points) for piece in pieces])
    shown = np.ones(len(cells.types), dtype=bool)
    for field, values in arrays.items():
        if field.name == GHOSTS:
            shown &= values == 0
    numbers = [np.full(len(piece.cells.types), k, np.int32) for k, piece in enumerate(pieces)]
    left = cells.of_some(shown)
    sections = {
        "PointData": {field.name: values for field, values in arrays.items() if not field.of_cells},
        "CellData": {
            "body": np.concatenate(numbers)[shown],
            **{
                field.name: values[shown]
                for field, values in arrays.items()
                if field.of_cells and field.name != GHOSTS
            },
        },
        "Points": {"points": np.concatenate([piece.points for piece in pieces])},
        "Cells": {"connectivity": left.nodes, "offsets": left.offsets[1:], "types": left.types},
    }
    with replacing(path) as temporary:
        temporary.write_bytes(_file(sections, len(sections["Points"]["points"]), len(left.types)))
    return path


def _file(sections: Mapping[str, Mapping[str, NDArray]], n_points: int, n_cells: int) -> bytes:
    """The bytes of the file: XML that describes the arrays, then for each array its size and its data."""
    lines, data, offset = [], [], 0
    for section, arrays in sections.items():
        lines.append(f"<{section}>")
        for name, values in arrays.items():
            little = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
            width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""
            kind = _KINDS[f"{little.dtype.kind}{little.dtype.itemsize}"]
            what = f'type="{kind}" Name={quoteattr(name)}{width}'
            lines.append(f'<DataArray {what} format="appended" offset="{offset}"/>')
            data += [np.uint64(little.nbytes).astype("<u8").tobytes(), little.tobytes()]
            offset += 8 + little.nbytes
        lines.append(f"</{section}>")
    head = (
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
        f'header_type="UInt64">\n<UnstructuredGrid>\n<Piece NumberOfPoints="{n_points}" '
        f'NumberOfCells="{n_cells}">\n'
    )
    tail = '\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding="raw">\n_'
    return b"".join([(head + "\n".join(lines) + tail).encode(), *data, b"\n</AppendedData>\n</VTKFile>\n"])
