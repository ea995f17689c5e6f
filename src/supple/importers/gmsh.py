"""Gmsh meshes (.msh, formats 2 and 4, text or binary)."""

from __future__ import annotations

import codecs
import re
from pathlib import Path

from supple.arguments import checked_arguments
from supple.errors import ImportFormatError
from supple.importers.cell_file import cell_file_mesh
from supple.importers.file_mesh import UnusedNodes
from supple.importers.gmsh_file import read_gmsh_file
from supple.importers.text_file import file_content
from supple.mesh import Mesh

__all__ = ["read_gmsh"]


@checked_arguments
def read_gmsh(
    path: str | Path, *, only: str | None = None, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> Mesh:
    """Mesh of a Gmsh file: its cells of the highest dimension, and its physical groups as sets.

    Every physical group becomes a node set; those of the highest dimension are cell sets, too. A group
    without a name is called after its dimension and tag, as in 'surface 7'. Quadrilaterals and surfaces of
    second order become triangles over all their nodes; nodes inside faces and cells of second order (of
    hexahedra with 27 nodes, say) are left out. A cell that the file repeats, once for each of its groups
    (format 2), is read once.

    Parameters
    ----------
    path : str or Path
    only : str or None            a physical group: read its cells and nodes alone; None reads everything
    unused_nodes : UnusedNodes    REFUSE or DROP nodes that no cell uses, such as the centres of arcs
    Returns
    -------
    Mesh   nodes in the order of the file
    Raises
    ------
    ImportFormatError   missing, cut or unreadable file, unknown cell type, cells naming missing nodes
    MeshError           what the file describes is no usable mesh
    """
    path = Path(path)
    text = _whole_text(path)
    names = _physical_names(path, text)
    read = read_gmsh_file(path, text.encode("latin-1"))
    return cell_file_mesh(path, read, names, only=only, unused_nodes=unused_nodes)


def _whole_text(path: Path) -> str:
    """The file, bytes taken as characters; ImportFormatError when it is missing or cut short."""
    text = file_content(path).removeprefix(codecs.BOM_UTF8).decode("latin-1")
    for section in ("MeshFormat", "Nodes", "Elements"):
        start = text.find(f"${section}")
        if start < 0:
            raise ImportFormatError(f"{path}: no ${section} section; is this a Gmsh mesh, and whole?")
        if f"$End{section}" not in text:
            raise ImportFormatError(
                f"{path}, line {_line(text, start)}: ${section} has no $End{section}; the file is cut short"
            )
    return text


def _physical_names(path: Path, text: str) -> dict[tuple[int, int], str]:
    """Names of the physical groups by dimension and tag."""
    section = re.search(r"\$PhysicalNames\s(.*?)\$EndPhysicalNames", text, flags=re.DOTALL)
    names: dict[tuple[int, int], str] = {}
    if section is None:
        return names
    for found in re.finditer(r'^\s*([0-3])\s+([0-9]{1,18})\s+"(.*)"', section[1], flags=re.MULTILINE):
        name = found[3].encode("latin-1").decode("utf-8", errors="replace")
        # A set has one name: of two groups the first would vanish.
        if name in names.values():
            raise ImportFormatError(
                f"{path}, line {_line(text, section.start(1) + found.start(3))}: a second physical group is "
                f"named '{name}'; give each group a name of its own"
            )
        names[int(found[1]), int(found[2])] = name
    return names


def _line(text: str, place: int) -> int:
    return text.count("\n", 0, place) + 1
