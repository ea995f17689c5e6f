"""Explicit finite elements: what is constant, and the force of a block in a step."""

from supple.explicit.elements.bulk_viscosity import *
from supple.explicit.elements.element_stress import *
from supple.explicit.elements.hourglass import *
from supple.explicit.elements.incidence import *
from supple.explicit.elements.mean_gradient import *
from supple.explicit.elements.shell_block import *
from supple.explicit.elements.solid_block import *
from supple.explicit.elements.stable_step import *
