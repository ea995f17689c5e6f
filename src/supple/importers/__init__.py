"""One file format per module; every importer of a mesh ends in a Mesh."""

from supple.importers.abaqus import read_abaqus
from supple.importers.connection import Connection
from supple.importers.file_mesh import UnusedNodes
from supple.importers.gmsh import read_gmsh
from supple.importers.included_files import files_read_with
from supple.importers.matrices.labelled_matrix import LabelledMatrix, MatrixRole, freedom_name
from supple.importers.matrices.matrix_file import (
    HDF5_SUFFIXES,
    NODE_SUFFIXES,
    read_labelled_matrix,
    read_nodes,
)
from supple.importers.matrices.matrix_market import read_matrix
from supple.importers.mesh_file import MESH_SUFFIXES, read_mesh
from supple.importers.nastran.model import NASTRAN_SUFFIXES, NastranModel, read_nastran
from supple.importers.nastran.properties import (
    BeamProperty,
    ElasticMaterial,
    ShellProperty,
    SolidProperty,
)
from supple.importers.node_table import NodeTable
from supple.importers.numbering import numbers_of
from supple.importers.turbine.nrel5mw import (
    NREL5MW_WEBS,
    WU2019_GRID,
    nrel5mw_rotor,
    nrel5mw_stations,
)
from supple.importers.turbine.rotor_table import read_polar, read_rotor
from supple.importers.turbine.station_table import read_stations
from supple.importers.turbine.windio import read_windio_blade

__all__ = [
    "HDF5_SUFFIXES",
    "MESH_SUFFIXES",
    "NASTRAN_SUFFIXES",
    "NODE_SUFFIXES",
    "NREL5MW_WEBS",
    "WU2019_GRID",
    "BeamProperty",
    "Connection",
    "ElasticMaterial",
    "LabelledMatrix",
    "MatrixRole",
    "NastranModel",
    "NodeTable",
    "ShellProperty",
    "SolidProperty",
    "UnusedNodes",
    "files_read_with",
    "freedom_name",
    "nrel5mw_rotor",
    "nrel5mw_stations",
    "numbers_of",
    "read_abaqus",
    "read_gmsh",
    "read_labelled_matrix",
    "read_matrix",
    "read_mesh",
    "read_nastran",
    "read_nodes",
    "read_polar",
    "read_rotor",
    "read_stations",
    "read_windio_blade",
]
