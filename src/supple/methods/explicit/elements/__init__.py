"""Explicit finite elements: their constants, and the force of a block of elements in a step."""

from supple.methods.explicit.elements.bulk_viscosity import *
from supple.methods.explicit.elements.element_block import *
from supple.methods.explicit.elements.incidence import *
from supple.methods.explicit.elements.shell_block import *
from supple.methods.explicit.elements.solid_block import *
from supple.methods.explicit.elements.solid_points import *
