"""One file format per module; every importer of a mesh ends in a Mesh."""

from supple.importers.abaqus import read_abaqus
from supple.importers.file_mesh import UnusedNodes
from supple.importers.gmsh import read_gmsh
from supple.importers.matrix_market import read_matrix
from supple.importers.mesh_file import read_mesh
from supple.importers.nrel5mw import (
    NREL5MW_WEBS,
    WU2019_GRID,
    nrel5mw_rotor,
    nrel5mw_stations,
)
from supple.importers.rotor_table import read_polar, read_rotor
from supple.importers.station_table import read_stations
from supple.importers.windio import read_windio_blade

__all__ = [
    "NREL5MW_WEBS",
    "WU2019_GRID",
    "UnusedNodes",
    "nrel5mw_rotor",
    "nrel5mw_stations",
    "read_abaqus",
    "read_gmsh",
    "read_matrix",
    "read_mesh",
    "read_polar",
    "read_rotor",
    "read_stations",
    "read_windio_blade",
]
