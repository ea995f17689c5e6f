"""Dual coupling of sub-domains at rest in space: multipliers on velocities, several time steps."""

from supple.methods.explicit.coupling.chosen_scheme import *
from supple.methods.explicit.coupling.dual_march import *
from supple.methods.explicit.coupling.interface_operator import *
from supple.methods.explicit.coupling.multi_time_step import *
from supple.methods.explicit.coupling.sides import *
