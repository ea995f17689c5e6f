"""Export of bodies and machines to other codes, one module per format."""

from supple.export.dmig_punch import *
from supple.export.exudyn import *
from supple.export.static_deck import *
from supple.export.superelements import *
from supple.export.tables import *
from supple.export.vtk import *
