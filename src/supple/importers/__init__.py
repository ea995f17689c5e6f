"""One file format per module; every importer of a mesh ends in a Mesh."""

from supple.importers.abaqus import read_abaqus
from supple.importers.file_mesh import UnusedNodes
from supple.importers.gmsh import read_gmsh
from supple.importers.matrix_market import read_matrix
from supple.importers.mesh_file import read_mesh

__all__ = ["UnusedNodes", "read_abaqus", "read_gmsh", "read_matrix", "read_mesh"]
