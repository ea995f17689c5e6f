"""Machines in motion for ParaView and other programs that are built on VTK."""

from supple.export.vtk.vtkhdf import *
from supple.export.vtk.vtu import *
