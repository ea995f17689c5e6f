"""Export of a machine's motion to ParaView and other programs based on VTK."""

from supple.export.vtk.vtkhdf import *
from supple.export.vtk.vtu import *
