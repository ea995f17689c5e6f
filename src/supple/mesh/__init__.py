"""Meshes: nodes, cells and named sets, checked on entry; parametric shapes."""

from supple.mesh.airfoil_section import AirfoilSection, TrailingEdge
from supple.mesh.blade_loft import BladeGrid, ShearWebs, loft_blade
from supple.mesh.blade_stations import BladeStations
from supple.mesh.block import block
from supple.mesh.box_beam import box_beam
from supple.mesh.cell_type import CellType
from supple.mesh.connecting_rod import Eye, RodCells, RodOutline, connecting_rod
from supple.mesh.cylinder import cylinder
from supple.mesh.cylinder_shell import cylinder_shell
from supple.mesh.division import AlongAxis, ByCellSets, Cut, DividedMesh, Division, divided
from supple.mesh.mesh import Mesh
from supple.mesh.mesh_part import MeshPart, mesh_part
from supple.mesh.plate import plate
from supple.mesh.quadratic import to_quadratic
from supple.mesh.strip import strip

__all__ = [
    "AirfoilSection",
    "AlongAxis",
    "BladeGrid",
    "BladeStations",
    "ByCellSets",
    "CellType",
    "Cut",
    "DividedMesh",
    "Division",
    "Eye",
    "Mesh",
    "MeshPart",
    "RodCells",
    "RodOutline",
    "ShearWebs",
    "TrailingEdge",
    "block",
    "box_beam",
    "connecting_rod",
    "cylinder",
    "cylinder_shell",
    "divided",
    "loft_blade",
    "mesh_part",
    "plate",
    "strip",
    "to_quadratic",
]
