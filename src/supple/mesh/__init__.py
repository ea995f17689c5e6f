"""Meshes: nodes, cells and named sets, checked on entry; parametric shapes."""

from supple.mesh.airfoil_section import *
from supple.mesh.blade_loft import *
from supple.mesh.blade_stations import *
from supple.mesh.cell_type import *
from supple.mesh.connecting_rod import *
from supple.mesh.cuboids import *
from supple.mesh.cylinder import *
from supple.mesh.division import *
from supple.mesh.mesh import *
from supple.mesh.mesh_part import *
from supple.mesh.plate import *
from supple.mesh.quadratic import *
from supple.mesh.section_geometry import *
from supple.mesh.skin import *
