"""Export of linear bodies to other programs: superelements, and bodies in floating frames."""

from supple.export.superelements.abaqus_matrices import *
from supple.export.superelements.beamdyn import *
from supple.export.superelements.extptfm import *
from supple.export.superelements.interface_form import *
from supple.export.superelements.mbdyn_modal import *
from supple.export.superelements.modal_equations import *
from supple.export.superelements.nastran_superelement import *
from supple.export.superelements.standard_input_data import *
from supple.export.superelements.stated_frequencies import *
