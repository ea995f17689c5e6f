"""Importers: one file format per module; every mesh importer returns a Mesh."""

from supple.importers.abaqus.mesh_view import *
from supple.importers.ansys import *
from supple.importers.exodus import *
from supple.importers.file_mesh import *
from supple.importers.gmsh import *
from supple.importers.included_files import *
from supple.importers.matrices.labelled_matrix import *
from supple.importers.matrices.matrix_file import *
from supple.importers.matrices.matrix_market import *
from supple.importers.matrices.recovery_matrix import *
from supple.importers.mesh_file import *
from supple.importers.nastran.mesh_view import *
from supple.importers.node_table import *
from supple.importers.numbering import *
from supple.importers.section_csv import *
from supple.importers.section_file import *
from supple.importers.section_table import *
from supple.importers.turbine.beamdyn import *
from supple.importers.turbine.nrel5mw import *
from supple.importers.turbine.station_table import *
from supple.importers.turbine.windio import *
from supple.importers.turbine.windio_sections import *
from supple.importers.vtu import *
